/** Creases for react-three-fiber, and for whoever else uses three.js within React. */
import type { BufferGeometry } from "three";
import type { CreasedOptions } from "./vertices.js";

/**
 * A new geometry with creases, as toCreased of norma-mesh/three gives it. It is computed again only where the geometry or an option is another one; what is changed within a geometry is not seen.
 * It is disposed of when the component goes. The component suspends until the module is loaded: a `<Suspense>` has to be above it.
 */
export declare function useCreasedGeometry(geometry: BufferGeometry, options?: Omit<CreasedOptions, "report">): BufferGeometry;
