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

// A sheet whose texture is mirrored halfway, cut off in part, or without extent in one direction or in both; its triangles in any order, some the other way round, and some so thin that
// their angles are next to nothing. Now and then a number that is none.
export function mirroredSheet(seed) {
  const r = new Random(seed), across = 2 + r.below(6), fold = r.below(across + 1), thin = r.chance(0.3) ? 10 ** -(1 + r.below(9)) : 1;
  const stretch = [r.chance(0.1) ? 0 : 1 + r.below(3), r.chance(0.1) ? 0 : 1 + r.below(3)], bent = r.chance(0.5) ? 1 : 0, rounded = r.chance(0.5);
  const vertex = (x, y) => {
    const u = (x <= fold ? x : 2 * fold - x) / across;
    return {
      position: [x, y * thin, bent * Math.sin(x) * thin].map((c) => (rounded ? Math.fround(c / 3) : c)),
      normal: bent ? normalised([-bent * Math.cos(x) * thin, 0, 1]) : [0, 0, 1],
      texcoord: [u * stretch[0], (y / across) * stretch[1]],
    };
  };
  const faces = [];
  for (let x = 0; x < across; x++)
    for (let y = 0; y < across; y++) {
      const [a, b, c, d] = [vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1)];
      faces.push(...(r.chance(0.5) ? [[a, b, c], [a, c, d]] : [[a, b, d], [b, c, d]]));
    }
  for (let i = r.chance(0.5) ? faces.length : 0; i > 1; i--) {
    const j = r.below(i);
    [faces[i - 1], faces[j]] = [faces[j], faces[i - 1]];
  }
  for (const face of faces) {
    if (r.chance(0.05)) face.reverse();
    if (r.chance(0.02)) face[r.below(3)] = face[r.below(3)];
    for (let turn = r.below(3); turn > 0; turn--) face.push(face.shift());
  }
  const corners = faces.flat();
  const gather = (key) => Float32Array.from(corners.flatMap((v) => v[key]));
  const out = { positions: gather("position"), normals: gather("normal"), texcoords: gather("texcoord") };
  const values = [out.positions, out.normals, out.texcoords][r.below(3)];
  for (let i = r.chance(0.15) ? 1 + r.below(3) : 0; i > 0; i--) values[r.below(values.length)] = [NaN, Infinity, -Infinity, 3e38, 1e-45][r.below(5)];
  return out;
}
