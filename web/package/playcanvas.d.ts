/** Normals and tangents of PlayCanvas's Mesh. After `await load()` every call is synchronous. Angles are degrees. */
import type { Mesh } from "playcanvas";
import type { Report, TangentReport } from "./index.js";
import type { CreasedOptions, NormalOptions, TangentOptions as SharedTangentOptions } from "./vertices.js";

export { load } from "./index.js";
export type { CreasedOptions, NormalOptions };

export interface TangentOptions extends SharedTangentOptions {
  /** Negate w: for texture coordinates whose v runs down, as in glTF. Default: false, as calculateTangents of PlayCanvas. */
  negateSign?: boolean | undefined;
  /** The channel of the normal map. Default: 0. */
  texcoord?: 0 | 1 | 2 | 3 | 4 | 5 | 6 | 7 | undefined;
}

/** Writes one normal per vertex, in place. */
export declare function computeNormals(mesh: Mesh, options: NormalOptions & { report: true }): { mesh: Mesh; report: Report };
export declare function computeNormals(mesh: Mesh, options?: NormalOptions & { report?: false | undefined }): Mesh;

/** A new mesh with creases: vertices are doubled only where one is, and take all streams along. The skin is shared. */
export declare function toCreased(mesh: Mesh, options: CreasedOptions & { report: true }): { mesh: Mesh; report: Report };
export declare function toCreased(mesh: Mesh, options?: CreasedOptions & { report?: false | undefined }): Mesh;

/** Writes tangents, in place. Vertices are added only where the tangents of their corners differ. */
export declare function computeTangents(mesh: Mesh, options: TangentOptions & { report: true }): { mesh: Mesh; report: TangentReport };
export declare function computeTangents(mesh: Mesh, options?: TangentOptions & { report?: false | undefined }): Mesh;
