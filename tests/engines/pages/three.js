/* three.js by WebGL: GLTFLoader, the materials that it makes, no tone mapping; grey behind, so that black is not taken for missing. */
import * as three from "three";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";

export default async ({ canvas, url, width, height }) => {
  const gltf = await new GLTFLoader().loadAsync(url);
  const renderer = new three.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
  renderer.setClearColor(0x555566);
  renderer.setSize(width, height, false);
  renderer.render(gltf.scene, gltf.cameras.find(({ name }) => name === "norma-acid"));
  return `three.js ${three.REVISION}`;
};
