/* vtk.js: its GLTFImporter; it does not divide diffuse light by pi, so its lights are dimmed. */
import "@kitware/vtk.js/Rendering/Profiles/Geometry";
import vtkGenericRenderWindow from "@kitware/vtk.js/Rendering/Misc/GenericRenderWindow";
import vtkGLTFImporter from "@kitware/vtk.js/IO/Geometry/GLTFImporter";
import { version } from "@kitware/vtk.js/package.json";

export default async ({ canvas, url, width, height }) => {
  canvas.remove();
  const container = document.createElement("div");
  Object.assign(container.style, { width: `${width}px`, height: `${height}px` });
  document.body.append(container);
  const generic = vtkGenericRenderWindow.newInstance({ background: [0.46, 0.46, 0.46] });
  generic.setContainer(container);
  generic.resize();
  const renderer = generic.getRenderer(), importer = vtkGLTFImporter.newInstance({ renderer });
  await importer.setUrl(url, { binary: true, compression: "" });
  await new Promise((done) => { importer.onReady(done); setTimeout(done, 20000); });
  importer.importActors();
  importer.createAnimationMixer();
  importer.importLights?.();
  for (const light of renderer.getLights()) light.setIntensity(light.getIntensity() / Math.PI);
  const camera = renderer.getActiveCamera();
  camera.setPosition(0, 0, 10);
  camera.setFocalPoint(0, 0, 0);
  camera.setViewUp(0, 1, 0);
  camera.setParallelProjection(true);
  camera.setParallelScale(6);
  camera.setClippingRange(0.1, 20);
  generic.getRenderWindow().render();
  await new Promise((done) => setTimeout(done, 2000));
  generic.getRenderWindow().render();
  return `vtk.js ${version}`;
};
