/* The encoder of npm's meshoptimizer; web/build.mjs puts it in. */
export { MeshoptEncoder } from "meshoptimizer/meshopt_encoder.module.js";
