/* Checks every argument before anything is computed. Messages begin with the argument that is wrong. */

export const RESULT = { OK: 0, ARGUMENT: -1, CAPACITY: -2, INDEX: -3, MEMORY: -4, OVERFLOW: -5 };
const RESULT_NAMES = { [-1]: "argument", [-2]: "capacity", [-3]: "index", [-4]: "memory", [-5]: "overflow" };

const WEIGHTS = ["angle", "area", "uniform", "max", "angle-area", "visible", "angle-lengths"];
const WELDS = ["exact", "none"];
const WELD_DISTANCE = 2;
const NON_MANIFOLD = ["hard", "smooth"];
const FALLBACKS = ["zero", "nearest"];
const WINDINGS = ["kept", "reversed"];
const ELEMENTS = ["vertex", "corner"];
const TANGENT_MODES = ["steady", "mikk"];
const ENCODINGS = ["oct8", "oct12", "oct16", "10-10-10-2"];
const PROFILES = ["auto", "render", "print", "generated"];

/* norma_format of each kind of array. */
const FORMATS = { Float32Array: 0, Float64Array: 1, Int8Array: 2, Uint8Array: 3, Uint8ClampedArray: 3, Int16Array: 4, Uint16Array: 5 };
const INDEX_KINDS = ["Uint32Array", "Uint16Array", "Uint8Array"];
const STRIDED = ["array", "stride", "offset", "count"];

export class NormaError extends Error {
  constructor(message, result = "argument") {
    super(message);
    this.name = "NormaError";
    this.result = result;
  }
}

export const kindOf = (array) => (ArrayBuffer.isView(array) ? array[Symbol.toStringTag] : undefined);
const isObject = (value) => typeof value === "object" && value !== null && !ArrayBuffer.isView(value) && !Array.isArray(value);

export function spell(value) {
  if (typeof value === "string") return JSON.stringify(value);
  if (Array.isArray(value)) return "an Array";
  return kindOf(value) ?? (isObject(value) ? `an object with ${Object.keys(value).slice(0, 4).join(", ") || "nothing in it"}` : String(value));
}

export const fail = (message, result = RESULT.ARGUMENT) => { throw new NormaError(message, RESULT_NAMES[result] ?? "argument"); };

const list = (names) => names.map((name) => `"${name}"`).join(", ");

export const numberOf = (names, value, what) => {
  const number = names.indexOf(value);
  return number < 0 ? fail(`${what}: ${spell(value)} is not one of ${list(names)}`) : number;
};

export const weight = (value = "angle") => numberOf(WEIGHTS, value, "weight");
export const nonManifold = (value = "hard") => numberOf(NON_MANIFOLD, value, "nonManifold");
export const fallback = (value = "zero") => numberOf(FALLBACKS, value, "fallback");
export const winding = (value = "reversed") => numberOf(WINDINGS, value, "winding");
export const element = (value = "vertex") => numberOf(ELEMENTS, value, "per");
export const tangentMode = (value = "mikk") => numberOf(TANGENT_MODES, value, "mode");
export const encoding = (value = "oct16") => numberOf(ENCODINGS, value, "encoding");
export const profile = (value = "auto") => numberOf(PROFILES, value, "profile");

export const flag = (value, what) => (value === undefined || typeof value === "boolean" ? value === true : fail(`${what}: ${spell(value)} is neither true nor false`));

/* [norma_weld, distance] */
export const weld = (value = "exact") => {
  if (typeof value !== "number") return [WELDS.includes(value) ? WELDS.indexOf(value) : fail(`weld: ${spell(value)} is neither "exact", "none" nor a distance`), 0];
  return value >= 0 && value < Infinity ? [WELD_DISTANCE, value] : fail(`weld: ${value} is not a distance; it must be finite and at least 0`);
};

/* The bytes of a buffer whose memory may be gone. */
const bytesOf = (buffer, what, ...part) => {
  try {
    return new Uint8Array(buffer, ...part);
  } catch {
    return fail(`${what}: its memory is gone: it was handed over to a worker, or is a view of WebAssembly memory that has grown since`);
  }
};
/* Such an array has no length: looked at only then. */
const alive = (array, what) => { if (array.length === 0) bytesOf(array.buffer, what); };

