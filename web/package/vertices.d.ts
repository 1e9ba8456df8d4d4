/** What the adapters to engines take alike. Angles are degrees. */
import type { Weight } from "./index.js";

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
  /** Return the counts of corners without a tangent of their own, too. Default: false. */
  report?: boolean | undefined;
}
