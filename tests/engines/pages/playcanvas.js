/* PlayCanvas: its container handler and StandardMaterial. It does not divide diffuse light by pi, so the exposure does. */
import * as pc from "playcanvas";

export default async ({ canvas, url, width, height }) => {
  const app = new pc.Application(canvas, { graphicsDeviceOptions: { antialias: true, preserveDrawingBuffer: true } });
  app.setCanvasFillMode(pc.FILLMODE_NONE, width, height);
  app.setCanvasResolution(pc.RESOLUTION_FIXED, width, height);
  const asset = await new Promise((done, fail) => app.assets.loadFromUrl(url, "container", (error, found) => error ? fail(error) : done(found)));
  app.scene.ambientLight = new pc.Color(0, 0, 0);
  const scene = asset.resource.instantiateRenderEntity();
  app.root.addChild(scene);
  for (const light of scene.findComponents("light")) light.enabled = true, light.intensity /= Math.PI;
  scene.findComponents("camera").find(({ projection }) => projection === pc.PROJECTION_ORTHOGRAPHIC).enabled = true;
  app.start();
  await new Promise((done) => setTimeout(done, 3000));
  return `PlayCanvas ${pc.version}`;
};
