/* norma-mesh/normals: normals of faces, vertices and corners, split, tangents and normal matrices alone, with the bits of norma-mesh: a module of less than half the size, made small
 * instead of fast. It lies in the script, so that nothing else is fetched. */
import { bindCalls } from "./calls.js";
import { decode } from "./heap.js";
import text from "./normals-text.js";

const inflate = (bytes) => new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();

async function open() {
  const { instance } = await WebAssembly.instantiate(await inflate(decode(text)), {});
  const { version, faceNormals, vertexNormals, cornerNormals, split, tangents, normalMatrix, normalMatrices } = bindCalls(instance.exports);
  return { version, faceNormals, vertexNormals, cornerNormals, split, tangents, normalMatrix, normalMatrices };
}

let first = null;
export const load = () => (first ??= open().catch((error) => { first = null; throw error; }));      // it may be asked for again

export { NormaError } from "./arguments.js";
