/* CesiumJS: its Model, without globe, sky or imagery; a perspective frustum from far away.
 * KHR_lights_punctual is not read; Cesium has one light, here from one side. */
window.CESIUM_BASE_URL = "/modules/cesium/Build/Cesium/";

export default async ({ canvas, url, width, height, far }) => {
  const Cesium = await import("cesium");
  const outside = 1e7; /* what lies inside the Earth is not drawn */
  const scene = new Cesium.Scene({ canvas, creditContainer: document.createElement("div"), contextOptions: { webgl: { preserveDrawingBuffer: true } } });
  scene.backgroundColor = Cesium.Color.fromCssColorString("#777");
  scene.rethrowRenderErrors = true;
  scene.highDynamicRange = false;
  scene.postProcessStages.fxaa.enabled = false;
  scene.screenSpaceCameraController.enableInputs = false;
  const model = scene.primitives.add(await Cesium.Model.fromGltfAsync({ url, modelMatrix: Cesium.Matrix4.fromTranslation(new Cesium.Cartesian3(outside, 0, 0)), upAxis: Cesium.Axis.Z, forwardAxis: Cesium.Axis.X, incrementallyLoadTextures: false, cull: false }));
  const { camera } = scene;
  model.imageBasedLighting.imageBasedLightingFactor = Cesium.Cartesian2.ZERO;
  camera.frustum = new Cesium.PerspectiveFrustum({ fov: 2 * Math.atan(Math.tan(far.degrees * Math.PI / 360) * width / height), aspectRatio: width / height, near: far.near, far: far.end });
  const draw = () => {
    camera.position = new Cesium.Cartesian3(outside, 0, far.distance);
    camera.direction = new Cesium.Cartesian3(0, 0, -1);
    camera.up = new Cesium.Cartesian3(0, 1, 0);
    camera.right = new Cesium.Cartesian3(1, 0, 0);
    scene.initializeFrame();
    scene.render();
  };
  scene.light = new Cesium.DirectionalLight({ direction: Cesium.Cartesian3.normalize(new Cesium.Cartesian3(-0.7, -0.4, -0.6), new Cesium.Cartesian3()), intensity: 3 });
  model.readyEvent.addEventListener(() => { model.getNode("flattened subject").show = false; }); /* else rendering stops: the inverse of its matrix is an error */
  while (!model.ready) { draw(); await new Promise(requestAnimationFrame); }
  for (let i = 0; i < 20; ++i) { draw(); await new Promise(requestAnimationFrame); }
  return `CesiumJS ${Cesium.VERSION}`;
};
