/* The calls of models.js as promises: in a worker, so that the page never waits, or, where no worker can be started, here. */
import { startModels } from "./models.js";

const makeWorker = (text) => new Worker(URL.createObjectURL(new Blob([text], { type: "text/javascript" })));

function promises(worker) {
  const waiting = new Map();
  let next = 1;
  worker.onmessage = ({ data: { number, result, failed } }) => {
    const { done, fail } = waiting.get(number);
    waiting.delete(number);
    if (failed === undefined) done(result); else fail(new Error(failed));
  };
  return (name, ...values) => new Promise((done, fail) => {
    waiting.set(next, { done, fail });
    worker.postMessage({ number: next++, name, values });
  });
}

/* What a dead worker leaves unanswered ends in one error, that of its start. */
const started = (worker, ask, modules) => new Promise((done, fail) => {
  worker.onerror = (event) => { event.preventDefault?.(); fail(new Error(event.message ?? "no worker")); };
  ask("start", modules).then(done, fail);
});

export async function startRemote(text, modules, onBusy) {
  let ask;
  try {
    const worker = makeWorker(text);
    ask = promises(worker);
    await started(worker, ask, modules);
  } catch {
    const calls = await startModels(modules);
    let last = Promise.resolve();
    ask = (name, ...values) => (last = last.catch(() => undefined).then(() => calls[name](...values)));
  }
  let busy = 0;
  const counted = async (name, ...values) => {
    onBusy(++busy);
    try { return await ask(name, ...values); } finally { onBusy(--busy); }
  };
  /* Not "then": it is no promise itself. */
  return new Proxy({}, { get: (_, name) => (name === "then" ? undefined : (...values) => counted(name, ...values)) });
}