/* The options of a call that takes those named in known, separated by spaces. */
export const options = (value, known) => {
  if (value === undefined || value === null) return {};
  if (!isObject(value)) fail(`options: ${spell(value)} is not an object`);
  const names = known.split(" ");
  for (const name of Object.keys(value)) if (!names.includes(name)) fail(`options: ${name} is not an option of this call; it takes ${names.join(", ")}`);
  return value;
};

/* standard: where none is given. */
export const crease = (value, standard = 60) => {
  if (value === undefined) return standard;
  if (typeof value !== "number" || Number.isNaN(value)) fail(`crease: ${spell(value)} is not an angle in degrees`);
  return value >= 0 && value <= 180 ? value : fail(`crease: ${value} is out of range; an angle from 0 to 180 degrees is expected`);
};

const whole = (value, what, least) => (Number.isInteger(value) && value >= least ? value : fail(`${what}: ${spell(value)} is not a whole number of at least ${least}`));

/* An array of which a view with a stride takes some: what lies from its first number to its last. */
const strided = (given, size, what) => {
  for (const name of Object.keys(given))
    if (!STRIDED.includes(name)) fail(`${what}: ${name} is not expected in a view; give { array, stride, offset, count }, numbers of the array (for three.js use norma-mesh/three)`);
  const { array, offset = 0 } = given, format = FORMATS[kindOf(array)];
  if (format === undefined) fail(`${what}.array: ${spell(array)} is not one of ${Object.keys(FORMATS).join(", ")}`);
  alive(array, `${what}.array`);
  const stride = whole(given.stride, `${what}.stride`, size);
  whole(offset, `${what}.offset`, 0);
  const most = array.length < offset + size ? 0 : Math.floor((array.length - offset - size) / stride) + 1;
  const count = given.count === undefined ? most : whole(given.count, `${what}.count`, 0);
  if (count > most) fail(`${what}: ${count} vectors ${stride} numbers apart from ${offset} on do not fit into ${array.length} numbers`);
  const used = array.subarray(offset, count === 0 ? offset : offset + (count - 1) * stride + size);
  return { array: used, count, stride: stride * array.BYTES_PER_ELEMENT, format };
};

/* Vectors of size numbers: a typed array, tightly packed, or a view with a stride. stride: bytes. */
export const vectors = (given, what, size = 3) => {
  if (isObject(given) && "array" in given) return strided(given, size, what);
  const format = FORMATS[kindOf(given)];
  if (format === undefined) fail(`${what}: ${spell(given)} is not one of ${Object.keys(FORMATS).join(", ")}, nor a view { array, stride }`);
  alive(given, what);
  if (given.length % size !== 0) fail(`${what}: ${given.length} numbers are not a multiple of ${size}`);
  return { array: given, count: given.length / size, stride: size * given.BYTES_PER_ELEMENT, format };
};

/* How many corners; indices may be left out. */
export const corners = (indices, vertices) => {
  const there = indices !== undefined && indices !== null;
  if (there && !INDEX_KINDS.includes(kindOf(indices))) fail(`indices: ${spell(indices)} is not one of ${INDEX_KINDS.join(", ")}`);
  if (there) alive(indices, "indices");
  const count = there ? indices.length : vertices;
  if (count % 3 !== 0) fail(there ? `indices: ${count} are not a multiple of 3` : `positions: ${count} without indices are not a multiple of 3`);
  return count;
};

/* Says which index is wrong, once the library has found that one is. */
export const failAtIndex = (indices, vertices) => {
  const corner = indices ? indices.findIndex((vertex) => vertex >= vertices) : -1;
  fail(corner < 0 ? `indices: a vertex does not exist; there are ${vertices}` : `indices: number ${corner} is ${indices[corner]}, but there are only ${vertices} positions`, RESULT.INDEX);
};

