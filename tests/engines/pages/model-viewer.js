/* <model-viewer>: its own environment, tone mapping and camera, which is perspective. */
import "@google/model-viewer";
import { REVISION } from "three";
import { version } from "@google/model-viewer/package.json";

export default async ({ canvas, url, width, height, far }) => {
  canvas.remove();
  const viewer = document.createElement("model-viewer");
  Object.assign(viewer.style, { width: `${width}px`, height: `${height}px`, backgroundColor: "#777" });
  viewer.setAttribute("camera-target", "0m 0m 0m");
  viewer.setAttribute("camera-orbit", `0deg 90deg ${far.distance}m`);
  viewer.setAttribute("max-camera-orbit", "auto auto 1000m");
  viewer.setAttribute("min-field-of-view", "1deg");
  viewer.setAttribute("field-of-view", `${far.degrees}deg`);
  viewer.setAttribute("interaction-prompt", "none");
  viewer.setAttribute("shadow-intensity", "0");
  viewer.setAttribute("src", url);
  document.body.append(viewer);
  await new Promise((done, fail) => { viewer.addEventListener("load", done); viewer.addEventListener("error", ({ detail }) => fail(new Error(JSON.stringify(detail)))); });
  viewer.jumpCameraToGoal();
  await new Promise((done) => setTimeout(done, 4000));
  return `model-viewer ${version} on three.js ${REVISION}`;
};
