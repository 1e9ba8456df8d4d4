/* The decoder of npm's draco3dgltf; web/build.mjs puts it in. Its WebAssembly is draco.wasm. */
export { default } from "draco3dgltf/draco_decoder_gltf_nodejs.js";
