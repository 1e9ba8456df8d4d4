/** Normals and tangents of three.js geometries. After `await load()` every call is synchronous. Angles are degrees. */
import type { BufferGeometry } from "three";
import type { Report, Weight } from "./index.js";

export { load } from "./index.js";

export interface NormalOptions {
  /** Default: `"angle"`. `"area"` is the weight of computeVertexNormals. */
  weight?: Weight | undefined;
  /** Which vertices share a normal: those at equal positions (the default), those of the same index only, as in computeVertexNormals, or those joined by steps of at most this distance. */
  weld?: "exact" | "none" | number | undefined;
  /** Edges of three or more faces: a crease (the default), or smooth if the angle allows it. */
  nonManifold?: "hard" | "smooth" | undefined;
  /** What a vertex without a normal of its own gets. Default: `"zero"`; toCreased: `"nearest"`. */
  fallback?: "zero" | "nearest" | undefined;
  /** Return the counts of what has no normal of its own, too: of vertices; toCreased: of corners. Default: false. */
  report?: boolean | undefined;
}

export interface CreasedOptions extends NormalOptions {
  /** Degrees, 0 to 180: an edge that bends by at most this is smooth. Default: 60. */
  crease?: number | undefined;
}

export interface TangentOptions {
  /** `mikk` (the default): the bits of MikkTSpace. `steady`: the same for any order of faces. */
  mode?: "mikk" | "steady" | undefined;
  /** For `steady`. Default: `"angle"`. */
  weight?: Weight | undefined;
  /** Negate w, as three.js and glTF need it. Default: true. */
  negateSign?: boolean | undefined;
  /** The channel of the normal map: 0 stands for the attribute uv, 1 for uv1. Default: 0. */
  texcoord?: 0 | 1 | 2 | 3 | undefined;
  /** Return the counts of corners without a tangent of their own, too. Default: false. */
  report?: boolean | undefined;
}

export interface PlanForOptions extends Omit<NormalOptions, "report"> {
  /** Degrees, 0 to 180. Default: 180. */
  crease?: number | undefined;
}

export interface GeometryPlan {
  /** Reads the geometry's positions and writes its normals. moved: the vertices that moved since the last update. */
  update(options: { moved?: Uint32Array | ArrayLike<number> | undefined; report: true }): Report;
  update(options?: { moved?: Uint32Array | ArrayLike<number> | undefined; report?: false | undefined }): void;
  /** Releases the memory; the geometry's dispose() does so too. */
  free(): void;
  /** Bytes of WebAssembly memory that the plan holds. */
  readonly bytes: number;
}

/** Writes one normal per vertex, in place, and the normals of morph targets. */
export declare function computeNormals<Geometry extends BufferGeometry>(geometry: Geometry, options: NormalOptions & { report: true }): { geometry: Geometry; report: Report };
export declare function computeNormals<Geometry extends BufferGeometry>(geometry: Geometry, options?: NormalOptions & { report?: false | undefined }): Geometry;

/** A new geometry with creases: vertices are doubled only where one is, and take all attributes along. Without an index it stays without. */
export declare function toCreased(geometry: BufferGeometry, options: CreasedOptions & { report: true }): { geometry: BufferGeometry; report: Report };
export declare function toCreased(geometry: BufferGeometry, options?: CreasedOptions & { report?: false | undefined }): BufferGeometry;

/** Writes tangents, in place. An indexed geometry stays indexed: vertices are added only where the tangents of their corners differ. */
export declare function computeTangents<Geometry extends BufferGeometry>(geometry: Geometry, options: TangentOptions & { report: true }): { geometry: Geometry; report: { degenerate: number; nonFinite: number; cancelled: number } };
export declare function computeTangents<Geometry extends BufferGeometry>(geometry: Geometry, options?: TangentOptions & { report?: false | undefined }): Geometry;

/** For a geometry that moves: everything that depends on its index is done once. */
export declare function planFor(geometry: BufferGeometry, options?: PlanForOptions): GeometryPlan;
