/* Compressed glTF, decoded by npm's draco3dgltf and meshoptimizer, and zips of 3MF by fflate. Modules that read files (check.wasm, the page's) import the calls below; each library is loaded when a file first needs it. */

const MEMORY = 1, BROKEN = 2, KIND = 3, FACES = 4, POINTS = 5, LARGE = 6, ATTRIBUTE = 7, WIDTH = 8, VALUE = 9; // draco_result (src/io/gltf/draco_decoder.h)
const STREAM = 8, VALUES = 4; // 32-bit numbers in a draco_stream and in a draco_values
const TYPES = { 5120: ["DT_INT8", 1], 5121: ["DT_UINT8", 1], 5122: ["DT_INT16", 2], 5123: ["DT_UINT16", 2], 5125: ["DT_UINT32", 4], 5126: ["DT_FLOAT32", 4] };
const NO_ATTRIBUTE = 0xffffffff, MOST_WIDTH = 4;

const numbersAt = (wasm, at, count) => new Uint32Array(wasm.memory.buffer, at >>> 0, count);
const bytesAt = (wasm, at, size) => new Uint8Array(wasm.memory.buffer, at >>> 0, size >>> 0);

/* ---- Draco */

class Refusal extends Error {
  constructor(result, found = 0) { super(); Object.assign(this, { result, found }); }
}
const refuse = (result, found) => { throw new Refusal(result, found); };

function readStream(host, at) {
  const [from, size, points, faces, attributesAt, count, indicesAt, most] = numbersAt(host, at, STREAM);
  const readValues = (valuesAt) => {
    const [id, width, component, out] = numbersAt(host, valuesAt, VALUES);
    return { id, width, component, out };
  };
  const attributes = Array.from({ length: count }, (_, i) => readValues(attributesAt + 4 * VALUES * i));
  return { bytes: bytesAt(host, from, size), points, faces, most, attributes, indices: indicesAt ? readValues(indicesAt) : null };
}

/* Where only the indices are in the stream, some programs write no points beside them. */
const hasPoints = (stream, points) => (stream.attributes.length ? points === stream.points : points <= stream.points);

/* Draco allocates what counts in a stream ask for: they are compared with what the file declares before it sees them. Metadata stand before the counts; with them, they are compared afterwards. */
const TRIANGULAR_MESH = 1, SEQUENTIAL = 0, EDGEBREAKER = 1, HAS_METADATA = 0x80, HEAD = 11;
function checkHead(stream) {
  const { bytes } = stream, [, , , , , major, minor, type, method, , flags] = bytes;
  if (bytes.length < HEAD || String.fromCharCode(...bytes.subarray(0, 5)) !== "DRACO") refuse(BROKEN);
  if (type !== TRIANGULAR_MESH || (method !== SEQUENTIAL && method !== EDGEBREAKER)) refuse(KIND);
  if (major < 1 || major > 2 || (major === 2 && minor > 2)) refuse(BROKEN);
  if (flags & HAS_METADATA) return;
  if (major !== 2 || minor !== 2) refuse(KIND);
  let at = method === EDGEBREAKER ? HEAD + 1 : HEAD; // behind the kind of traversal
  const next = () => {
    let number = 0, scale = 1, byte;
    do {
      if (at >= bytes.length || scale > 2 ** 28) refuse(BROKEN);
      byte = bytes[at++];
      number += (byte & 0x7f) * scale;
      scale *= 128;
    } while (byte & 0x80);
    return number;
  };
  const first = next(), second = next(), [faces, points] = method === SEQUENTIAL ? [first, second] : [second, null];
  if (faces !== stream.faces) refuse(FACES, faces);
  if (points !== null && !hasPoints(stream, points)) refuse(POINTS, points);
}

/* The mesh that Draco made, as far as it came: isWhole says whether it came to the end. */
function checkMesh(stream, draco, decoder, mesh, isWhole) {
  const faces = mesh.num_faces(), points = mesh.num_points();
  const sizes = Array.from({ length: mesh.num_attributes() }, (_, i) => decoder.GetAttribute(mesh, i).byte_stride());
  const size = sizes.reduce((sum, each) => sum + each, 0);
  if (faces !== stream.faces && isWhole) refuse(FACES, faces);
  if ((isWhole || sizes.length) && !hasPoints(stream, points)) refuse(POINTS, points);
  if (points * size > stream.most) refuse(LARGE, size * points);
  if (!isWhole) refuse(BROKEN);
}

