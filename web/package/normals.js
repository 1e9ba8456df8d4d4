/* norma-mesh/normals: normals of faces, vertices and corners, split, tangents and normal matrices alone, with the bits of norma-mesh: a module of a third of the size, made small
 * instead of fast, and without what few ask for. It lies in the script, so that nothing else is fetched. */
import { fail } from "./arguments.js";
import { bindMeshCalls } from "./calls.js";
import { decode } from "./heap.js";
import text from "./normals-text.js";

const inflate = (bytes) => new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();

const refuse = ({ weight, weld, mode }) => {
  const leftOut = { weight: weight === "visible", weld: typeof weld === "number", mode: mode === "steady" };
  for (const [name, value] of Object.entries({ weight, weld, mode })) if (leftOut[name]) fail(`${name}: ${JSON.stringify(value)} is left out of norma-mesh/normals; norma-mesh has it`);
};

async function open() {
  const { instance } = await WebAssembly.instantiate(await inflate(decode(text)), {});
  return bindMeshCalls(instance.exports, refuse).calls;
}

let first = null;
export const load = () => (first ??= open().catch((error) => { first = null; throw error; }));      // it may be asked for again

export { NormaError } from "./arguments.js";
