/* Galacean: its glTF loader and PBRMaterial. It does not divide diffuse light by pi, so its lights are dimmed. */
import { AssetType, Camera, Color, DirectLight, WebGLEngine } from "@galacean/engine";
import { version } from "@galacean/engine/package.json";

export default async ({ canvas, url, far }) => {
  const engine = await WebGLEngine.create({ canvas, graphicDeviceOptions: { preserveDrawingBuffer: true } });
  const scene = engine.sceneManager.activeScene, root = scene.createRootEntity("root");
  scene.background.solidColor = new Color(0.2, 0.2, 0.2, 1);
  const gltf = await engine.resourceManager.load({ type: AssetType.GLTF, url });
  const model = gltf.instantiateSceneRoot ? gltf.instantiateSceneRoot() : gltf.defaultSceneRoot;
  root.addChild(model);
  for (const camera of model.getComponentsIncludeChildren(Camera, [])) camera.enabled = false;
  for (const { color } of model.getComponentsIncludeChildren(DirectLight, [])) color.scale(1 / Math.PI);
  const entity = root.createChild("camera"), camera = entity.addComponent(Camera);
  entity.transform.setPosition(0, 0, 10);
  camera.isOrthographic = true;
  camera.orthographicSize = 6;
  camera.nearClipPlane = 0.1;
  camera.farClipPlane = 20;
  engine.run();
  await new Promise((done) => setTimeout(done, 3000));
  return `Galacean ${version}`;
};
