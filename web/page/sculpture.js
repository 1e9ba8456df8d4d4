/* The sculpture that the playground begins with, as web/build.mjs packs it; null on the pages of norma view. */

export const CREDIT = "Goat head by hugoelec, remeshed by Oded Stein; CC BY 3.0.";

export function unpackSculpture(bytes) {
  if (!bytes.length) return null;
  const head = new DataView(bytes.buffer), points = head.getUint32(0, true), triangles = head.getUint32(4, true), places = new Uint16Array(bytes.buffer, 32, 3 * points);
  const [least, step] = [8, 20].map((at) => [0, 4, 8].map((more) => head.getFloat32(at + more, true)));
  return { positions: Float32Array.from(places, (x, i) => least[i % 3] + step[i % 3] * x), indices: Uint32Array.from(new Uint16Array(bytes.buffer, 32 + 6 * points, 3 * triangles)),
           colour: [0.62, 0.36, 0.16], name: "Goat head" };
}
