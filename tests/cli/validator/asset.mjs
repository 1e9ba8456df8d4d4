// asset.mjs: a glTF file and its buffers, read by nothing of Norma's, for the judges beside it.
import { readFileSync } from "node:fs";
import path from "node:path";

// A buffer that is not there is null.
export function load(file) {
  const bytes = readFileSync(file);
  let text = bytes, bin = null;
  if (bytes.length > 12 && bytes.readUInt32LE(0) === 0x46546c67) {
    const size = bytes.readUInt32LE(12);
    text = bytes.subarray(20, 20 + size);
    if (bytes.length >= 28 + size) bin = bytes.subarray(28 + size, 28 + size + bytes.readUInt32LE(20 + size));
  }
  const json = JSON.parse(text.toString("utf8").replace(/^\uFEFF/, ""));
  const buffers = (json.buffers ?? []).map((buffer, i) => {
    try {
      if (buffer.uri === undefined) return i === 0 ? bin : null;
      if (buffer.uri.startsWith("data:")) return Buffer.from(buffer.uri.slice(buffer.uri.indexOf(",") + 1), "base64");
      return readFileSync(path.resolve(path.dirname(file), decodeURIComponent(buffer.uri)));
    } catch { return null; }
  });
  return { json, buffers, cache: new Map() };
}

export const widths = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT2: 4, MAT3: 9, MAT4: 16 };

// Of a component type: bytes, how to read one, and the integer that means 1.
export const readers = {
  5120: [1, (b, o) => b.readInt8(o), 127], 5121: [1, (b, o) => b.readUInt8(o), 255], 5122: [2, (b, o) => b.readInt16LE(o), 32767],
  5123: [2, (b, o) => b.readUInt16LE(o), 65535], 5125: [4, (b, o) => b.readUInt32LE(o), 1], 5126: [4, (b, o) => b.readFloatLE(o), 1],
};
