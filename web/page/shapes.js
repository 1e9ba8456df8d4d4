/* Models to pick where no file is at hand. Each gives positions and indices. */

/* A grid of points that may close round in either direction; at(u, v) gives a point for u, v from 0 to 1. */
function grid(columns, rows, closedU, closedV, at) {
  const across = closedU ? columns : columns + 1, down = closedV ? rows : rows + 1;
  const positions = new Float32Array(3 * across * down), indices = new Uint32Array(6 * columns * rows);
  for (let j = 0, k = 0; j < down; j++) for (let i = 0; i < across; i++, k += 3) positions.set(at(i / columns, j / rows), k);
  for (let j = 0, k = 0; j < rows; j++)
    for (let i = 0; i < columns; i++, k += 6) {
      const right = (i + 1) % across, below = (j + 1) % down, a = j * across + i, b = j * across + right, c = below * across + i, d = below * across + right;
      indices.set([a, b, d, a, d, c], k);
    }
  return { positions, indices };
}

const TURN = 2 * Math.PI;

function sphere() {
  return grid(96, 48, true, false, (u, v) => {
    const radius = v === 0 || v === 1 ? 0 : Math.sin(Math.PI * v);
    return [radius * Math.cos(TURN * u), -Math.cos(Math.PI * v), -radius * Math.sin(TURN * u)];
  });
}

/* A torus knot (2, 3) with a round section, carried along by the curve's own frame. */
function knot(columns, rows) {
  const curve = (t) => {
    const r = 2 + Math.cos(3 * t);
    return [r * Math.cos(2 * t), r * Math.sin(2 * t), Math.sin(3 * t)];
  };
  return grid(columns, rows, true, true, (u, v) => {
    const t = TURN * u, p = curve(t), q = curve(t + 1e-3), along = p.map((x, i) => q[i] - x), out = p.map((x, i) => q[i] + x);
    const side = cross(along, out), up = cross(side, along), s = Math.hypot(...side), n = Math.hypot(...up), a = -TURN * v;
    return p.map((x, i) => x + 0.55 * ((Math.cos(a) * up[i]) / n + (Math.sin(a) * side[i]) / s));
  });
}
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

/* Turned on a lathe: a profile of [radius, height], from the bottom to the top. */
function turned(profile, columns = 96) {
  return grid(columns, profile.length - 1, true, false, (u, v) => {
    const [radius, height] = profile[Math.round(v * (profile.length - 1))];
    return [radius * Math.cos(TURN * u), height, -radius * Math.sin(TURN * u)];
  });
}

function vase() {
  const profile = [[0, -1.2], [0.62, -1.2], [0.66, -1.12], [0.52, -1.02]];
  for (let i = 0; i <= 40; i++) profile.push([0.42 + 0.38 * Math.sin((Math.PI * (i + 4)) / 46) ** 2 + (i > 34 ? (i - 34) * 0.012 : 0), -0.98 + i * 0.05]);
  profile.push([0.62, 1.06], [0.56, 1.08], [0.42, 0.98], [0.38, 0.7], [0.5, 0], [0.36, -0.85], [0, -0.9]);
  return turned(profile);
}

/* A wheel with teeth: flat sides, straight flanks, a round hub; every crease is one of 90 degrees or so. */
function gear() {
  const positions = [], indices = [], teeth = 16, steps = 8 * teeth;
  const outline = (i) => {
    const phase = (i % 8) / 8, tip = phase >= 0.25 && phase < 0.75;
    return tip ? 1 : 0.78;
  };
  const rings = [];
  for (const [kind, z] of [["hub", 0.25], ["rim", 0.25], ["rim", -0.25], ["hub", -0.25]]) {
    rings.push(positions.length / 3);
    for (let i = 0; i < steps; i++) {
      const a = (TURN * i) / steps, r = kind === "hub" ? 0.3 : outline(i);
      positions.push(r * Math.cos(a), r * Math.sin(a), z);
    }
  }
  for (let ring = 0; ring < 4; ring++)
    for (let i = 0; i < steps; i++) {
      const j = (i + 1) % steps, a = rings[ring] + i, b = rings[ring] + j, c = rings[(ring + 1) % 4] + i, d = rings[(ring + 1) % 4] + j;
      indices.push(a, c, d, a, d, b);
    }
  return { positions: Float32Array.from(positions), indices: Uint32Array.from(indices) };
}

/* A box whose edges are cut at 45 degrees. */
function bevelledBox() {
  const h = 1, s = 0.82, positions = [], indices = [];
  const corner = (axis, x, y, z) => [x, y, z].map((sign, i) => sign * (i === axis ? h : s));
  const number = new Map();
  const vertex = (axis, x, y, z) => {
    const key = `${axis}${x}${y}${z}`;
    if (!number.has(key)) { number.set(key, positions.length / 3); positions.push(...corner(axis, x, y, z)); }
    return number.get(key);
  };
  const face = (list) => {
    const [p, q, r] = list.slice(0, 3).map((i) => positions.slice(3 * i, 3 * i + 3));
    const n = cross(q.map((x, i) => x - p[i]), r.map((x, i) => x - p[i]));
    const turnedOut = n[0] * p[0] + n[1] * p[1] + n[2] * p[2] > 0 ? list : [...list].reverse();
    for (let i = 1; i + 1 < list.length; i++) indices.push(turnedOut[0], turnedOut[i], turnedOut[i + 1]);
  };
  const signs = [-1, 1];
  for (let axis = 0; axis < 3; axis++)
    for (const side of signs) face([[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([u, v]) => vertex(axis, ...[0, 1, 2].map((i) => (i === axis ? side : i === (axis + 1) % 3 ? u : v)))));
  for (let along = 0; along < 3; along++)
    for (const u of signs) for (const v of signs) {
      const a = (along + 1) % 3, b = (along + 2) % 3, at = (axis, w) => vertex(axis, ...[0, 1, 2].map((i) => (i === along ? w : i === a ? u : v)));
      face([at(a, -1), at(a, 1), at(b, 1), at(b, -1)]);
    }
  for (const x of signs) for (const y of signs) for (const z of signs) face([0, 1, 2].map((axis) => vertex(axis, x, y, z)));
  return { positions: Float32Array.from(positions), indices: Uint32Array.from(indices) };
}

export const SHAPES = {
  vase: { title: "Vase", colour: [0.1, 0.36, 0.31], crease: 40, make: vase },
  knot: { title: "Knot", colour: [0.56, 0.2, 0.06], make: () => knot(320, 40) },
  box: { title: "Bevelled box", colour: [0.14, 0.27, 0.42], crease: 60, make: bevelledBox },
  gear: { title: "Gear", colour: [0.36, 0.37, 0.4], crease: 30, make: gear },
  sphere: { title: "Sphere", colour: [0.42, 0.42, 0.45], make: sphere },
  fine: { title: "Fine knot", colour: [0.56, 0.2, 0.06], make: () => knot(1000, 100) },
};
