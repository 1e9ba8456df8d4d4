/** Normals and tangents of three.js geometries. After `await load()` every call is synchronous. Angles are degrees. */
import type { BufferGeometry } from "three";
import type { NormaWorker, Report, TangentReport } from "./index.js";
import type { CreasedOptions, NormalOptions, TangentOptions as SharedTangentOptions } from "./vertices.js";

export { load } from "./index.js";
export type { CreasedOptions, NormalOptions };

export interface TangentOptions extends SharedTangentOptions {
  /** Negate w, as three.js and glTF need it. Default: true. */
  negateSign?: boolean | undefined;
  /** The channel of the normal map: 0 stands for the attribute uv, 1 for uv1. Default: 0. */
  texcoord?: 0 | 1 | 2 | 3 | undefined;
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
export declare function computeTangents<Geometry extends BufferGeometry>(geometry: Geometry, options: TangentOptions & { report: true }): { geometry: Geometry; report: TangentReport };
export declare function computeTangents<Geometry extends BufferGeometry>(geometry: Geometry, options?: TangentOptions & { report?: false | undefined }): Geometry;

/** For a geometry that moves: everything that depends on its index is done once. */
export declare function planFor(geometry: BufferGeometry, options?: PlanForOptions): GeometryPlan;

export interface WorkerGeometryPlan {
  /** Reads the geometry's positions, once updates before it are done, and writes its normals when the promise is kept. moved: the vertices that moved since the last update. */
  update(options: { moved?: Uint32Array | ArrayLike<number> | undefined; report: true }): Promise<Report>;
  update(options?: { moved?: Uint32Array | ArrayLike<number> | undefined; report?: false | undefined }): Promise<void>;
  /** Releases the memory; the geometry's dispose() does so too. */
  free(): Promise<void>;
  /** Bytes of WebAssembly memory that the plan holds in the worker. */
  readonly bytes: number;
}

/** planFor in a worker (loadWorker of norma-mesh): the page's own thread only copies positions and normals. They pass through a SharedArrayBuffer where the page is cross-origin isolated, as messages elsewhere. */
export declare function planForWorker(worker: NormaWorker, geometry: BufferGeometry, options?: PlanForOptions): Promise<WorkerGeometryPlan>;
