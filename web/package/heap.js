/* The heap of a module, lent out for one call at a time. An array that lies in the heap already is used where it is; any other is copied in, or out, once. */
export function makeHeap(memory, reserve, release, onFull) {
  const inHeap = (array) => array.buffer === memory.buffer;
  const bytesOf = (array) => new Uint8Array(array.buffer, array.byteOffset, array.byteLength);

  const allocate = (bytes) => reserve(bytes) >>> 0 || onFull(bytes);

  const copyIn = (array, at) => new Uint8Array(memory.buffer, at, array.byteLength).set(bytesOf(array));
  const copyOut = (at, array, length = array.length) => {
    const bytes = length * array.BYTES_PER_ELEMENT;
    new Uint8Array(array.buffer, array.byteOffset, bytes).set(new Uint8Array(memory.buffer, at, bytes));
  };

  /* Hands work a lender; what it lent is released when work is done, whichever way. */
  const lend = (work) => {
    const blocks = [];
    const block = (bytes) => {
      const at = allocate(bytes);
      blocks.push(at);
      return at;
    };
    const input = (array) => {
      if (inHeap(array)) return array.byteOffset;
      const at = block(array.byteLength);
      copyIn(array, at);
      return at;
    };
    /* Where length elements of array are to be written, and how they reach it. keep: what array holds is read as well. */
    const output = (array, length, keep = false) => {
      if (inHeap(array)) return { at: array.byteOffset, fetch: () => array };
      const at = block(length * array.BYTES_PER_ELEMENT);
      if (keep) copyIn(array.subarray(0, length), at);
      return { at, fetch: () => (copyOut(at, array, length), array) };
    };
    try {
      return work({ block, input, output, copyOut });
    } finally {
      for (const at of blocks) release(at);
    }
  };

  const text = (at) => {
    const bytes = new Uint8Array(memory.buffer), from = at >>> 0;
    return new TextDecoder().decode(bytes.slice(from, bytes.indexOf(0, from)));
  };
  const doubles = (at, count) => Array.from(new Float64Array(memory.buffer, at >>> 0, count));

  return { lend, text, doubles, allocate, copyIn, copyOut, inHeap };
}

/* A module that lies in a script as base64. */
export function decode(text) {
  const characters = atob(text), bytes = new Uint8Array(characters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = characters.charCodeAt(i);
  return bytes;
}
