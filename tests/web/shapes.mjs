/* Meshes to compare on: generated, the same at every run, none of them by the library. Each: { name, positions, indices }. */

/* mulberry32 */
export function randomNumbers(seed) {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

export function waves(columns, rows) {
  const positions = new Float32Array(3 * (columns + 1) * (rows + 1)), indices = new Uint32Array(6 * columns * rows);
  let k = 0;
  for (let j = 0; j <= rows; j++)
    for (let i = 0; i <= columns; i++) {
      positions[k++] = i / columns;
      positions[k++] = j / rows;
      positions[k++] = 0.1 * Math.sin((9 * i) / columns) * Math.cos((7 * j) / rows);
    }
  k = 0;
  for (let j = 0; j < rows; j++)
    for (let i = 0; i < columns; i++) {
      const a = j * (columns + 1) + i, b = a + 1, c = a + columns + 1, d = c + 1;
      indices.set([a, b, d, a, d, c], k);
      k += 6;
    }
  return { name: `waves ${columns}x${rows}`, positions, indices };
}

/* Poles and seam doubled, as UV spheres are. */
export function sphere(columns, rows) {
  const positions = [], indices = [];
  for (let j = 0; j <= rows; j++)
    for (let i = 0; i <= columns; i++) {
      const polar = (Math.PI * j) / rows, around = (2 * Math.PI * (i % columns)) / columns, radius = j % rows ? Math.sin(polar) : 0;
      positions.push(radius * Math.cos(around), Math.cos(polar), -radius * Math.sin(around));
    }
  for (let j = 0; j < rows; j++)
    for (let i = 0; i < columns; i++) {
      const a = j * (columns + 1) + i, c = a + columns + 1;
      if (j > 0) indices.push(a, c, a + 1);
      if (j < rows - 1) indices.push(a + 1, c, c + 1);
    }
  return { name: `UV sphere ${columns}x${rows}`, positions: Float32Array.from(positions), indices: Uint32Array.from(indices) };
}

export function cube() {
  const positions = [], indices = [];
  for (let i = 0; i < 8; i++) positions.push(i & 1, (i >> 1) & 1, (i >> 2) & 1);
  for (const [a, b, c, d] of [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]) indices.push(a, b, c, a, c, d);
  return { name: "cube", positions: Float32Array.from(positions), indices: Uint8Array.from(indices) };
}

export function soup(name, vertices, faces, seed, place) {
  const random = randomNumbers(seed);
  const positions = new Float32Array(3 * vertices), indices = new Uint32Array(3 * faces);
  for (let i = 0; i < positions.length; i++) positions[i] = place(random, i);
  for (let i = 0; i < indices.length; i++) indices[i] = Math.floor(random() * vertices);
  return { name, positions, indices };
}

const powers = (random) => (random() < 0.5 ? -1 : 1) * (1 + random()) * 2 ** Math.floor(-126 + 253 * random());
const rare = [NaN, Infinity, -Infinity, 0, -0, 3.4e38, 1e-45];

export function shapes() {
  return [
    cube(), sphere(32, 16), sphere(7, 5), waves(60, 40),
    soup("soup", 200, 3000, 1, (random) => random()),
    soup("soup over the whole range of floats", 300, 2000, 2, powers),
    soup("soup with NaN, infinity and zeros", 120, 900, 3, (random) => (random() < 0.1 ? rare[Math.floor(rare.length * random())] : random())),
    soup("soup of few places", 90, 1200, 4, (random) => Math.floor(3 * random())),
    soup("thin faces far away", 150, 900, 5, (random, i) => 4096 + (i % 3 ? random() * 1e-3 : random() * 100)),
    { name: "nothing", positions: new Float32Array(0), indices: new Uint32Array(0) },
    { name: "positions alone", positions: soup("", 300, 0, 6, (random) => Math.floor(4 * random())).positions, indices: undefined },
    { name: "doubles", positions: Float64Array.from(soup("", 100, 0, 7, (random) => random()).positions, (x) => 4.5e6 + 0.1 * x), indices: soup("", 100, 700, 8, () => 0).indices },
    { name: "16-bit integers", positions: Int16Array.from({ length: 300 }, (_, i) => ((i * 7919) % 2001) - 1000), indices: Uint16Array.from(soup("", 100, 700, 9, () => 0).indices) },
  ];
}
