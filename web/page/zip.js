/* The files of a zip: its central directory (PKWARE's APPNOTE 6.3), each inflated by the browser. */
import { inflate } from "./inflate.js";

const END = 0x06054b50, ENTRY = 0x02014b50, LOCAL = 0x04034b50;
const STORED = 0, DEFLATED = 8, ENCRYPTED = 1;
const LONGEST_COMMENT = 65535, END_SIZE = 22;
const MOST_BYTES = 1 << 30;

function findEnd(view) {
  for (let at = view.byteLength - END_SIZE; at >= Math.max(0, view.byteLength - END_SIZE - LONGEST_COMMENT); at--) if (view.getUint32(at, true) === END) return at;
  return -1;
}

/* [{ path, read: () => a promise of its bytes }], folders left out. */
export function listZip(bytes, name) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength), end = bytes.length < END_SIZE ? -1 : findEnd(view), entries = [];
  const damaged = () => new Error(`${name}: this zip is damaged or of a kind that the page does not read. Unpack it and drop the folder.`);
  if (end < 0) throw damaged();
  let at = view.getUint32(end + 16, true), total = 0;
  for (let left = view.getUint16(end + 10, true); left > 0; left--) {
    if (at + 46 > bytes.length || view.getUint32(at, true) !== ENTRY) throw damaged();
    const flags = view.getUint16(at + 8, true), method = view.getUint16(at + 10, true), packed = view.getUint32(at + 20, true), size = view.getUint32(at + 24, true);
    const [nameLength, extraLength, commentLength] = [28, 30, 32].map((offset) => view.getUint16(at + offset, true)), local = view.getUint32(at + 42, true);
    const path = new TextDecoder().decode(bytes.subarray(at + 46, at + 46 + nameLength));
    at += 46 + nameLength + extraLength + commentLength;
    if (path.endsWith("/")) continue;
    total += size;
    if (flags & ENCRYPTED || (method !== STORED && method !== DEFLATED) || total > MOST_BYTES) throw damaged();
    entries.push({ path, read: () => {
      if (local + 30 > bytes.length || view.getUint32(local, true) !== LOCAL) throw damaged();
      const from = local + 30 + view.getUint16(local + 26, true) + view.getUint16(local + 28, true), part = bytes.subarray(from, from + packed);
      if (part.length !== packed) throw damaged();
      return method === STORED ? Promise.resolve(part.slice()) : inflate(part).catch(() => { throw damaged(); });
    } });
  }
  return entries;
}
