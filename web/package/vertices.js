/* Vertices that a crease or a seam needs twice. Old vertices keep their numbers, and with them whatever else is stored for them; copies follow behind. */

const XYZ = 3;

export const NORMAL_OPTIONS = ["weight", "weld", "nonManifold", "fallback"];
export const pick = (options, names) => Object.fromEntries(names.filter((name) => options[name] !== undefined).map((name) => [name, options[name]]));

/* The normals of a mesh with creases, one for each vertex: { count, indices, sources, values, firsts, report }. Vertices of no face get the nearest normal. */
export function creaseVertices(norma, positions, indices, options, wantsFirsts) {
  const all = { fallback: "nearest", ...options }, cut = norma.creaseVertices(positions, indices, all, wantsFirsts), { firsts, values } = cut;
  if (cut.isWhole) return cut;
  const { crease, report, ...smooth } = all, normals = norma.vertexNormals(positions, indices, smooth);
  for (let i = firsts.indexOf(-1); i >= 0; i = firsts.indexOf(-1, i + 1)) for (let k = 0; k < XYZ; k++) values[XYZ * i + k] = normals[XYZ * i + k];
  return cut;
}

/* The values of the first count vertices, size numbers each, and of copies of those in sources. */
export function gather(array, size, count, sources) {
  if (!sources.length) return array.slice(0, count * size);
  const copy = new array.constructor((count + sources.length) * size);
  copy.set(array.subarray(0, count * size));
  for (let i = 0, to = count * size; i < sources.length; i++)
    for (let k = 0, from = sources[i] * size; k < size; k++) copy[to++] = array[from++];
  return copy;
}

/* The narrowest index array that holds the vertices, but none narrower than before: 65535 and 255 restart primitives. */
export function indexArray(indices, vertices, before) {
  const narrow = before instanceof Uint32Array || !before ? null : before.constructor, most = narrow ? 2 ** (8 * narrow.BYTES_PER_ELEMENT) - 1 : 0;
  if (narrow && vertices <= most) return new narrow(indices);
  return vertices <= 65535 && before && !(before instanceof Uint32Array) ? new Uint16Array(indices) : indices;
}

/* Triangles seen from their other side: the second and third corner change places. */
export function turnTriangles(indices) {
  const turned = indices.slice();
  for (let i = 0; i + 2 < indices.length; i += 3) [turned[i + 1], turned[i + 2]] = [indices[i + 2], indices[i + 1]];
  return turned;
}
