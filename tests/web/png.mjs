/* Pixels of a PNG with eight bits a channel, not interlaced, as Chromium's screenshots are. */
import { inflateSync } from "node:zlib";

export function readPng(bytes) {
  let width = 0, height = 0, channels = 0;
  const parts = [];
  for (let at = 8; at < bytes.length;) {
    const length = bytes.readUInt32BE(at), kind = bytes.toString("latin1", at + 4, at + 8), data = bytes.subarray(at + 8, at + 8 + length);
    if (kind === "IHDR") [width, height, channels] = [data.readUInt32BE(0), data.readUInt32BE(4), { 2: 3, 6: 4 }[data[9]]];
    if (kind === "IDAT") parts.push(data);
    at += length + 12;
  }
  const raw = inflateSync(Buffer.concat(parts)), line = width * channels, pixels = new Uint8Array(line * height);
  for (let y = 0; y < height; y++) {
    const filter = raw[y * (line + 1)], from = y * (line + 1) + 1, to = y * line;
    for (let x = 0; x < line; x++) {
      const a = x >= channels ? pixels[to + x - channels] : 0, b = y ? pixels[to - line + x] : 0, c = x >= channels && y ? pixels[to - line + x - channels] : 0;
      const p = a + b - c, pa = Math.abs(p - a), pb = Math.abs(p - b), pc = Math.abs(p - c);
      pixels[to + x] = raw[from + x] + [0, a, b, (a + b) >> 1, pa <= pb && pa <= pc ? a : pb <= pc ? b : c][filter];
    }
  }
  const at = (x, y) => Array.from(pixels.subarray(y * line + x * channels, y * line + x * channels + 3));
  return { width, height, at };
}

/* How many pixels of a rectangle hold, by their colour. */
export function countPixels(png, [left, top, right, bottom], holds) {
  let count = 0;
  for (let y = top; y < bottom; y++) for (let x = left; x < right; x++) if (holds(png.at(x, y), x, y)) count++;
  return count;
}
