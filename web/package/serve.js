/* A worker answers calls: { id, call, args } in, { id, value } or { id, error } out. Buffers of answers are handed over, not copied. For a module whose bytes are sent it asks by { wanted }. */

import { fail } from "./arguments.js";

const buffersOf = (value) => {
  if (ArrayBuffer.isView(value)) return value.buffer instanceof ArrayBuffer ? [value.buffer] : [];
  return value && typeof value === "object" ? Object.values(value).flatMap(buffersOf) : [];
};

export function serve(port, load) {
  let norma = null, number = 0;
  const plans = new Map(), waiting = new Map();
  const askFor = (wanted) => new Promise((done, fail) => {
    waiting.set(wanted, { done, fail });
    port.postMessage({ wanted }, []);
  });

  const calls = {
    /* modules: check and draco as load takes them; true: their bytes are sent when they are asked for. */
    load: async (source, modules) => {
      const given = Object.entries(modules).filter(([, module]) => module !== undefined);
      norma = await load(source, Object.fromEntries(given.map(([name, module]) => [name, module === true ? () => askFor(name) : module])));
      return norma.version;
    },
    send: (name, bytes, error) => { if (error) waiting.get(name).fail(new Error(error)); else waiting.get(name).done(bytes); },
    plan: (...args) => {
      const plan = norma.plan(...args);
      plans.set(++number, plan);
      return { plan: number, count: plan.count, bytes: plan.bytes };
    },
    update: (plan, ...args) => (plans.get(plan) ?? fail("plan: it has been freed")).update(...args),
    free: (plan) => { plans.get(plan)?.free(); plans.delete(plan); },
  };

  port.onmessage = async ({ data: { id, call, args } }) => {
    try {
      const value = await (calls[call] ?? norma[call])(...args);
      port.postMessage({ id, value }, [...new Set(buffersOf(value))]);
    } catch (error) {
      port.postMessage({ id, error: { message: error.message, result: error.result } }, []);
    }
  };
}
