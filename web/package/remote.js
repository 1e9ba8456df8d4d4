/* The calls as promises, answered by a worker. Arrays that go there are copied, or handed over with `transfer: true`; out is always handed over, and what comes back lies in its memory. */
import { NormaError, fail, options as checkOptions } from "./arguments.js";

const CALLS = ["faceNormals", "vertexNormals", "cornerNormals", "split", "tangents", "normalMatrix", "normalMatrices", "matrixInfo", "transformNormals", "encodeNormals", "decodeNormals", "encodingErrorDeg"];

const isOptions = (value) => typeof value === "object" && value !== null && !ArrayBuffer.isView(value) && !Array.isArray(value) && !("array" in value);

/* What is posted instead of an array: itself where it is handed over or shared, else a copy of what it shows, which is then handed over. */
const copyOf = (array) => Object.getPrototypeOf(Uint8Array.prototype).slice.call(array); // a Buffer's own slice copies nothing
function post(array, handOver, buffers) {
  const { buffer } = array;
  if (!(buffer instanceof ArrayBuffer)) return array;
  const sent = handOver ? array : copyOf(array);
  buffers.add(sent.buffer);
  return sent;
}

function pack(args) {
  const buffers = new Set(), options = args.findLast(isOptions), handOver = options?.transfer;
  if (handOver !== undefined && typeof handOver !== "boolean") fail(`transfer: ${String(handOver)} is neither true nor false`);
  const packed = args.map((value) => {
    if (ArrayBuffer.isView(value)) return post(value, handOver, buffers);
    if (value === options && options) {
      const { transfer, ...rest } = options;
      if (ArrayBuffer.isView(rest.out)) rest.out = post(rest.out, true, buffers);
      return rest;
    }
    if (value && typeof value === "object" && ArrayBuffer.isView(value.array)) return { ...value, array: post(value.array, handOver, buffers) };
    return value;
  });
  return { packed, buffers: [...buffers] };
}

/* worker: of a browser, or of node. source, check, draco, tool: as load takes them; the latter three may be functions that give bytes. */
export async function connect(worker, source, options) {
  const modules = checkOptions(options, "check draco tool"), waiting = new Map();
  let next = 0, ended = null;
  const end = (reason) => {
    ended = reason;
    for (const { fail } of waiting.values()) fail(reason);
    waiting.clear();
  };
  const answer = ({ id, value, error, wanted }) => {
    if (wanted) { sendModule(wanted); return; }
    if (!waiting.has(id)) return; // ended meanwhile
    const { done, fail } = waiting.get(id);
    waiting.delete(id);
    if (!waiting.size) worker.unref?.();
    if (error) fail(new NormaError(error.message, error.result));
    else done(value);
  };
  if (worker.on) {
    worker.on("message", answer);
    worker.on("error", end);
    worker.unref();
  } else {
    worker.onmessage = ({ data }) => answer(data);
    worker.onerror = (event) => end(new NormaError(`loadWorker: the worker failed: ${event.message ?? "its script could not be loaded"}`));
  }

  const send = (call, args, buffers) => new Promise((done, fail) => {
    if (ended) { fail(ended); return; }
    waiting.set(next, { done, fail });
    worker.ref?.();
    try {
      worker.postMessage({ id: next++, call, args }, buffers);
    } catch (error) {
      waiting.delete(next - 1);
      fail(error);
    }
  });
  const ask = async (call, args) => {
    const { packed, buffers } = pack(args);
    return send(call, packed, buffers);
  };

  const sendModule = (name) => modules[name]().then((bytes) => send("send", [name, bytes], []), (error) => send("send", [name, null, error.message], [])).catch(() => undefined); // ended meanwhile
  const sendable = (module) => (typeof module === "function" ? true : module instanceof URL ? String(module) : module);
  const version = await send("load", [source instanceof URL ? String(source) : source, { check: sendable(modules.check), draco: sendable(modules.draco), tool: sendable(modules.tool) }], []).catch((error) => {
    worker.terminate();
    throw error;
  });

  const plan = async (...args) => {
    const made = await ask("plan", args);
    return { count: made.count, bytes: made.bytes, update: (...given) => ask("update", [made.plan, ...given]), free: () => send("free", [made.plan], []) };
  };
  return {
    version, plan,
    ...Object.fromEntries(CALLS.map((call) => [call, (...args) => ask(call, args)])),
    ...Object.fromEntries(["check", "fix", "compute", "info"].map((call) => [call, async (...args) => {
      const bytes = Object.prototype.toString.call(args[0]) === "[object ArrayBuffer]" ? new Uint8Array(args[0]) : args[0];
      return ask(call, [bytes, ...args.slice(1)]);
    }])),
    terminate: () => { end(new NormaError("terminate: the worker has been ended")); return worker.terminate(); },
  };
}
