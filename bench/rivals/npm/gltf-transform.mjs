/* A GLB with flat normals by gltf-transform, file to file: what one would run instead of `norma compute --flat`.
 *   node bench/rivals/npm/gltf-transform.mjs NODE_MODULES IN.glb OUT.glb */
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [modules, input, output] = process.argv.slice(2);
const { Logger, NodeIO } = await import(pathToFileURL(resolve(join(modules, "@gltf-transform/core/dist/index.js"))));
const { normals, unweld } = await import(pathToFileURL(resolve(join(modules, "@gltf-transform/functions/dist/index.js"))));
const io = new NodeIO();
const document = await io.read(input);
document.setLogger(new Logger(Logger.Verbosity.ERROR));
await document.transform(unweld(), normals({ overwrite: true }));
await io.write(output, document);
