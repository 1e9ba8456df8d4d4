/* Seams of texture coordinates: edges along which an image is looked up elsewhere on the two sides. */
import { mix } from "./changes.js";

/* Numbers of positions: equal ones have one. */
function numbersOf(positions) {
  const bits = new Int32Array(positions.buffer, positions.byteOffset, positions.length), known = new Map(), made = new Int32Array(positions.length / 3);
  for (let i = 0; i < made.length; i++) {
    const [x, y, z] = [0, 1, 2].map((axis) => (positions[3 * i + axis] === 0 ? 0 : bits[3 * i + axis]));
    const key = (mix(mix(mix(0, x), y), z) >>> 0) * 2 ** 21 + (mix(mix(mix(7, z), x), y) & 0x1fffff);
    if (!known.has(key)) known.set(key, known.size);
    made[i] = known.get(key);
  }
  return made;
}

/* positions, texcoords: of each corner of each triangle. Both ends of every such edge. */
export function seamsOf(positions, texcoords) {
  const points = numbersOf(positions), edges = new Map(), ends = [];
  const same = (i, j) => texcoords[2 * i] === texcoords[2 * j] && texcoords[2 * i + 1] === texcoords[2 * j + 1];
  for (let i = 0; i < points.length; i++) {
    const next = i % 3 === 2 ? i - 2 : i + 1, [low, high] = points[i] < points[next] ? [i, next] : [next, i], key = points[low] * points.length + points[high];
    if (points[low] === points[high]) continue;
    const known = edges.get(key);
    if (!known) { edges.set(key, { low, high, isSeam: false }); continue; }
    if (known.isSeam || (same(low, known.low) && same(high, known.high))) continue;
    known.isSeam = true;
    for (const end of [low, high]) for (let axis = 0; axis < 3; axis++) ends.push(positions[3 * end + axis]);
  }
  return { ends: Float32Array.from(ends), count: ends.length / 6 };
}
