/** Surface normals of meshes, kept right. Angles are degrees, matrices column-major, vectors columns: as in WebGL, glTF and three.js. */

/** Integers as they are: a common factor turns no direction. */
export type Vectors = Float32Array | Float64Array | Int8Array | Uint8Array | Uint8ClampedArray | Int16Array | Uint16Array;
export type Indices = Uint32Array | Uint16Array | Uint8Array;

/** What a face's corner weighs in the sum. `angle` (the default): Thürmer and Wüthrich 1998; `max`: Max 1999; `visible`: Aubry and Löhner 2008. */
export type Weight = "angle" | "area" | "uniform" | "max" | "angle-area" | "visible" | "angle-lengths";

export interface MeshOptions {
  /** Default: `"angle"`. */
  weight?: Weight;
  /** Which vertices share a normal: those at exactly equal positions (the default), none but the same index, or those joined by steps of at most this distance. */
  weld?: "exact" | "none" | number;
  /** Edges of three or more faces: a crease (the default), or smooth where the angle allows it. */
  nonManifold?: "hard" | "smooth";
  /** What has no normal of its own, as in a degenerate face: zero (the default), or the nearest normal there is. */
  fallback?: "zero" | "nearest";
}

export interface OutputOptions extends MeshOptions {
  /** Written to and returned, where it is given; at least as long as what is written. */
  out?: Float32Array | null;
}

export interface SplitOptions extends MeshOptions {
  /** Degrees: an edge that bends by at most this is smooth. Default: 60; 180 makes every shared edge smooth. */
  crease?: number;
}

export interface CreaseOptions extends OutputOptions {
  /** Degrees, as for splitting. Default: 60. */
  crease?: number;
}

export interface SplitMesh {
  /** For each corner, its new vertex. */
  indices: Uint32Array;
  /** For each new vertex, the old one: copy positions and other attributes by it. */
  sourceVertices: Uint32Array;
  /** Three floats for each new vertex. */
  normals: Float32Array;
}

export interface PlanOptions extends MeshOptions {
  /** One normal per vertex (the default) or per corner. */
  per?: "vertex" | "corner";
  /** Degrees. Default: 180 per vertex, 60 per corner. */
  crease?: number;
}

export interface Plan {
  /** How many normals an update gives. */
  readonly count: number;
  /** Bytes of the heap that the plan holds. */
  readonly bytes: number;
  /** Room for the positions in the module's heap: what is written here and handed to `update` is not copied. Ask anew after any other call: the heap may have moved. */
  readonly positions: Float32Array;
  /** Room for the normals in the module's heap, to be used as `out`. The same holds. */
  readonly normals: Float32Array;
  /** The normals at these positions; with `moved`, the vertices that moved since the last update, only the normals that they can change are written. */
  update(positions: Vectors, options?: { moved?: Uint32Array | ArrayLike<number> | null; out?: Float32Array | null }): Float32Array;
  /** Gives the memory back. The plan cannot be used afterwards; a second call does nothing. */
  free(): void;
}

/** `reversed` (the default): the sense of the inverse transpose, for faces that are reversed under a mirror. `kept`: the cofactor matrix. */
export type Winding = "kept" | "reversed";

export interface MatrixInfo {
  kind: "identity" | "translation" | "rotation" | "uniform-scale" | "non-uniform-scale" | "shear" | "singular";
  rank: number;
  mirrored: boolean;
  determinant: number;
  /** The largest over the smallest singular value; Infinity below rank 3. */
  anisotropy: number;
  /** By how many degrees the matrix itself errs at worst, where it is taken for its normal matrix. */
  worstErrorDeg: number;
  /** A unit normal for which it does. */
  worstNormal: Float32Array;
  /** What carries normals without an inverse, a mirror aside. */
  shortcut: "none" | "rotation" | "uniform-scale" | "axis-scale";
}

export interface Norma {
  readonly version: string;
  /** Three floats for each triangle. Without indices, every three positions are one. */
  faceNormals(positions: Vectors, indices?: Indices | null, options?: OutputOptions): Float32Array;
  faceNormals(positions: Vectors, options?: OutputOptions): Float32Array;
  /** Three floats for each position. */
  vertexNormals(positions: Vectors, indices?: Indices | null, options?: OutputOptions): Float32Array;
  vertexNormals(positions: Vectors, options?: OutputOptions): Float32Array;
  /** Three floats for each corner of each triangle. */
  cornerNormals(positions: Vectors, indices?: Indices | null, options?: CreaseOptions): Float32Array;
  cornerNormals(positions: Vectors, options?: CreaseOptions): Float32Array;
  /** The normals of corners as an indexed mesh: vertices are doubled only where a crease needs it. */
  split(positions: Vectors, indices?: Indices | null, options?: SplitOptions): SplitMesh;
  split(positions: Vectors, options?: SplitOptions): SplitMesh;
  /** For a mesh that moves: all that depends on its indices is done once. Shared positions and creases are those of the positions given here. */
  plan(positions: Vectors, indices?: Indices | null, options?: PlanOptions): Plan;
  plan(positions: Vectors, options?: PlanOptions): Plan;
  /** The 3x3 (nine floats) that carries normals through a model matrix of 16 numbers. Renormalise after it. */
  normalMatrix(model: ArrayLike<number>, options?: { winding?: Winding; out?: Float32Array | null }): Float32Array;
  /** Many: 16 numbers each, nine floats each. */
  normalMatrices(models: ArrayLike<number>, options?: { winding?: Winding; out?: Float32Array | null }): Float32Array;
  matrixInfo(model: ArrayLike<number>): MatrixInfo;
  /** Normals through a normal matrix, each made unit again. Zero stays zero. */
  transformNormals(normalMatrix: ArrayLike<number>, normals: Vectors, options?: { out?: Float32Array | null }): Float32Array;
}

/** What is thrown: the library's sentence, and in brackets what was wrong. */
export declare class NormaError extends Error {
  readonly result: "argument" | "capacity" | "index" | "memory" | "overflow";
}

/** Without an argument: the module that lies in the package as text. Or the address of `norma.wasm`, its bytes, or a compiled module. */
export declare function load(source?: string | URL | ArrayBuffer | ArrayBufferView | WebAssembly.Module): Promise<Norma>;
