/* norma: surface normals of meshes, kept right. The C library as WebAssembly. */
import { bindCalls, NormaError } from "./calls.js";

const isBytes = (source) => ArrayBuffer.isView(source) || source instanceof ArrayBuffer || Object.prototype.toString.call(source) === "[object ArrayBuffer]";

async function bytesAt(url) {
  const address = String(url);
  const isFile = address.startsWith("file:") || (typeof process !== "undefined" && process.versions?.node && !/^[a-z][a-z0-9+.-]+:/i.test(address));
  if (isFile) {
    const { readFile } = await import("node:fs/promises");
    return readFile(url instanceof URL || !address.startsWith("file:") ? url : new URL(address));
  }
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${address}: ${response.status} ${response.statusText}`);
  return response.arrayBuffer();
}

async function inlined() {
  const { default: text } = await import("./wasm.js");
  const characters = atob(text);
  const bytes = new Uint8Array(characters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = characters.charCodeAt(i);
  return bytes;
}

/* source: nothing (the module that lies in this package as text), the address of norma.wasm, its bytes, or a compiled WebAssembly.Module. */
export async function load(source) {
  if (source instanceof WebAssembly.Module) return bindCalls((await WebAssembly.instantiate(source)).exports);
  const bytes = source === undefined || source === null ? await inlined() : isBytes(source) ? source : await bytesAt(source);
  const { instance } = await WebAssembly.instantiate(bytes);
  return bindCalls(instance.exports);
}

export { NormaError };
