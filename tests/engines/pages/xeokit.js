/* xeokit-sdk: its GLTFLoaderPlugin and scene model, its own lights, perspective from far away. */
import { AmbientLight, DirLight, GLTFLoaderPlugin, Viewer } from "@xeokit/xeokit-sdk/dist/xeokit-sdk.es.js";
import { version } from "@xeokit/xeokit-sdk/package.json";

export default async ({ url, far }) => {
  const viewer = new Viewer({ canvasId: "canvas", transparent: false, backgroundColor: [0.46, 0.46, 0.46], dtxEnabled: false, preserveDrawingBuffer: true });
  const { camera } = viewer.scene;
  camera.perspective.fov = far.degrees;
  camera.perspective.fovAxis = "y";
  camera.perspective.near = far.near;
  camera.perspective.far = far.end;
  camera.eye = [0, 0, far.distance];
  camera.look = [0, 0, 0];
  camera.up = [0, 1, 0];
  viewer.scene.clearLights();
  for (const [color, dir] of [[[1, 0, 0], [-0.5, 0, -0.866]], [[0, 1, 0], [0.25, -0.433, -0.866]], [[0, 0, 1], [0.25, 0.433, -0.866]]]) new DirLight(viewer.scene, { color, dir, intensity: 0.9, space: "world" });
  const model = new GLTFLoaderPlugin(viewer).load({ id: "acid", src: url, edges: false, autoMetaModel: true });
  await new Promise((done, fail) => { model.on("loaded", done); model.on("error", (error) => fail(new Error(error))); });
  await new Promise((done) => setTimeout(done, 3000));
  return `xeokit-sdk ${version}`;
};
