/* What the page shows now and what is under way, for all of its modules; and the stage it is shown on. */
import { byId, modelMatrix } from "./controls.js";
import { makeCamera } from "./camera.js";
import { IDENTITY } from "./matrix.js";

/* How a finding that is pressed is marked: nothing is. */
export const UNMARKED = { through: false, dim: false, pins: null, place: null, outline: null, unpainted: false };
export const DEFAULT_CURSOR = { x: 0.5, y: 0.47, itself: true };

export const page = {
  /* Norma's calls here and in the worker, the renderer, and what moves by itself. */
  norma: null, remote: null, graphics: null, thumbs: null, intro: null, animation: null,
  /* What is shown: a scene, and the one before it was changed; or the surface that moves; and where its file came from. */
  scene: null, before: null, moving: null, source: null,
  /* Models that the page brings; what the address asks of the one that is opened first. */
  sculpture: null, embedded: null, atFirst: null,
  chosen: null, look: { ...UNMARKED, errorTop: 1, angleTop: 45 }, cursor: DEFAULT_CURSOR, panels: [], found: null,
  /* What is under way: how many calls or which one of them. */
  calls: 0, drawing: false, aiming: false, awaiting: false, coarse: false, rested: false, warm: false, computing: false, picking: false, measuring: false, loading: 0, seeking: 0, computed: 0, opening: 0, flights: 0,
  /* Milliseconds that the last picture took which was not coarse, when something last moved, and whether no picture shows that yet. */
  cost: Infinity, hurried: -Infinity, hasty: false,
  /* Writes the address. */
  remember: () => undefined,
};
export const dirty = { compute: true, draw: true };
/* Whether a picture takes so long that a coarse one, with a quarter of its pixels, is shown before it, and nothing flies. */
const SLOW = 90;
export const isSlow = () => page.cost > SLOW;
/* Draws anew, coarsely where a card is slow: somebody waits, or something moves. */
export const hurry = () => { page.hurried = performance.now(); page.hasty = dirty.draw = true; };

export const canvas = byId("canvas"), stage = byId("stage"), camera = makeCamera();
/* How far from the middle a model reaches. */
export const REACH = 2.2;
export const PIN_COLOURS = { error: [0.37, 0.002, 0.002, 1], warning: [0.55, 0.085, 0.001, 1], info: [0.002, 0.037, 0.27, 1] };
export const isDark = () => matchMedia("(prefers-color-scheme: dark)").matches;
export const isCalm = () => matchMedia("(prefers-reduced-motion: reduce)").matches;
export const userMatrix = () => (page.moving ? IDENTITY : modelMatrix());
