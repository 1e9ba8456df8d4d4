export { NormaError } from "./index.js";

/** Which joints move each vertex, and how much. */
export interface Skin {
  /** Sixteen numbers for each joint, column-major: its world matrix times its inverse bind matrix. */
  matrices: Float32Array;
  /** For each vertex, `influences` numbers of joints. */
  joints: Uint8Array | Uint16Array | Uint32Array;
  /** For each vertex, `influences` weights, used as they are. */
  weights: Float32Array;
  /** Joints of each vertex, 1 to 64. Default: 4. */
  influences?: number;
  /** `"linear"` is the blend of glTF. Default: `"linear"`. */
  blend?: "linear" | "dual-quaternion";
}

export interface SkinOptions {
  /** Written and returned instead of a new array. */
  out?: Float32Array;
}

export interface Skins {
  /** Three numbers for each vertex, moved by the blend of its joints. */
  positions(skin: Skin, positions: Float32Array, options?: SkinOptions): Float32Array;
  /** Unit normals, through the normal matrix of the blend. Zeros stay zeros. */
  normals(skin: Skin, normals: Float32Array, options?: SkinOptions): Float32Array;
  /** Four numbers for each vertex: tangents through the blend, perpendicular to the skinned normals; the sign is negated if the blend mirrors. */
  tangents(skin: Skin, tangents: Float32Array, skinnedNormals: Float32Array, options?: SkinOptions): Float32Array;
}

/** Loads the module for skins; it holds its WebAssembly as text, so nothing else is fetched. */
export function loadSkin(): Promise<Skins>;
