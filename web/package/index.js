/* norma-mesh in browsers, workers and bundles: surface normals of meshes. The C library as WebAssembly. */
import { connect } from "./remote.js";

export { NormaError } from "./arguments.js";
export { load } from "./load-web.js";

/* The same calls as promises, in a worker. */
export const loadWorker = async (source, options) =>
  connect(new Worker(new URL("./worker.js", import.meta.url), { type: "module" }), source, options);
