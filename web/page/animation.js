/* Animations of a glTF, with their morph targets and skins: three.js's own scene of the file, posed by its mixer, stands where Norma's surfaces stand while one plays. */
import { AnimationMixer, Group, Matrix4 } from "three";
import { byId, numberOf } from "./controls.js";
import { hasAnimations, loadGltf } from "./materials.js";

const seconds = (time) => `${time.toFixed(2)} s`;

/* changed(): draws anew. prepare(scene): a promise, kept when it can be drawn without delay. */
export function makeAnimation(changed, isCalm, prepare) {
  let loaded = null, mixer = null, clip = null, playing = false, last = 0, asked = 0;
  const slider = byId("time"), choice = byId("animation"), button = byId("play");
  const length = () => Math.max(1e-3, clip?.duration ?? 0);
  const showTime = () => { byId("time-value").textContent = seconds(numberOf("time")); };
  const pose = () => { if (mixer) { mixer.setTime(Math.min(numberOf("time"), length() * (1 - 1e-6))); showTime(); changed(); } };
  const play = (on) => {
    playing = on && clip !== null;
    last = 0;
    button.textContent = playing ? "Pause" : "Play";
    button.setAttribute("aria-pressed", String(playing));
    changed();
  };
  const choose = () => {
    mixer?.stopAllAction();
    clip = loaded.animations[choice.selectedIndex] ?? null;
    slider.max = length();
    slider.value = 0;
    if (clip) mixer.clipAction(clip).play();
    pose();
  };
  const forget = () => {
    asked++;
    play(false);
    loaded?.scene.traverse((part) => { part.geometry?.dispose(); for (const material of [part.material].flat()) material?.dispose?.(); });
    loaded = mixer = clip = null;
    byId("animation-section").hidden = true;
    slider.value = 0;
  };
  /* From the files of a model: shows the controls if it has animations, and plays where movement is wished. */
  const open = async (files, path) => {
    forget();
    if (!hasAnimations(files, path)) return;
    const mine = asked, read = await loadGltf(files, path, false).catch(() => null);
    if (mine !== asked || !read?.gltf.animations.length) return;
    const scene = new Group();
    scene.add(read.gltf.scene ?? read.gltf.scenes[0]);
    scene.matrixAutoUpdate = false;
    scene.traverse((part) => { part.frustumCulled = false; });
    await prepare(scene);
    if (mine !== asked) return;
    loaded = { scene, animations: read.gltf.animations };
    mixer = new AnimationMixer(loaded.scene);
    choice.replaceChildren(...loaded.animations.map(({ name }, i) => new Option(name || `Animation ${i + 1}`)));
    byId("animation-section").hidden = false;
    choose();
    if (!isCalm()) play(true);
  };
  /* Moves on by the time since the last picture. */
  const tick = (now) => {
    if (!playing) return;
    const more = last ? Math.min(0.1, (now - last) / 1000) : 0;
    last = now;
    slider.value = (numberOf("time") + more) % length();
    pose();
  };
  /* Three.js's scene at its time, moved by this matrix; null while everything is at rest. */
  const root = (matrix) => {
    if (!mixer || (!playing && numberOf("time") === 0)) return null;
    loaded.scene.matrix.copy(new Matrix4().fromArray(matrix));
    loaded.scene.updateMatrixWorld(true);
    return loaded.scene;
  };
  choice.addEventListener("change", choose);
  slider.addEventListener("input", () => { play(false); pose(); });
  button.addEventListener("click", () => play(!playing));
  return { open, forget, tick, root, isPlaying: () => playing, stop: () => play(false) };
}
