/* The first seconds: a scale that breathes between 1 and 2 until somebody does something. */
import { byId, setRange } from "./controls.js";

const PERIOD = 6;

/* changed() is called when the scale has changed. */
export function makeIntro(changed) {
  let playing = false, time = 0, last = 0;
  const show = () => setRange("scale-x", Number((1.5 + 0.5 * Math.cos((2 * Math.PI * time) / PERIOD)).toFixed(2)));
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
    play(on);
  };
  const end = () => {
    playing = false;
    byId("intro").hidden = true;
  };
  byId("breathe").addEventListener("click", () => play(!playing));
  return { begin, end, pause: () => { if (playing) play(false); }, tick, isPlaying: () => playing, isShown: () => !byId("intro").hidden };
}
