/* Vertices that a crease or a seam needs twice. Old vertices keep their numbers, and with them whatever else is stored for them; copies follow behind. */

const XYZ = 3;

/* sources: for each vertex, the old one whose attributes it takes; as many as there were vertices, where none was added. */
class Copies {
  constructor(count, corners) {
    this.count = count;
    this.indices = new Uint32Array(corners);
    this.added = [];
  }
  add(vertex) { return this.count + this.added.push(vertex) - 1; }
  get sources() {
    const sources = new Uint32Array(this.count + this.added.length);
    for (let i = 0; i < this.count; i++) sources[i] = i;
    sources.set(this.added, this.count);
    return sources;
  }
}

/* The normals of a mesh with creases, one for each vertex: { indices, sources, normals, report }. Vertices of no face get the nearest normal. */
export function creaseVertices(norma, positions, count, indices, options) {
  const cut = norma.split(positions, indices, { fallback: "nearest", ...options }), corners = cut.indices.length;
  const copies = new Copies(count, corners), place = new Uint32Array(cut.sourceVertices.length), used = new Uint8Array(count);
  const { indices: corner, sourceVertices, normals: split } = cut;
  for (let i = 0; i < sourceVertices.length; i++) {
    const vertex = sourceVertices[i];
    place[i] = used[vertex] ? copies.add(vertex) : vertex;
    used[vertex] = 1;
  }
  for (let i = 0; i < corners; i++) copies.indices[i] = place[corner[i]];
  const normals = new Float32Array(XYZ * (count + copies.added.length));
  if (used.includes(0)) {
    const { crease, report, ...smooth } = { fallback: "nearest", ...options };
    normals.set(norma.vertexNormals(positions, indices, smooth));
  }
  for (let i = 0; i < place.length; i++)
    for (let k = 0, to = XYZ * place[i], from = XYZ * i; k < XYZ; k++) normals[to + k] = split[from + k];
  return { indices: copies.indices, sources: copies.sources, added: copies.added.length, normals, report: cut.report };
}

/* Values of corners, size floats each, as values of vertices: { indices, sources, values }. Corners of one vertex share it where their bits are equal. */
export function mergeCorners(values, size, count, indices) {
  const corners = values.length / size, copies = new Copies(count, corners), bits = new Uint32Array(values.buffer, values.byteOffset, values.length);
  /* The corner that a vertex's values come from, and the next vertex with the same source; -1: none. */
  const cornerOf = new Int32Array(count + corners).fill(-1), next = new Int32Array(count + corners).fill(-1);
  const equal = (a, b) => {
    for (let k = 0; k < size; k++) if (bits[size * a + k] !== bits[size * b + k]) return false;
    return true;
  };
  for (let corner = 0; corner < corners; corner++) {
    let vertex = indices ? indices[corner] : corner;
    const first = vertex;
    while (cornerOf[vertex] >= 0 && !equal(cornerOf[vertex], corner)) {
      if (next[vertex] < 0) next[vertex] = copies.add(first);
      vertex = next[vertex];
    }
    if (cornerOf[vertex] < 0) cornerOf[vertex] = corner;
    copies.indices[corner] = vertex;
  }
  const sources = copies.sources, merged = new Float32Array(size * sources.length);
  for (let vertex = 0; vertex < sources.length; vertex++)
    if (cornerOf[vertex] >= 0) for (let k = 0; k < size; k++) merged[size * vertex + k] = values[size * cornerOf[vertex] + k];
  return { indices: copies.indices, sources, added: copies.added.length, values: merged, cornerOf: cornerOf.subarray(0, sources.length) };
}

/* The values of the vertices in sources, size numbers each: of the first count vertices their own, of what follows copies. */
export function gather(array, size, sources, count) {
  const copy = new array.constructor(sources.length * size);
  copy.set(array.subarray(0, count * size));
  for (let i = count, to = count * size; i < sources.length; i++)
    for (let k = 0, from = sources[i] * size; k < size; k++) copy[to++] = array[from++];
  return copy;
}

/* One corner of each vertex. */
export function cornersOf(indices, vertices) {
  const corner = new Int32Array(vertices).fill(-1);
  for (let i = indices.length; i-- > 0;) corner[indices[i]] = i;
  return corner;
}

/* The narrowest index array that holds the vertices, but none narrower than before: 65535 and 255 restart primitives. */
export function indexArray(indices, vertices, before) {
  const narrow = before instanceof Uint32Array || !before ? null : before.constructor, most = narrow ? 2 ** (8 * narrow.BYTES_PER_ELEMENT) - 1 : 0;
  if (narrow && vertices <= most) return narrow.from(indices);
  return vertices <= 65535 && before && !(before instanceof Uint32Array) ? Uint16Array.from(indices) : indices;
}
