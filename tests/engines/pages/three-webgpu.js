/* three.js by WebGPURenderer and its node materials; without WebGPU it compiles the same nodes to WebGL 2. */
import * as three from "three/webgpu";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";

export default async ({ canvas, url, width, height }) => {
  const gltf = await new GLTFLoader().loadAsync(url);
  const renderer = new three.WebGPURenderer({ canvas, antialias: true });
  await renderer.init();
  renderer.setSize(width, height, false);
  const draw = () => renderer.render(gltf.scene, gltf.cameras.find(({ name }) => name === "norma-acid"));
  renderer.setAnimationLoop(draw);
  await new Promise((done) => setTimeout(done, 5000));
  return `three.js ${three.REVISION}, WebGPURenderer by ${renderer.backend.isWebGPUBackend ? "WebGPU" : "WebGL 2"}`;
};
