/* The first seconds: a model is slowly pressed flat and let go, and a line sweeps over it, until somebody does something. */
import { byId, modelMatrix, setRange } from "./controls.js";
import { multiply, point } from "./matrix.js";
import { fitOf } from "./scene.js";
import { REACH, camera, canvas, page } from "./state.js";

/* Seconds. Never so little that both sides look alike; the line stays where the model shows most, by parts of its width. */
const PRESS = 11, SWEEP = 7, TALL = 0.58, FLAT = 0.38, FROM = 0.35, TO = 0.8;
/* One point in so many is looked at; the words above and below the model want room. */
const STEP = 3 * 16, ROOM = 1.28;
const wave = (time, period) => 0.5 - 0.5 * Math.cos((2 * Math.PI * time) / period);

/* Some of the model's points, where they are drawn. */
function pointsNow() {
  const user = modelMatrix(), drawn = multiply(multiply(multiply(fitOf(user), user), page.scene.frame), page.scene.draws[0].world), { positions } = page.sculpture;
  return Array.from({ length: Math.ceil(positions.length / STEP) }, (_, i) => point(drawn, positions.subarray(STEP * i, STEP * i + 3)));
}

/* The model's left and right in the picture, from 0 to 100. */
function sidesOfModel() {
  const toClip = multiply(camera.viewToClip(REACH), camera.worldToView());
  const across = pointsNow().map((p) => (50 * point(toClip, p)[0]) / (toClip[3] * p[0] + toClip[7] * p[1] + toClip[11] * p[2] + toClip[15]) + 50);
  return [Math.min(...across), Math.max(...across)];
}

/* changed() is called when the scale has changed. */
export function makeIntro(changed) {
  let playing = false, time = 0, last = 0;
  const show = () => {
    setRange("scale-y", Number((FLAT + (TALL - FLAT) * wave(time + PRESS / 8, PRESS)).toFixed(3)));
    if (!page.scene) return;
    const [left, right] = sidesOfModel();
    setRange("split", Number((left + (right - left) * (TO - (TO - FROM) * wave(time + SWEEP / 12, SWEEP))).toFixed(1)));
  };
  const play = (on) => {
    playing = on;
    last = 0;
    byId("breathe").textContent = on ? "Pause" : "Play";
    byId("breathe").setAttribute("aria-pressed", String(!on));
  };
  const tick = (now) => {
    if (!playing) return;
    time += last ? Math.min(0.1, (now - last) / 1000) : 0;
    last = now;
    show();
    changed();
  };
  /* The model fills the picture at its tallest. */
  const frame = () => {
    setRange("scale-y", TALL);
    camera.aspect = canvas.clientWidth / Math.max(1, canvas.clientHeight);
    camera.reset(camera.framing(pointsNow(), camera.home, 0));
    camera.zoom(ROOM);
    show();
  };
  const begin = (on) => {
    time = 0;
    show();
    byId("intro").hidden = false;
    document.body.classList.add("first");
    play(on);
  };
  const end = () => {
    playing = false;
    byId("intro").hidden = true;
    document.body.classList.remove("first");
  };
  byId("breathe").addEventListener("click", () => play(!playing));
  return { begin, end, frame, pause: () => { if (playing) play(false); }, tick, isPlaying: () => playing, isShown: () => !byId("intro").hidden };
}
