/* What a caller may hand over, and what is said of everything else. Messages begin with the library's own sentence. */

export const RESULT = { OK: 0, ARGUMENT: -1, CAPACITY: -2, INDEX: -3, MEMORY: -4, OVERFLOW: -5 };
const RESULT_NAMES = Object.fromEntries(Object.entries(RESULT).map(([name, number]) => [number, name.toLowerCase()]));

const WEIGHTS = ["angle", "area", "uniform", "max", "angle-area", "visible", "angle-lengths"];
const WELDS = ["exact", "none"];
const WELD_DISTANCE = 2;
const NON_MANIFOLD = ["hard", "smooth"];
const FALLBACKS = ["zero", "nearest"];
const WINDINGS = ["kept", "reversed"];
const ELEMENTS = ["vertex", "corner"];

/* norma_format of each kind of array. */
const FORMATS = { Float32Array: 0, Float64Array: 1, Int8Array: 2, Uint8Array: 3, Uint8ClampedArray: 3, Int16Array: 4, Uint16Array: 5 };
const INDEX_KINDS = ["Uint32Array", "Uint16Array", "Uint8Array"];

export class NormaError extends Error {
  constructor(text, result, detail) {
    super(detail ? `${text} (${detail})` : text);
    this.name = "NormaError";
    this.result = RESULT_NAMES[result] ?? "argument";
  }
}

/* The checks, over the text that the library gives a result. */
export function makeChecks(textOf) {
  const fail = (result, detail) => { throw new NormaError(textOf(result), result, detail); };
  const wrong = (detail) => fail(RESULT.ARGUMENT, detail);

  const kindOf = (array) => (ArrayBuffer.isView(array) ? array[Symbol.toStringTag] : undefined);
  const spell = (value) => (typeof value === "string" ? JSON.stringify(value) : kindOf(value) ?? (Array.isArray(value) ? "an Array" : String(value)));

  const numberOf = (names, value, what) => {
    const number = names.indexOf(value);
    return number < 0 ? wrong(`${what}: ${spell(value)} is none of ${names.map((name) => `"${name}"`).join(", ")}`) : number;
  };

  /* A typed array of vectors of three: its norma_format. */
  const vectors = (array, what) => {
    const format = FORMATS[kindOf(array)];
    if (format === undefined) wrong(`${what}: ${spell(array)} is none of ${Object.keys(FORMATS).join(", ")}`);
    if (array.length % 3 !== 0) wrong(`${what}: ${array.length} numbers are no whole number of vectors of three`);
    return format;
  };

  const indices = (array, positions) => {
    const there = array !== undefined && array !== null;
    if (there && !INDEX_KINDS.includes(kindOf(array))) wrong(`indices: ${spell(array)} is none of ${INDEX_KINDS.join(", ")}`);
    const corners = there ? array.length : positions.length / 3;
    if (corners % 3 !== 0) wrong(`${there ? "indices" : "positions without indices"}: ${corners} corners are no whole number of triangles`);
    return corners;
  };

  const weld = (value) => {
    if (typeof value !== "number") return [numberOf(WELDS, value, "weld"), 0];
    return value >= 0 && value < Infinity ? [WELD_DISTANCE, value] : wrong(`weld: ${value} is no distance`);
  };

  const options = (value) => (value === undefined || value === null ? {} : typeof value === "object" ? value : wrong(`options: ${spell(value)} is no object`));

  const degrees = (value, what) =>
    typeof value === "number" && !Number.isNaN(value) ? value : wrong(`${what}: ${spell(value)} is no angle in degrees`);

  /* Room for length floats: a new array where none is given. */
  const output = (array, length, what = "out") => {
    if (array === undefined || array === null) return new Float32Array(length);
    if (kindOf(array) !== "Float32Array") wrong(`${what}: ${spell(array)} is no Float32Array`);
    return array.length < length ? fail(RESULT.CAPACITY, `${what}: ${array.length} floats where ${length} are needed`) : array;
  };

  /* length numbers, or a multiple of them, as floats. */
  const floats = (array, length, what, many = false) => {
    if (!ArrayBuffer.isView(array) && !Array.isArray(array)) wrong(`${what}: ${spell(array)} is no array of numbers`);
    if (many ? array.length % length !== 0 : array.length !== length) wrong(`${what}: ${array.length} numbers, not ${many ? "a multiple of " : ""}${length}`);
    if (kindOf(array) === "Float32Array") return array;
    if (!Array.prototype.every.call(array, (number) => typeof number === "number")) wrong(`${what}: not all of it are numbers`);
    return Float32Array.from(array);
  };

  const moved = (array, count) => {
    if (array === undefined || array === null) return null;
    if (kindOf(array) === "Uint32Array") return array;
    if (!ArrayBuffer.isView(array) && !Array.isArray(array)) wrong(`moved: ${spell(array)} is no array of vertices`);
    const isVertex = (vertex) => Number.isInteger(vertex) && vertex >= 0 && vertex < count;
    if (!Array.prototype.every.call(array, isVertex)) fail(RESULT.INDEX, `moved: a vertex that is none of the ${count}`);
    return Uint32Array.from(array);
  };

  return {
    fail, wrong, vectors, indices, options, degrees, output, floats, moved, weld,
    weight: (value) => numberOf(WEIGHTS, value, "weight"),
    nonManifold: (value) => numberOf(NON_MANIFOLD, value, "nonManifold"),
    fallback: (value) => numberOf(FALLBACKS, value, "fallback"),
    winding: (value) => numberOf(WINDINGS, value, "winding"),
    element: (value) => numberOf(ELEMENTS, value, "per"),
  };
}
