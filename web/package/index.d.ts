/** Surface normals and tangents of meshes. Angles are degrees, matrices column-major, vectors columns: as in WebGL, glTF and three.js. */

/** Integers are taken as they are: a common factor turns no direction. */
export type Numbers = Float32Array | Float64Array | Int8Array | Uint8Array | Uint8ClampedArray | Int16Array | Uint16Array;

/** Vectors inside a larger array, as in an interleaved buffer. */
export interface StridedVectors {
  array: Numbers;
  /** Numbers of the array from one vector to the next. */
  stride: number;
  /** The number of the array with which the first vector begins. Default: 0. */
  offset?: number;
  /** How many vectors. Default: as many as fit. */
  count?: number;
}

/** Three numbers for each vector (texture coordinates: two), tightly packed, or a view with a stride. */
export type Vectors = Numbers | StridedVectors;
export type Indices = Uint32Array | Uint16Array | Uint8Array;

/** The weight of a face's corner in the sum. `angle` (the default): Thürmer and Wüthrich 1998; `max`: Max 1999; `visible`: Aubry and Löhner 2008. */
export type Weight = "angle" | "area" | "uniform" | "max" | "angle-area" | "visible" | "angle-lengths";

export interface MeshOptions {
  /** Default: `"angle"`. */
  weight?: Weight | undefined;
  /** Which vertices share a normal: those at exactly equal positions (the default), those of the same index only, or those joined by steps of at most this distance. */
  weld?: "exact" | "none" | number | undefined;
  /** Edges of three or more faces: a crease (the default), or smooth if the angle allows it. */
  nonManifold?: "hard" | "smooth" | undefined;
  /** What is written for a vertex without a normal of its own: zero (the default), or the nearest normal. */
  fallback?: "zero" | "nearest" | undefined;
  /** Also return how many elements have no normal, and why. Default: false. */
  report?: boolean | undefined;
}

export interface OutputOptions extends MeshOptions {
  /** Written to and returned; at least as long as what is written. */
  out?: Float32Array | null | undefined;
}

export interface SplitOptions extends MeshOptions {
  /** Degrees, 0 to 180: an edge that bends by at most this is smooth. Default: 60; 180 makes every shared edge smooth. */
  crease?: number | undefined;
}

export interface CreaseOptions extends OutputOptions {
  /** Degrees, 0 to 180: an edge that bends by at most this is smooth. Default: 60. */
  crease?: number | undefined;
}

/** How many elements (faces, vertices, corners) have no normal of their own, and unusual edges, which the calls that use creases count. */
export interface Report {
  degenerateFaces: number;
  nonFinite: number;
  unreferenced: number;
  cancelled: number;
  nonManifoldEdges: number;
  windingConflicts: number;
}

export interface ReportedNormals {
  normals: Float32Array;
  report: Report;
}

export interface SplitMesh {
  /** The new vertex of each corner. */
  indices: Uint32Array;
  /** For each new vertex, the old one: copy positions and other attributes by it. */
  sourceVertices: Uint32Array;
  /** Three floats for each new vertex. */
  normals: Float32Array;
}

export interface TangentOptions {
  /** `mikk` (the default): the bits of MikkTSpace. `steady`: the same tangents for any order of faces, for meshes without a baked map. */
  mode?: "mikk" | "steady" | undefined;
  /** For `steady`. Default: `"angle"`. */
  weight?: Weight | undefined;
  /** Written to and returned: four floats for each corner. */
  out?: Float32Array | null | undefined;
  /** Also return how many corners have no tangent of their own. Default: false. */
  report?: boolean | undefined;
}

/** How many corners have no tangent of their own. */
export interface TangentReport {
  degenerate: number;
  nonFinite: number;
  cancelled: number;
}

export interface ReportedTangents {
  tangents: Float32Array;
  report: TangentReport;
}

export interface PlanOptions extends Omit<MeshOptions, "report"> {
  /** One normal per vertex (the default) or per corner. */
  per?: "vertex" | "corner" | undefined;
  /** Degrees, 0 to 180. Default: 180 per vertex, 60 per corner. */
  crease?: number | undefined;
}

export interface UpdateOptions {
  /** The vertices that moved since the last update; only the normals that they can change are written. Needs `out`. */
  moved?: Uint32Array | ArrayLike<number> | null | undefined;
  /** Written to and returned. */
  out?: Float32Array | null | undefined;
  /** Also return the counts. Default: false. */
  report?: boolean | undefined;
}

