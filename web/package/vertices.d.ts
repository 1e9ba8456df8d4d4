/** What the adapters to engines take alike. Angles are degrees. */
import type { MeshOptions, TangentOptions as ArrayTangentOptions } from "./index.js";

export interface NormalOptions extends MeshOptions {
  /** What a vertex without a normal of its own gets. Default: `"zero"`; toCreased: `"nearest"`. */
  fallback?: "zero" | "nearest" | undefined;
}

export interface CreasedOptions extends NormalOptions {
  /** Degrees, 0 to 180: an edge that bends by at most this is smooth. Default: 60. */
  crease?: number | undefined;
}

export type TangentOptions = Omit<ArrayTangentOptions, "out">;
