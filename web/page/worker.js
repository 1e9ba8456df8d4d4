/* The worker: calls of models.js, one after another. */
import { buffersIn, startModels } from "./models.js";

let calls = null, last = Promise.resolve();

async function answer({ number, name, values }) {
  try {
    if (name === "start") { calls = startModels(values[0]); await calls; postMessage({ number }); return; }
    const result = await (await calls)[name](...values);
    postMessage({ number, result }, buffersIn(result));
  } catch (error) {
    postMessage({ number, failed: error.message });
  }
}

onmessage = ({ data }) => { last = last.then(() => answer(data)); };