export interface Plan {
  /** How many normals an update gives. */
  readonly count: number;
  /** Bytes of WebAssembly memory that the plan holds. */
  readonly bytes: number;
  /** Room for the positions in WebAssembly memory: positions written here and given to `update` are not copied. Ask again after any other call, because the memory may have moved. */
  readonly positions: Float32Array;
  /** Room for the normals in WebAssembly memory, for use as `out`. The same holds. */
  readonly normals: Float32Array;
  /** Computes the normals at these positions. */
  update(positions: Vectors, options: UpdateOptions & { report: true }): ReportedNormals;
  update(positions: Vectors, options?: UpdateOptions & { report?: false | undefined }): Float32Array;
  /** Releases the memory. The plan cannot be used afterwards; a second call does nothing. */
  free(): void;
}

/** `reversed` (the default): the sense of the inverse transpose, for faces that are reversed under a mirror. `kept`: the cofactor matrix. */
export type Winding = "kept" | "reversed";

export interface MatrixOptions {
  winding?: Winding | undefined;
  out?: Float32Array | null | undefined;
}

/** Octahedral with two numbers of 8, 12 or 16 bits, or three numbers of 10 bits. */
export type Encoding = "oct8" | "oct12" | "oct16" | "10-10-10-2";

export interface EncodeOptions {
  encoding?: Encoding | undefined;
  out?: Uint32Array | null | undefined;
  report?: boolean | undefined;
}

export interface DecodeOptions {
  encoding?: Encoding | undefined;
  out?: Float32Array | null | undefined;
}

/** The report counts normals that were encoded as (0, 0, 1): zero ones, and those that are not finite. */
export interface EncodedNormals {
  codes: Uint32Array;
  report: { nonFinite: number; cancelled: number };
}

export interface MatrixInfo {
  kind: "identity" | "translation" | "rotation" | "uniform-scale" | "non-uniform-scale" | "shear" | "singular";
  rank: number;
  mirrored: boolean;
  determinant: number;
  /** The largest over the smallest singular value; Infinity below rank 3. */
  anisotropy: number;
  /** The largest error in degrees if the matrix itself is used for normals. */
  worstErrorDeg: number;
  /** A unit normal with that error. */
  worstNormal: Float32Array;
  /** What transforms normals without an inverse, except for a mirror. */
  shortcut: "none" | "rotation" | "uniform-scale" | "axis-scale";
}

/** What `norma check --format json` prints: the schema norma-check/1. Numbers that do not apply are null or missing. */
export interface CheckReport {
  schema: "norma-check/1";
  files: CheckedFile[];
  summary: { errors: number; warnings: number; infos: number; files: number; not_checked: number };
}

export interface CheckedFile {
  path: string;
  profile: "render" | "print" | "generated";
  /** `partly`: a part could not be read; `unreadable`: the whole file could not. */
  status: "checked" | "partly" | "unreadable";
  findings: Finding[];
}

export type Point = [number, number, number];

export interface Finding {
  /** "N301" */
  rule: string;
  /** "inconsistent-winding" */
  name: string;
  severity: "error" | "warning" | "info";
  /**
   * JSON pointer of the glTF primitive, node or skin; "" for a whole OBJ, PLY or STL. In a .cmpt with several models it begins with the model's tile:
   * "/tiles/1/meshes/0/primitives/0".
   */
  where: string;
  count: number;
  worst: { value: number | null; unit: string; vertex: number | null; face: number | null; position: Point | null };
  samples: { vertex?: number; face?: number; normal?: number; position: Point | null }[];
  fix: "safe" | "unsafe" | null;
  /** Fixes it, to paste into a shell; null if no fix removes it (the message then says why). */
  command: string | null;
  message: string;
  /** How such a fault usually arises; the same for all findings of a rule. */
  cause: string;
  /** What it does to pictures or programs; the same for all findings of a rule. */
  impact: string;
  /** The same for findings of equal meshes, in whichever file; of errors and warnings. */
  mesh?: string;
  deviation?: Deviation;
}

/** How the stored normals were probably made, and how many corners are how far off. */
export interface Deviation {
  shading: "default" | "crease" | "smooth" | "flat";
  weight: Weight | null;
  crease_deg: number | null;
  mean_deg: number | null;
  p50_deg: number | null;
  p99_deg: number | null;
  max_deg: number | null;
  histogram: { below_deg: number; corners: number }[];
}

