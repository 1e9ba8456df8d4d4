/* Khronos glTF Sample Renderer: the scene's own camera and lights, no environment, no tone mapping. */
import { GltfState, GltfView } from "@khronosgroup/gltf-viewer/dist/gltf-viewer.module.js";
import { version } from "@khronosgroup/gltf-viewer/package.json";

/* Decoders of formats that the scene does not have. */
const unused = async () => ({ GL: { makeContextCurrent() {}, createContext() {} } });

export default async ({ canvas, url, width, height }) => {
  const view = new GltfView(canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true, alpha: false }));
  const state = view.createState(), loader = view.createResourceLoader(unused, unused, "/modules/@khronosgroup/gltf-viewer/dist/libs/");
  state.gltf = await loader.loadGltf(url);
  state.sceneIndex = state.gltf.scene ?? 0;
  state.cameraIndex = 0;
  Object.assign(state.renderingParameters, { useIBL: false, usePunctual: true, toneMap: GltfState.ToneMaps.LINEAR, renderEnvironmentMap: false, clearColor: [0.2, 0.2, 0.2, 1] });
  view.renderer.applyEnvironmentMap = (_, slot) => slot; /* it expects an environment even where none is used */
  for (let i = 0; i < 6; ++i) {
    view.renderFrame(state, width, height);
    await new Promise(requestAnimationFrame);
  }
  return `Khronos glTF Sample Renderer ${version}`;
};
