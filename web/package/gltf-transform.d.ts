/** Normals, tangents and checks as transforms of a glTF-Transform Document. Angles are degrees. */
import type { Transform } from "@gltf-transform/core";
import type { CheckReport, Weight } from "./index.js";

export interface NormalsOptions {
  /** Degrees, 0 to 180: an edge that bends by at most this is smooth. Default: 60. */
  crease?: number | undefined;
  /** Default: `"angle"`. */
  weight?: Weight | undefined;
  /** Which vertices share a normal. Default: `"exact"`, those at equal positions. */
  weld?: "exact" | "none" | number | undefined;
  /** Edges of three or more faces: a crease (the default), or smooth if the angle allows it. */
  nonManifold?: "hard" | "smooth" | undefined;
  /** What a vertex without a normal of its own gets. Default: `"nearest"`. */
  fallback?: "zero" | "nearest" | undefined;
  /** Also replace normals that are there. Default: false, as in glTF-Transform. */
  overwrite?: boolean | undefined;
}

export interface TangentsOptions {
  /** `mikk` (the default): the bits of MikkTSpace. `steady`: the same for any order of faces. */
  mode?: "mikk" | "steady" | undefined;
  /** For `steady`. Default: `"angle"`. */
  weight?: Weight | undefined;
  /** The set of texture coordinates. Default: that of the normal map, 0 without one. */
  texcoord?: number | undefined;
  /** Also replace tangents that are there, those of morph targets too. Default: false, as in glTF-Transform. */
  overwrite?: boolean | undefined;
  /** Also primitives whose material has no normal map. Default: false. */
  all?: boolean | undefined;
  /** Also give morph targets with normals the differences of their tangents. Default: false: viewers do without, and a file with many targets grows several times. */
  morphTargets?: boolean | undefined;
}

export interface CheckTransformOptions {
  /** The file's name in the report. Default: `"document.glb"`. */
  name?: string | undefined;
  profile?: "auto" | "render" | "print" | undefined;
  /** Called with the whole report. */
  onReport?: ((report: CheckReport) => void | Promise<void>) | undefined;
}

/** Computes the normals that are missing, with creases; `overwrite: true` computes all. Vertices are added only where a crease needs them; morph targets with normals follow. */
export declare function normals(options?: NormalsOptions): Transform;

/** Computes the tangents that are missing, for primitives with normals, texture coordinates and a normal map (of the material, its clear coat or its anisotropy). */
export declare function tangents(options?: TangentsOptions): Transform;

/** Looks for what is wrong with normals and surfaces. The document stays as it is; errors and warnings go to its logger. */
export declare function check(options?: CheckTransformOptions): Transform;

/** A configuration for the command line of glTF-Transform: it adds the command `normals <input> <output> --crease <degrees> --overwrite`. */
export declare const config: { onProgramReady(commandLine: { program: any; io: any; Session: any }): void };