/* Room in Draco's memory for what work writes, which returns whether it could; then a copy of that. */
function fetchBytes(draco, size, work) {
  const at = draco._malloc(size);
  if (!at) refuse(MEMORY);
  try { return work(at) ? draco.HEAPU8.slice(at, at + size) : null; } finally { draco._free(at); }
}

function readAttribute(draco, decoder, mesh, { id, width, component }, points, number) {
  const attribute = decoder.GetAttributeByUniqueId(mesh, id), [type, bytes] = TYPES[component];
  if (!draco.getPointer(attribute)) refuse(ATTRIBUTE, number);
  if (width > MOST_WIDTH || attribute.num_components() !== width) refuse(WIDTH, number);
  const size = points * width * bytes;
  return fetchBytes(draco, size, (at) => decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, draco[type], size, at)) ?? refuse(VALUE, number);
}

function readIndices(draco, decoder, mesh, { component }, { faces, points }) {
  const size = 12 * faces, all = fetchBytes(draco, size, (at) => decoder.GetTrianglesUInt32Array(mesh, size, at)) ?? refuse(BROKEN);
  const wide = new Uint32Array(all.buffer), most = 256 ** TYPES[component][1] - 1, wrong = wide.find((index) => index >= points || index > most);
  if (wrong !== undefined) refuse(wrong >= points ? BROKEN : VALUE, NO_ATTRIBUTE);
  return component === 5125 ? all : new Uint8Array((component === 5123 ? Uint16Array : Uint8Array).from(wide).buffer);
}

/* All is read before any of it is handed over. */
function decodeStream(host, draco, stream) {
  checkHead(stream);
  const decoder = new draco.Decoder(), mesh = new draco.Mesh();
  const { attributes, indices, points } = stream, isWhole = decoder.DecodeArrayToMesh(stream.bytes, stream.bytes.length, mesh).ok();
  checkMesh(stream, draco, decoder, mesh, isWhole);
  const read = attributes.map((values, i) => [values.out, readAttribute(draco, decoder, mesh, values, points, i)]);
  if (indices) read.push([indices.out, readIndices(draco, decoder, mesh, indices, stream)]);
  for (const [out, bytes] of read) bytesAt(host, out, bytes.length).set(bytes);
  draco.destroy(mesh);
  draco.destroy(decoder);
}

/* factory: of draco3dgltf. It makes its module at once, as it is handed an instance; one of its calls says no where there is no more memory. */
function startDraco({ factory, module }) {
  const draco = {
    isFull: false,
    instantiateWasm: (imports, receive) => {
      const watched = ([name, call]) => [name, (...args) => { const result = call(...args); draco.isFull ||= result === false; return result; }];
      const calls = Object.entries(imports).map(([name, group]) => [name, Object.fromEntries(Object.entries(group).map(watched))]);
      const instance = new WebAssembly.Instance(module, Object.fromEntries(calls));
      receive(instance);
      return instance.exports;
    },
    printErr: () => {},
  };
  factory(draco);
  return draco;
}

/* ---- meshoptimizer: io calls it by the names of its C functions. */

const isMade = (work) => { try { work(); return 0; } catch { return 1; } };

function meshoptCalls(memory, need) {
  const decode = (name) => (out, count, stride, from, size) => {
    const decoder = need("meshopt");
    return decoder ? isMade(() => decoder[name](bytesAt(memory(), out, count * stride), count, stride, bytesAt(memory(), from, size))) : 1;
  };
  /* Encoded bytes, as many as they are; 0: there is no room for them. */
  const encode = (work) => (out, room, ...rest) => {
    const encoder = need("encoder"), bytes = encoder ? work(encoder, ...rest) : null;
    if (!bytes || bytes.length > room) return 0;
    bytesAt(memory(), out, bytes.length).set(bytes);
    return bytes.length;
  };
  const rowsAt = (from, size) => bytesAt(memory(), from, size);
  return {
    meshopt_decodeVertexBuffer: decode("decodeVertexBuffer"), meshopt_decodeIndexBuffer: decode("decodeIndexBuffer"), meshopt_decodeIndexSequence: decode("decodeIndexSequence"),
    meshopt_encodeVertexBuffer: encode((encoder, rows, count, stride) => encoder.encodeGltfBuffer(rowsAt(rows, count * stride), count, stride, "ATTRIBUTES")),
    meshopt_encodeIndexBuffer: encode((encoder, indices, count) => encoder.encodeGltfBuffer(rowsAt(indices, 4 * count), count, 4, "TRIANGLES")),
    meshopt_encodeIndexSequence: encode((encoder, indices, count) => encoder.encodeGltfBuffer(rowsAt(indices, 4 * count), count, 4, "INDICES")),
    meshopt_encodeFilterOct: (out, count, stride, bits, from) => {
      const encoder = need("encoder");
      if (encoder) rowsAt(out, count * stride).set(encoder.encodeFilterOct(rowsAt(from, 16 * count), count, stride, bits));
    },
  };
}

