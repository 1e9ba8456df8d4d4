/* The decoder of npm's meshoptimizer; web/build.mjs puts it in. */
export { MeshoptDecoder } from "meshoptimizer/meshopt_decoder.module.js";