export interface CheckOptions {
  /** The name of the file; its ending decides the format: .glb, .gltf, .vrm, .obj, .ply, .stl, .3mf, .b3dm, .i3dm or .cmpt.
   * Default: "file.glb" or the like, by the first bytes; OBJ and STL need a name. */
  name?: string | undefined;
  /** What the surface is for. Default: `"auto"`, print for STL and render for the others. */
  profile?: "auto" | "render" | "print" | "generated" | undefined;
}

export type Bytes = ArrayBuffer | ArrayBufferView;

export interface FileOptions {
  /** The name of the file; its ending decides the format. Default: "file.glb" or the like, by the first bytes; OBJ and STL
   * need a name. */
  name?: string | undefined;
  /** Files that it refers to, by name: the buffers of a .gltf. */
  files?: Record<string, Bytes> | undefined;
}

export interface FixOptions extends FileOptions {
  /** Also changes that may not be intended: windings, sides, missing normals, transforms. Default: false. */
  unsafe?: boolean | undefined;
  profile?: CheckOptions["profile"];
  /** Only these rules: ids ("N301"), beginnings of ids ("N3") or names. */
  select?: string | string[] | undefined;
  ignore?: string | string[] | undefined;
}

export interface ComputeOptions extends FileOptions {
  /** Degrees, 0 to 180: edges that bend by more are hard. Default: 60; PLY: smooth. */
  crease?: number | undefined;
  /** No edge is hard, or all are. */
  smooth?: boolean | undefined;
  flat?: boolean | undefined;
  weight?: Weight | undefined;
  weld?: "exact" | "none" | number | undefined;
  nonManifold?: "hard" | "smooth" | undefined;
  /** `auto` (the default): the smoothing groups of an OBJ, if it has some, decide which edges are hard. */
  groups?: "auto" | "ignore" | undefined;
  /** Default: `"all"`. */
  only?: "all" | "missing" | "broken" | undefined;
  /** Also normals of morph targets that have none. */
  morphs?: boolean | undefined;
  /** What happens to tangents of a glTF. Default: `"orthogonalise"`. */
  tangents?: "keep" | "orthogonalise" | "regenerate" | undefined;
}

export interface InfoOptions extends FileOptions {
  /** Also whether meshes are closed, and how stored normals and tangents were made. */
  deep?: boolean | undefined;
}

/** The file, and other files that belong to it, by name: a buffer of a .gltf. */
export interface WrittenFile {
  bytes: Uint8Array;
  files: Record<string, Uint8Array>;
}

/** What `norma compute --json` and `norma info --json` print. */
export interface Summary {
  [key: string]: unknown;
  /** What info says of each model of a .cmpt with several, which has these, its path and its format alone. */
  tiles?: Summary[] | undefined;
}

type Reporting<Options> = Options & { report: true };
type Plain<Options> = Options & { report?: false | undefined };

