/* A worker answers calls: { id, call, args } in, { id, value } or { id, error } out. Buffers of answers are handed over, not copied. */

import { fail } from "./arguments.js";

const buffersOf = (value) => {
  if (ArrayBuffer.isView(value)) return value.buffer instanceof ArrayBuffer ? [value.buffer] : [];
  return value && typeof value === "object" ? Object.values(value).flatMap(buffersOf) : [];
};

export function serve(port, load) {
  let norma = null, number = 0, sendCheck;
  const sentCheck = new Promise((done) => { sendCheck = done; }), plans = new Map();

  const calls = {
    /* isCheckSent: the bytes of check.wasm follow, before the first check. */
    load: async (source, check, isCheckSent) => {
      norma = await load(source, isCheckSent ? { check: () => sentCheck } : check ? { check } : {});
      return norma.version;
    },
    sendCheck: (bytes) => sendCheck(bytes),
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
