/* Loading, the same for every entry: what differs is where the modules lie. */
import { bindCalls } from "./more-calls.js";
import { makeCheck } from "./check.js";
import { makeTool } from "./tool.js";
import { allLibraries, makeDecoders } from "./decoders.js";
import { fail, options as checkOptions, spell } from "./arguments.js";

/* What `norma-mesh/three` and `norma-mesh/gltf-transform` compute with: whatever was loaded last. */
let current = null;
export const loaded = () => current ?? fail("norma-mesh: not loaded; await load() first");
export const isLoaded = () => current !== null;

const isModule = (source) => Object.prototype.toString.call(source) === "[object WebAssembly.Module]";
export const isBytes = (source) => ArrayBuffer.isView(source) || Object.prototype.toString.call(source) === "[object ArrayBuffer]";
const isAddress = (source) => typeof source === "string" || source instanceof URL;

const OTHERWISE = "A bundler that does not copy the package's .wasm files needs `norma-mesh/inline`, or load(address)";
const MAGIC = [0x00, 0x61, 0x73, 0x6d];

async function readModule(address, read, what) {
  try {
    return await read(address);
  } catch (error) {
    return fail(`${what}: ${address} cannot be read (${error.message}). ${OTHERWISE}`);
  }
}

async function compile(source, read, what) {
  if (isModule(source)) return source;
  if (!isBytes(source) && !isAddress(source)) fail(`${what}: ${spell(source)} is neither an address, nor bytes, nor a WebAssembly.Module`);
  const bytes = isBytes(source) ? source : await readModule(source, read, what);
  const head = new Uint8Array(bytes.buffer ?? bytes, bytes.byteOffset ?? 0, Math.min(4, bytes.byteLength));
  if (!MAGIC.every((byte, i) => head[i] === byte)) {
    fail(`${what}: ${isBytes(source) ? "these bytes are" : `${source} is`} not a WebAssembly module. ${OTHERWISE}`);
  }
  return WebAssembly.compile(bytes);
}

const instantiate = async (source, read, what, imports = {}) => (await WebAssembly.instantiate(await compile(source, read, what), imports)).exports;

/* read: (address) => a promise of bytes. modules: core, check, draco and tool, each giving an address, bytes, or a promise of them. */
export function makeLoad(read, modules) {
  let first = null;
  const sourceOf = (given, standard) => (typeof given === "function" ? given() : given ?? standard());
  const open = async (source, check, draco, tool) => {
    const core = await instantiate(source ?? (await modules.core()), read, "load");
    const libraries = allLibraries(async () => compile(await sourceOf(draco, modules.draco), read, "draco")), decoders = makeDecoders(libraries);
    const loadCheck = async () => decoders.serve(await instantiate(await sourceOf(check, modules.check), read, "check", decoders.imports));
    return Object.assign(bindCalls(core, makeCheck(loadCheck, decoders.reading)), makeTool(async () => compile(await sourceOf(tool, modules.tool), read, "tool"), libraries));
  };
  /* source: nothing, an address of norma.wasm, its bytes, or a compiled module; check, draco, tool: the same of check.wasm, draco.wasm and tool.wasm. */
  return async (source, options) => {
    const { check, draco, tool } = checkOptions(options, "check draco tool");
    const standard = (source === undefined || source === null) && [check, draco, tool].every((module) => module === undefined);
    if (!standard) return (current = await open(source, check, draco, tool));
    first ??= open();
    try {
      return (current = await first);
    } catch (error) {
      first = null;
      throw error;
    }
  };
}
