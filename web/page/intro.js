/* The first seconds: a model is slowly stretched, and a line sweeps over it, until somebody does something. */
import { byId, setRange } from "./controls.js";

const STRETCH = 11, SWEEP = 7, FROM = 14, TO = 86;
const wave = (time, period) => 0.5 - 0.5 * Math.cos((2 * Math.PI * time) / period);

/* changed() is called when the scale has changed. */
export function makeIntro(changed) {
  let playing = false, time = 0, last = 0;
  const show = () => {
    setRange("scale-x", Number((2.2 - 1.2 * wave(time, STRETCH)).toFixed(2)));
    setRange("split", Number((TO - (TO - FROM) * wave(time + SWEEP / 4, SWEEP)).toFixed(1)));
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
  return { begin, end, pause: () => { if (playing) play(false); }, tick, isPlaying: () => playing, isShown: () => !byId("intro").hidden };
}
