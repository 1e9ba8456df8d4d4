/* Filament (npm): gltfio's AssetLoader and its materials, one of the scene's lights, no environment, its own tone mapping. */
import { version } from "filament/package.json";

export default async ({ canvas, url, width, height }) => {
  /* A script of the old kind: it replaces its own global variable. */
  await new Promise((done) => document.body.append(Object.assign(document.createElement("script"), { src: "/modules/filament/filament.js", onload: done })));
  await new Promise((done) => window.Filament.init([url], done));
  const { Filament } = window;
  const engine = Filament.Engine.create(canvas), scene = engine.createScene(), loader = engine.createAssetLoader();
  const asset = loader.createAsset(url);
  await new Promise((done) => asset.loadResources(done, undefined, "/", undefined, { normalizeSkinningWeights: true }));
  asset.getInstance().getAnimator().updateBoneMatrices();
  scene.addEntities(asset.getEntities());
  scene.addEntities(asset.getLightEntities());
  const camera = engine.createCamera(Filament.EntityManager.get().create());
  camera.setProjection(Filament.Camera$Projection.ORTHO, -8, 8, -6, 6, 0.1, 20);
  camera.lookAt([0, 0, 10], [0, 0, 0], [0, 1, 0]);
  camera.setExposureDirect(1);
  const view = engine.createView(), renderer = engine.createRenderer(), chain = engine.createSwapChain();
  view.setCamera(camera);
  view.setScene(scene);
  view.setViewport([0, 0, width, height]);
  view.setPostProcessingEnabled(true);
  renderer.setClearOptions({ clearColor: [0.2, 0.2, 0.2, 1], clear: true });
  for (let i = 0; i < 40; ++i) {
    if (renderer.beginFrame(chain)) { renderer.renderView(view); renderer.endFrame(); }
    engine.execute();
    await new Promise(requestAnimationFrame);
  }
  return `Filament ${version}`;
};
