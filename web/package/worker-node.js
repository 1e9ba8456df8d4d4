/* The worker's side in node, Deno and Bun. */
import { parentPort } from "node:worker_threads";
import { load } from "./load-node.js";
import { serve } from "./serve.js";

serve({ postMessage: (message, transfer) => parentPort.postMessage(message, transfer), set onmessage(listen) { parentPort.on("message", (data) => listen({ data })); } }, load);
