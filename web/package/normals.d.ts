import type { Norma } from "./index.js";

export { NormaError } from "./index.js";
export type { CreaseOptions, Indices, MatrixOptions, MeshOptions, OutputOptions, Report, SplitMesh, SplitOptions, TangentOptions, Vectors } from "./index.js";

/**
 * Calls of `norma-mesh`, with the same results, bit for bit. Three options are left out, and asking for them throws a NormaError: the weight "visible",
 * a distance as `weld`, and the mode "steady".
 */
export type Normals = Pick<Norma, "version" | "faceNormals" | "vertexNormals" | "cornerNormals" | "split" | "tangents" | "normalMatrix" | "normalMatrices">;

/** Loads the module; it lies in the script, so nothing else is fetched. */
export function load(): Promise<Normals>;
