/* norma-mesh in node, Deno and Bun. */
import { Worker } from "node:worker_threads";
import { connect } from "./remote.js";

export { NormaError } from "./arguments.js";
export { load } from "./load-node.js";

/* The same calls as promises, in a worker thread. */
export const loadWorker = async (source, options) => connect(new Worker(new URL("./worker-node.js", import.meta.url)), source, options);