/* Room for length numbers, floats or another kind: a new array if none is given. */
export const output = (array, length, kind = "Float32Array") => {
  if (array === undefined || array === null) return new globalThis[kind](length);
  if (kindOf(array) !== kind) fail(`out: ${spell(array)} is not a ${kind}`);
  alive(array, "out");
  return array.length < length ? fail(`out: ${array.length} ${kind === "Float32Array" ? "floats" : "numbers"}, but ${length} are written`, RESULT.CAPACITY) : array;
};

export const codes = (array) => {
  if (kindOf(array) !== "Uint32Array") fail(`codes: ${spell(array)} is not a Uint32Array`);
  alive(array, "codes");
  return array;
};

/* length numbers, or a multiple of them, as floats. */
export const floats = (array, length, what, many = false) => {
  if (!ArrayBuffer.isView(array) && !Array.isArray(array)) fail(`${what}: ${spell(array)} is not an array of numbers`);
  if (ArrayBuffer.isView(array)) alive(array, what);
  if (many ? array.length % length !== 0 : array.length !== length) fail(`${what}: ${array.length} numbers are not ${many ? "a multiple of " : ""}${length}`);
  if (kindOf(array) === "Float32Array") return array;
  const wrong = Array.prototype.findIndex.call(array, (number) => typeof number !== "number");
  if (wrong >= 0) fail(`${what}: element ${wrong} is ${spell(array[wrong])}, not a number`);
  return Float32Array.from(array);
};

/* The vertices that moved; null: all. */
export const moved = (array, count) => {
  if (array === undefined || array === null) return null;
  if (!ArrayBuffer.isView(array) && !Array.isArray(array)) fail(`moved: ${spell(array)} is not an array of vertices`);
  if (ArrayBuffer.isView(array)) alive(array, "moved");
  const isWrong = kindOf(array) === "Uint32Array" ? (vertex) => vertex >= count : (vertex) => !(Number.isInteger(vertex) && vertex >= 0 && vertex < count);
  const wrong = Array.prototype.findIndex.call(array, isWrong);
  if (wrong >= 0) fail(`moved: element ${wrong} is ${spell(array[wrong])}, but the plan has vertices 0 to ${count - 1}`, RESULT.INDEX);
  return kindOf(array) === "Uint32Array" ? array : Uint32Array.from(array);
};

/* The bytes of a file. */
export const bytes = (given, what = "bytes") => {
  if (ArrayBuffer.isView(given)) return given.byteLength ? new Uint8Array(given.buffer, given.byteOffset, given.byteLength) : bytesOf(given.buffer, what, 0, 0);
  const kind = Object.prototype.toString.call(given);
  return kind === "[object ArrayBuffer]" || kind === "[object SharedArrayBuffer]" ? bytesOf(given, what) : fail(`${what}: ${spell(given)} is neither an ArrayBuffer nor a typed array`);
};

export const name = (value, what = "name") => (typeof value === "string" && value !== "" && !value.includes("\0") ? value : fail(`${what}: ${spell(value)} is not the name of a file, such as "chair.glb"`));

/* Beginnings by which a file without a name is known; OBJ and STL have none. */
const BEGINNINGS = { glTF: "glb", ply: "ply", b3dm: "b3dm", i3dm: "i3dm", cmpt: "cmpt", "PK\x03\x04": "3mf" };
const WHITE = [0x20, 0x09, 0x0a, 0x0b, 0x0c, 0x0d];

/* The name of a file, or one whose ending says what its bytes are. */
export const fileName = (value, bytes) => {
  if (value !== undefined) return name(value);
  const first = String.fromCharCode(...bytes.subarray(0, 8)), known = Object.keys(BEGINNINGS).find((beginning) => first.startsWith(beginning));
  if (known) return `file.${BEGINNINGS[known]}`;
  if (bytes.find((byte) => !WHITE.includes(byte)) === 0x7b) return "file.gltf"; // the brace of JSON
  return fail(`name: bytes that begin with ${spell(first)} may be of any format; give a name that ends in it, such as "chair.obj"`);
};