export interface Norma {
  readonly version: string;
  /** Three floats for each triangle. Without indices, every three positions are a triangle. */
  faceNormals(positions: Vectors, indices: Indices | null | undefined, options: Reporting<OutputOptions>): ReportedNormals;
  faceNormals(positions: Vectors, options: Reporting<OutputOptions>): ReportedNormals;
  faceNormals(positions: Vectors, indices?: Indices | null, options?: Plain<OutputOptions>): Float32Array;
  faceNormals(positions: Vectors, options?: Plain<OutputOptions>): Float32Array;
  /** Three floats for each position. */
  vertexNormals(positions: Vectors, indices: Indices | null | undefined, options: Reporting<OutputOptions>): ReportedNormals;
  vertexNormals(positions: Vectors, options: Reporting<OutputOptions>): ReportedNormals;
  vertexNormals(positions: Vectors, indices?: Indices | null, options?: Plain<OutputOptions>): Float32Array;
  vertexNormals(positions: Vectors, options?: Plain<OutputOptions>): Float32Array;
  /** Three floats for each corner of each triangle. */
  cornerNormals(positions: Vectors, indices: Indices | null | undefined, options: Reporting<CreaseOptions>): ReportedNormals;
  cornerNormals(positions: Vectors, options: Reporting<CreaseOptions>): ReportedNormals;
  cornerNormals(positions: Vectors, indices?: Indices | null, options?: Plain<CreaseOptions>): Float32Array;
  cornerNormals(positions: Vectors, options?: Plain<CreaseOptions>): Float32Array;
  /** The normals of corners as an indexed mesh: vertices are doubled only where a crease needs it. */
  split(positions: Vectors, indices: Indices | null | undefined, options: Reporting<SplitOptions>): SplitMesh & { report: Report };
  split(positions: Vectors, options: Reporting<SplitOptions>): SplitMesh & { report: Report };
  split(positions: Vectors, indices?: Indices | null, options?: Plain<SplitOptions>): SplitMesh;
  split(positions: Vectors, options?: Plain<SplitOptions>): SplitMesh;
  /**
   * Four floats for each corner: x, y, z and a sign. The bitangent is sign * cross(normal, tangent) for the texture coordinates as given; glTF and three.js, whose v runs downwards,
   * need the sign negated. Normals and texture coordinates: one for each position or for each corner.
   */
  tangents(positions: Vectors, normals: Vectors, texcoords: Vectors, indices: Indices | null | undefined, options: Reporting<TangentOptions>): ReportedTangents;
  tangents(positions: Vectors, normals: Vectors, texcoords: Vectors, options: Reporting<TangentOptions>): ReportedTangents;
  tangents(positions: Vectors, normals: Vectors, texcoords: Vectors, indices?: Indices | null, options?: Plain<TangentOptions>): Float32Array;
  tangents(positions: Vectors, normals: Vectors, texcoords: Vectors, options?: Plain<TangentOptions>): Float32Array;
  /** For a mesh that moves: everything that depends on its indices is done once. Shared positions and creases are those of the positions given here. */
  plan(positions: Vectors, indices?: Indices | null, options?: PlanOptions): Plan;
  plan(positions: Vectors, options?: PlanOptions): Plan;
  /** The 3x3 (nine floats) that transforms normals by a model matrix of 16 numbers. Renormalise afterwards. */
  normalMatrix(model: ArrayLike<number>, options?: MatrixOptions): Float32Array;
  /** Many: 16 numbers each, nine floats each. */
  normalMatrices(models: ArrayLike<number>, options?: MatrixOptions): Float32Array;
  matrixInfo(model: ArrayLike<number>): MatrixInfo;
  /** Normals through a normal matrix, each made unit again. Zero stays zero. */
  transformNormals(normalMatrix: ArrayLike<number>, normals: Vectors, options?: { out?: Float32Array | null | undefined }): Float32Array;
  /** The nearest code of each normal, x in the lowest bits; "oct16" unless another is named. Zero and what is not finite become (0, 0, 1). */
  encodeNormals(normals: Vectors, options: Reporting<EncodeOptions>): EncodedNormals;
  encodeNormals(normals: Vectors, options?: Plain<EncodeOptions>): Uint32Array;
  /** The unit normals of codes, three floats each. */
  decodeNormals(codes: Uint32Array, options?: DecodeOptions): Float32Array;
  /** The largest angle, in degrees, between any unit vector and what its code is decoded to; proven. */
  encodingErrorDeg(encoding: Encoding): number;
  /** Looks for what is wrong with the normals and surfaces of a file in memory. The first call loads a second module, check.wasm. */
  check(bytes: Bytes, options?: CheckOptions): Promise<CheckReport>;
  /** Fixes what check finds, as `norma check --fix` does; the report is about the fixed file. The first of these three calls loads a third module, tool.wasm. */
  fix(bytes: Bytes, options?: FixOptions): Promise<WrittenFile & { report: CheckReport }>;
  /** The file with new normals, byte by byte what `norma compute` writes. */
  compute(bytes: Bytes, options?: ComputeOptions): Promise<WrittenFile & { summary: Summary }>;
  /** What is in a file. */
  info(bytes: Bytes, options?: InfoOptions): Promise<Summary>;
}

/** Hands the arrays of a call over to the worker instead of copying them: they are empty afterwards. `out` is always handed over, and returned. */
export interface Transfer {
  transfer?: boolean | undefined;
}

export interface WorkerPlan {
  readonly count: number;
  readonly bytes: number;
  update(positions: Vectors, options: UpdateOptions & Transfer & { report: true }): Promise<ReportedNormals>;
  update(positions: Vectors, options?: UpdateOptions & Transfer & { report?: false | undefined }): Promise<Float32Array>;
  free(): Promise<void>;
}

