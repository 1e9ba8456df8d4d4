/* Draco's streams (KHR_draco_mesh_compression): check.wasm and the page's module hand each to draco.wasm, a module of its own with a memory of its own, which is loaded when the first is met. */

const OK = 0, MEMORY = 1, BROKEN = 2;
const STREAM = 8, VALUES = 4; // 32-bit numbers in a draco_stream and in a draco_values (src/io/gltf/draco_decoder.h)
const BYTES_OF = { 5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4 };

const numbersAt = (wasm, at, count) => new Uint32Array(wasm.memory.buffer, at >>> 0, count);
const bytesAt = (wasm, at, size) => new Uint8Array(wasm.memory.buffer, at >>> 0, size);
const align = (size) => (size + 7) & ~7;

/* Copies what host asks for over to draco, has it decoded, and copies the values back. */
function carry(host, draco, streamAt, foundAt) {
  const [from, size, points, faces, attributesAt, count, indicesAt, most] = numbersAt(host, streamAt, STREAM);
  const readValues = (at, elements) => {
    const [id, width, component, out] = numbersAt(host, at, VALUES);
    return { id, width, component, out, size: elements * width * BYTES_OF[component] };
  };
  const wanted = Array.from({ length: count }, (_, i) => readValues(attributesAt + 4 * VALUES * i, points));
  if (indicesAt) wanted.push(readValues(indicesAt, 3 * faces));

  const valuesAt = align(4 * (STREAM + 1)), bytesFrom = align(valuesAt + 4 * VALUES * wanted.length), total = wanted.reduce((sum, values) => sum + align(values.size), bytesFrom + align(size));
  const base = total < 2 ** 32 ? draco.draco_allocate(total) >>> 0 : 0;
  if (!base) return MEMORY;
  let next = base + bytesFrom + align(size);
  const placed = wanted.map((values) => { const at = next; next += align(values.size); return { ...values, at }; });
  numbersAt(draco, base, STREAM).set([base + bytesFrom, size, points, faces, base + valuesAt, count, indicesAt ? base + valuesAt + 4 * VALUES * count : 0, most]);
  placed.forEach(({ id, width, component, at }, i) => numbersAt(draco, base + valuesAt + 4 * VALUES * i, VALUES).set([id, width, component, at]));
  bytesAt(draco, base + bytesFrom, size).set(bytesAt(host, from, size));
  const result = draco.draco_decode(base, base + 4 * STREAM);
  numbersAt(host, foundAt, 1)[0] = numbersAt(draco, base + 4 * STREAM, 1)[0];
  if (result === OK) for (const values of placed) bytesAt(host, values.out, values.size).set(bytesAt(draco, values.at, values.size));
  draco.draco_release(base);
  return result;
}

/* compile: () => a promise of draco.wasm as a WebAssembly.Module. */
export function makeDraco(compile) {
  let host = null, module = null, draco = null, isMissed = false;

  const decode = (stream, found) => {
    isMissed = !module;
    if (!module) return MEMORY;
    draco ??= new WebAssembly.Instance(module).exports;
    const used = draco;
    try {
      return carry(host, used, stream, found);
    } catch { // it trapped: a stream that is damaged, or memory that is not to be had
      draco = null;
      return used.draco_is_out_of_memory() ? MEMORY : BROKEN;
    }
  };

  return {
    imports: { norma: { draco_decode: decode } },
    serve: (exports) => (host = exports),
    /* work reads a file; where it met a stream for which the module was not there yet, that is loaded, and work done again. drop: releases what the first try gave. */
    reading: async (work, drop = () => {}) => {
      isMissed = false;
      let result, failed = null;
      try { result = work(); } catch (error) { failed = error; }
      if (isMissed) {
        if (!failed) drop(result);
        module = await compile();
        return work();
      }
      if (failed) throw failed;
      return result;
    },
  };
}
