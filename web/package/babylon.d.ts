/** Normals and tangents of Babylon.js's VertexData. After `await load()` every call is synchronous. Angles are degrees. */
import type { Report, TangentReport } from "./index.js";
import type { CreasedOptions as SharedCreasedOptions, NormalOptions as SharedNormalOptions, TangentOptions as SharedTangentOptions } from "./vertices.js";

export { load } from "./index.js";

/** The parts of a VertexData that are read and written; `new VertexData()`, and what `VertexData.ExtractFromMesh` gives, are such. */
export interface VertexArrays {
  positions: ArrayLike<number> | null;
  indices?: ArrayLike<number> | null | undefined;
  normals?: ArrayLike<number> | null | undefined;
  tangents?: ArrayLike<number> | null | undefined;
  uvs?: ArrayLike<number> | null | undefined;
}

interface Handed {
  /** As useRightHandedSystem of VertexData.ComputeNormals. Default: false, the sense of faces in a left-handed scene. */
  rightHanded?: boolean | undefined;
}

export interface NormalOptions extends SharedNormalOptions, Handed {}
export interface CreasedOptions extends SharedCreasedOptions, Handed {}
export interface TangentOptions extends SharedTangentOptions, Handed {
  /** Negate w: for texture coordinates whose v runs down, as in glTF. Default: false. */
  negateSign?: boolean | undefined;
  /** 0 stands for uvs, 1 for uvs2 and so on. Default: 0. */
  texcoord?: 0 | 1 | 2 | 3 | 4 | 5 | undefined;
}

type WithNormals<Data extends VertexArrays> = Data & { positions: NonNullable<Data["positions"]>; normals: Float32Array };
type WithTangents<Data extends VertexArrays> = WithNormals<Data> & { tangents: Float32Array };

/** Writes one normal per vertex, in place. */
export declare function computeNormals<Data extends VertexArrays>(vertexData: Data, options: NormalOptions & { report: true }): { vertexData: WithNormals<Data>; report: Report };
export declare function computeNormals<Data extends VertexArrays>(vertexData: Data, options?: NormalOptions & { report?: false | undefined }): WithNormals<Data>;

/** A new VertexData with creases: vertices are doubled only where one is, and take all arrays along; faces keep their order, sub-meshes their faces. */
export declare function toCreased<Data extends VertexArrays>(vertexData: Data, options: CreasedOptions & { report: true }): { vertexData: WithNormals<Data>; report: Report };
export declare function toCreased<Data extends VertexArrays>(vertexData: Data, options?: CreasedOptions & { report?: false | undefined }): WithNormals<Data>;

/** Writes tangents, in place. Vertices are added only where the tangents of their corners differ. */
export declare function computeTangents<Data extends VertexArrays>(vertexData: Data, options: TangentOptions & { report: true }): { vertexData: WithTangents<Data>; report: TangentReport };
export declare function computeTangents<Data extends VertexArrays>(vertexData: Data, options?: TangentOptions & { report?: false | undefined }): WithTangents<Data>;