/** The same calls as promises, answered by a worker. */
export interface NormaWorker {
  readonly version: string;
  faceNormals(positions: Vectors, indices: Indices | null | undefined, options: Reporting<OutputOptions & Transfer>): Promise<ReportedNormals>;
  faceNormals(positions: Vectors, indices?: Indices | null, options?: Plain<OutputOptions & Transfer>): Promise<Float32Array>;
  vertexNormals(positions: Vectors, indices: Indices | null | undefined, options: Reporting<OutputOptions & Transfer>): Promise<ReportedNormals>;
  vertexNormals(positions: Vectors, indices?: Indices | null, options?: Plain<OutputOptions & Transfer>): Promise<Float32Array>;
  cornerNormals(positions: Vectors, indices: Indices | null | undefined, options: Reporting<CreaseOptions & Transfer>): Promise<ReportedNormals>;
  cornerNormals(positions: Vectors, indices?: Indices | null, options?: Plain<CreaseOptions & Transfer>): Promise<Float32Array>;
  split(positions: Vectors, indices: Indices | null | undefined, options: Reporting<SplitOptions & Transfer>): Promise<SplitMesh & { report: Report }>;
  split(positions: Vectors, indices?: Indices | null, options?: Plain<SplitOptions & Transfer>): Promise<SplitMesh>;
  tangents(positions: Vectors, normals: Vectors, texcoords: Vectors, indices: Indices | null | undefined, options: Reporting<TangentOptions & Transfer>): Promise<ReportedTangents>;
  tangents(positions: Vectors, normals: Vectors, texcoords: Vectors, indices?: Indices | null, options?: Plain<TangentOptions & Transfer>): Promise<Float32Array>;
  plan(positions: Vectors, indices?: Indices | null, options?: PlanOptions & Transfer): Promise<WorkerPlan>;
  normalMatrix(model: ArrayLike<number>, options?: MatrixOptions & Transfer): Promise<Float32Array>;
  normalMatrices(models: ArrayLike<number>, options?: MatrixOptions & Transfer): Promise<Float32Array>;
  matrixInfo(model: ArrayLike<number>): Promise<MatrixInfo>;
  transformNormals(normalMatrix: ArrayLike<number>, normals: Vectors, options?: { out?: Float32Array | null | undefined } & Transfer): Promise<Float32Array>;
  encodeNormals(normals: Vectors, options: Reporting<EncodeOptions & Transfer>): Promise<EncodedNormals>;
  encodeNormals(normals: Vectors, options?: Plain<EncodeOptions & Transfer>): Promise<Uint32Array>;
  decodeNormals(codes: Uint32Array, options?: DecodeOptions & Transfer): Promise<Float32Array>;
  encodingErrorDeg(encoding: Encoding): Promise<number>;
  check(bytes: Bytes, options?: CheckOptions & Transfer): Promise<CheckReport>;
  fix(bytes: Bytes, options?: FixOptions & Transfer): Promise<WrittenFile & { report: CheckReport }>;
  compute(bytes: Bytes, options?: ComputeOptions & Transfer): Promise<WrittenFile & { summary: Summary }>;
  info(bytes: Bytes, options?: InfoOptions & Transfer): Promise<Summary>;
  /** Ends the worker. Calls that wait are rejected. */
  terminate(): void;
}

/** What is thrown. The message begins with the argument that is wrong. */
export declare class NormaError extends Error {
  readonly result: "argument" | "capacity" | "index" | "memory" | "overflow";
}

/** The address of a module, its bytes, or a compiled WebAssembly.Module. */
export type ModuleSource = string | URL | Bytes | WebAssembly.Module;

export interface LoadOptions {
  /** Where check.wasm is. Default: beside the package's other files. */
  check?: ModuleSource | undefined;
  /** Where draco.wasm is, which is loaded when a file with Draco's compression is first checked. Default: beside the package's other files. */
  draco?: ModuleSource | undefined;
  /** Where tool.wasm is, which fix, compute and info load. Default: beside the package's other files. */
  tool?: ModuleSource | undefined;
}

/** Without a source: norma.wasm from this package, loaded once. */
export declare function load(source?: ModuleSource | null, options?: LoadOptions): Promise<Norma>;

/** The same calls as promises, in a worker of their own. */
export declare function loadWorker(source?: ModuleSource | null, options?: LoadOptions): Promise<NormaWorker>;
