/* What is shown, in the address behind the #: the controls that differ from how they stand at first, and the camera. So that a link shows the same again. */
import { byId, RANGES, spell } from "./controls.js";

const KEPT = ["model", "scale-x", "scale-y", "scale-z", "shear", "turn", "move", "mirror", "sides", "split", "source", "crease", "weight", "weld", "shading", "colours", "hedgehog", "line-length", "line-density", "wireframe", "seams", "textures", "normal-maps", "up"];
const CAMERA = ["azimuth", "elevation", "distance"], poseOf = (camera) => [...CAMERA.map((name) => camera[name]), ...camera.centre].map((x) => Number(x.toFixed(3)));
const PAUSE = 300;

const control = (id) => byId(id);
const stateOf = (element) => (element.type === "checkbox" ? (element.checked ? "1" : "0") : element.value);
const kept = () => KEPT.filter(control);

/* What the address asks for; null: nothing. */
export function readAddress() {
  const asked = new URLSearchParams(location.hash.slice(1));
  return [...asked.keys()].some((key) => KEPT.includes(key) || key === "camera" || key === "finding") ? asked : null;
}

/* Sets every control that it names, if that has such a value. */
export function applyAddress(asked, camera) {
  for (const id of kept()) {
    const element = control(id), to = asked.get(id);
    if (to === null || id === "model") continue;
    if (element.type === "checkbox") element.checked = to === "1";
    else if (element.tagName !== "SELECT" || [...element.options].some((option) => option.value === to)) element.value = to;
    if (RANGES.includes(id)) spell(id);
  }
  const numbers = (asked.get("camera") ?? "").split(",").map(Number);
  if (numbers.length < CAMERA.length || !numbers.every(Number.isFinite) || !(numbers[2] > 0)) return;
  CAMERA.forEach((name, i) => { camera[name] = numbers[i]; });
  camera.centre = numbers.length === CAMERA.length + 3 ? numbers.slice(CAMERA.length) : [0, 0, 0];
}

/* A function to call after every change; it writes when nothing has changed for a while. pressed(): the key of the finding that is shown, or null. */
export function makeAddress(camera, pressed) {
  let timer = null;
  const first = Object.fromEntries(kept().map((id) => [id, stateOf(control(id))]));
  const write = () => {
    const state = new URLSearchParams();
    for (const id of kept()) if (stateOf(control(id)) !== first[id] && !(id === "model" && /^(file|embedded)/.test(control(id).value))) state.set(id, stateOf(control(id)));
    const now = poseOf(camera);
    if (now.join() !== poseOf(camera.home).join()) state.set("camera", (now.slice(CAMERA.length).some((x) => x !== 0) ? now : now.slice(0, CAMERA.length)).join());
    if (pressed()) state.set("finding", pressed());
    const text = state.toString().replaceAll("%2C", ",");
    if (text !== location.hash.slice(1)) history.replaceState(null, "", text ? `#${text}` : location.pathname + location.search);
  };
  return () => {
    clearTimeout(timer);
    timer = setTimeout(write, PAUSE);
  };
}