/* ---- fflate: packed members of a zip */

const FULL = 1, DAMAGED = 2; // inflate_result (src/io/3mf/3mf.h)
const PIECE = 1 << 14;

/* Piece by piece, so that what unpacks to far more than the zip says is left early, without room for it. */
function inflateInto(out, bytes, { Inflate }) {
  let done = 0;
  const stream = new Inflate((part) => {
    if (part.length > out.length - done) throw new RangeError();
    out.set(part, done);
    done += part.length;
  });
  for (let at = 0; at < bytes.length; at += PIECE) stream.push(bytes.slice(at, at + PIECE), at + PIECE >= bytes.length);
  return done === out.length;
}

function deflateCalls(memory, need) {
  return {
    inflate_bytes: (from, packed, to, size) => {
      const library = need("deflate");
      if (!library) return FULL;
      try { return inflateInto(bytesAt(memory(), to, size), bytesAt(memory(), from, packed), library) ? 0 : DAMAGED; } catch { return DAMAGED; }
    },
    /* How many bytes it made; 0: there is no room for them. */
    deflate_bytes: (from, size, to, room) => {
      const library = need("deflate"), bytes = library?.deflateSync(bytesAt(memory(), from, size));
      if (!bytes || bytes.length > room) return 0;
      bytesAt(memory(), to, bytes.length).set(bytes);
      return bytes.length;
    },
  };
}

/* ---- all */

/* libraries: draco, meshopt, encoder and deflate, each () => a promise: of { factory, module }, of meshoptimizer's objects and of fflate's functions. */
export function makeDecoders(libraries) {
  const loaded = {}, missed = new Set();
  let host = null, draco = null;
  const need = (name) => {
    if (!loaded[name]) missed.add(name);
    return loaded[name];
  };
  const decodeDraco = (stream, found) => {
    if (!need("draco")) return MEMORY;
    draco ??= startDraco(loaded.draco);
    const used = draco;
    try {
      decodeStream(host, used, readStream(host, stream));
      return 0;
    } catch (error) { // what Draco itself throws, it throws where memory lacks or a stream is damaged
      draco = null;
      if (!(error instanceof Refusal)) return used.isFull ? MEMORY : BROKEN;
      numbersAt(host, found, 1)[0] = error.found;
      return error.result;
    }
  };
  const load = async (name) => { loaded[name] = await libraries[name](); };

  return {
    imports: { norma: { draco_decode: decodeDraco, ...meshoptCalls(() => host, need), ...deflateCalls(() => host, need) } },
    serve: (exports) => (host = exports),
    /* For a host that cannot wait while it reads. */
    loadAll: () => Promise.all(Object.keys(libraries).map(load)),
    /* work reads or writes a file; where it missed a library, that is loaded, and work done again. drop: releases what a try gave. prepare: a promise of what each try takes. */
    reading: async (work, drop = () => {}, prepare = async () => undefined) => {
      for (;;) {
        const prepared = await prepare();
        missed.clear();
        let result, failed = null;
        try { result = work(prepared); } catch (error) { failed = error; }
        if (!missed.size) {
          if (failed) throw failed;
          return result;
        }
        if (!failed) drop(result);
        await Promise.all([...missed].map(load));
      }
    },
  };
}

/* What reading takes, and writing: a trial of a fix encodes what was packed. compileDraco: () => a promise of draco.wasm as a WebAssembly.Module. */
export const allLibraries = (compileDraco) => ({
  draco: async () => {
    const [{ default: factory }, module] = await Promise.all([import("./draco-decoder.js"), compileDraco()]);
    return { factory, module };
  },
  meshopt: async () => {
    const { MeshoptDecoder } = await import("./meshopt-decoder.js");
    return MeshoptDecoder.ready.then(() => MeshoptDecoder);
  },
  encoder: async () => {
    const { MeshoptEncoder } = await import("./meshopt-encoder.js");
    return MeshoptEncoder.ready.then(() => MeshoptEncoder);
  },
  deflate: () => import("./deflate.js"),
});

/* For a module that is to read no file. */
export const noDecoders = makeDecoders({}).imports;
