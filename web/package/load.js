/* Loading, the same for every entry: what differs is where the two modules lie. */
import { bindCalls } from "./calls.js";
import { makeCheck } from "./check.js";
import { fail, options as checkOptions, spell } from "./arguments.js";

/* What `norma-mesh/three` and `norma-mesh/gltf-transform` compute with: whatever was loaded last. */
let current = null;
export const loaded = () => current ?? fail("norma-mesh: not loaded; await load() first");
export const isLoaded = () => current !== null;

const isModule = (source) => Object.prototype.toString.call(source) === "[object WebAssembly.Module]";
export const isBytes = (source) => ArrayBuffer.isView(source) || Object.prototype.toString.call(source) === "[object ArrayBuffer]";
const isAddress = (source) => typeof source === "string" || source instanceof URL;

const MAGIC = [0x00, 0x61, 0x73, 0x6d];

async function instantiate(source, read, what) {
  if (isModule(source)) return (await WebAssembly.instantiate(source)).exports;
  if (!isBytes(source) && !isAddress(source)) fail(`${what}: ${spell(source)} is neither an address, nor bytes, nor a WebAssembly.Module`);
  const bytes = isBytes(source) ? source : await read(source);
  const head = new Uint8Array(bytes.buffer ?? bytes, bytes.byteOffset ?? 0, Math.min(4, bytes.byteLength));
  if (!MAGIC.every((byte, i) => head[i] === byte)) {
    fail(`${what}: ${isBytes(source) ? "these bytes are" : `${source} is`} not a WebAssembly module. A bundler that does not copy the package's .wasm files needs \`norma-mesh/inline\`, or load(address)`);
  }
  return (await WebAssembly.instantiate(bytes)).instance.exports;
}

/* read: (address) => a promise of bytes. modules: core and check, each giving an address, bytes, or a promise of them. */
export function makeLoad(read, modules) {
  let first = null;
  const open = async (source, check) => {
    const core = await instantiate(source ?? (await modules.core()), read, "load");
    return bindCalls(core, makeCheck(async () => instantiate(typeof check === "function" ? await check() : check ?? (await modules.check()), read, "check")));
  };
  /* source: nothing, an address of norma.wasm, its bytes, or a compiled module; check: the same of check.wasm. */
  return async (source, options) => {
    const { check } = checkOptions(options, "check");
    const standard = (source === undefined || source === null) && check === undefined;
    if (!standard) return (current = await open(source, check));
    first ??= open();
    try {
      return (current = await first);
    } catch (error) {
      first = null;
      throw error;
    }
  };
}
