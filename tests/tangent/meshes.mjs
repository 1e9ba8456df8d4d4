// meshes.mjs: small meshes of the kinds on which tangent generators differ, as corners of triangles.
export class Random {
  constructor(seed) {
    this.state = BigInt(seed) * 0x9e3779b97f4a7c15n + 1n;
    this.state &= (1n << 64n) - 1n;
    this.a = Number(this.state & 0xffffffffn) >>> 0;
    this.b = Number(this.state >> 32n) >>> 0;
  }
  next() { // xorshift of 32 bits with a Weyl sequence
    let x = this.a;
    x ^= x << 13; x ^= x >>> 17; x ^= x << 5;
    this.a = x >>> 0 || 1;
    this.b = (this.b + 0x9e3779b9) >>> 0;
    return (this.a + this.b) >>> 0;
  }
  below(n) { return this.next() % n; }
  unit() { return this.next() / 4294967296; }
  chance(p) { return this.unit() < p; }
}

const normalised = (v) => {
  const l = Math.hypot(...v);
  return l > 0 ? v.map((x) => x / l) : v;
};

// Vertices on a grid, few of them, so that edges of many faces, coincident corners and faces without
// area are common.
export function madeMesh(seed) {
  const r = new Random(seed);
  const vertexCount = 3 + r.below(r.chance(0.1) ? 60 : 9);
  const steps = 1 + r.below(4), exact = r.chance(0.5), flat = r.chance(0.3), oneNormal = r.chance(0.5);
  const scale = r.chance(0.05) ? 10 ** (r.below(60) - 30) : 1;
  const coordinate = () => (exact ? r.below(steps + 1) / steps : r.unit()) * scale;
  const positions = [], normals = [], texcoords = [];
  for (let i = 0; i < vertexCount; i++) {
    positions.push([coordinate(), coordinate(), flat ? 0 : coordinate()]);
    normals.push(oneNormal ? [0, 0, 1] : normalised([r.unit() - 0.5, r.unit() - 0.5, r.unit() - 0.5]));
    texcoords.push(exact ? [r.below(steps + 1) / steps, r.below(steps + 1) / steps] : [r.unit(), r.unit()]);
    if (r.chance(0.1)) texcoords[i] = texcoords[r.below(i + 1)].slice();
    if (r.chance(0.05)) positions[i] = positions[r.below(i + 1)].slice();
  }
  const faces = [];
  const kind = r.below(3), faceCount = 1 + r.below(r.chance(0.1) ? 80 : 12);
  for (let f = 0; f < faceCount; f++) {
    if (kind === 0) faces.push([r.below(vertexCount), r.below(vertexCount), r.below(vertexCount)]);
    else if (kind === 1) faces.push([0, 1 + (f % (vertexCount - 1)), 1 + ((f + 1) % (vertexCount - 1))]); // a fan
    else faces.push([f, f + 1, f + 2].map((i) => i % vertexCount)); // a strip
    if (r.chance(0.2)) faces[f].reverse();
  }
  const corners = faces.flat(), out = { positions: [], normals: [], texcoords: [] };
  for (const c of corners) {
    out.positions.push(...positions[c]);
    out.normals.push(...normals[c]);
    out.texcoords.push(...texcoords[c]);
  }
  return {
    positions: Float32Array.from(out.positions),
    normals: Float32Array.from(out.normals),
    texcoords: Float32Array.from(out.texcoords),
  };
}

// A fan of many triangles round one vertex, flat texture coordinates.
export function fan(count, turns = 1) {
  const out = { positions: [], normals: [], texcoords: [] };
  const rim = (i) => {
    const a = (2 * Math.PI * turns * i) / count;
    return [Math.cos(a), Math.sin(a), 0.1 * Math.sin(5 * a)];
  };
  for (let i = 0; i < count; i++)
    for (const p of [[0, 0, 0], rim(i), rim((i + 1) % count)]) {
      out.positions.push(...p);
      out.normals.push(0, 0, 1);
      out.texcoords.push(p[0], p[1] + 0.3 * p[0] * p[1]);
    }
  return Object.fromEntries(Object.entries(out).map(([k, v]) => [k, Float32Array.from(v)]));
}

// The same fan, u once round it: the tangents at its middle are opposed to each other.
export function swirl(count, turns = 1) {
  const out = fan(count, turns);
  for (let i = 0; i < count; i++) out.texcoords.set([0.5, 0, i / count, 1, (i + 1) / count, 1], 6 * i);
  return out;
}

// Its triangles in any order; gaps: now and then a number that is none.
export function shuffledSwirl(count, turns, gaps, seed) {
  const r = new Random(seed), m = swirl(count, turns);
  const swap = (values, size, i, j) => {
    for (let k = 0; k < size; k++) [values[size * i + k], values[size * j + k]] = [values[size * j + k], values[size * i + k]];
  };
  for (let i = count; i > 1; i--) {
    const j = r.below(i);
    swap(m.positions, 9, i - 1, j);
    swap(m.texcoords, 6, i - 1, j);
  }
  for (let i = 0; i < gaps; i++) m.positions[9 * r.below(count) + 3 + r.below(6)] = NaN;
  return m;
}
