/* Babylon.js: its glTF 2.0 loader and PBRMaterial, right-handed, no image processing. */
import { Camera, Engine, LoadAssetContainerAsync, Scene } from "@babylonjs/core";
import "@babylonjs/loaders/glTF/2.0/index.js";

export default async ({ canvas, url }) => {
  const engine = new Engine(canvas, true, { preserveDrawingBuffer: true });
  const scene = new Scene(engine);
  scene.useRightHandedSystem = true;
  const container = await LoadAssetContainerAsync(url, scene);
  container.addAllToScene();
  const camera = container.cameras.find(({ mode }) => mode === Camera.ORTHOGRAPHIC_CAMERA);
  scene.activeCamera = camera;
  await scene.whenReadyAsync();
  engine.runRenderLoop(() => scene.render());
  await new Promise((done) => setTimeout(done, 2000));
  return `Babylon.js ${Engine.Version}`;
};
