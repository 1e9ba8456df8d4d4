/* The controls: native elements, by their ids, and the matrix that they make. */
import { IDENTITY, multiply, scaling, translation } from "./matrix.js";

export const byId = (id) => document.getElementById(id);
export const value = (id) => byId(id).value;
export const numberOf = (id) => Number(byId(id).value);
export const isChecked = (id) => byId(id).checked;

const SPELLED = { crease: (x) => `${x}°`, turn: (x) => `${x}°`, split: (x) => `${x} %`, "line-density": (x) => `${x} %` };
export const RANGES = ["scale-x", "scale-y", "scale-z", "shear", "turn", "move", "split", "crease", "height", "line-length", "line-density"];
export const MATRIX = { "scale-x": 1, "scale-y": 1, "scale-z": 1, shear: 0, turn: 0, move: 0, mirror: "" };

export function spell(id) { byId(`${id}-value`).textContent = SPELLED[id] ? SPELLED[id](numberOf(id)) : numberOf(id).toFixed(2); }

export function setRange(id, to) {
  byId(id).value = to;
  spell(id);
}

/* The identity, but for what is given. */
export function setMatrix(given = {}) {
  for (const [id, to] of Object.entries({ ...MATRIX, ...given })) if (RANGES.includes(id)) setRange(id, to); else byId(id).value = to;
}

function turning(degrees) {
  const angle = (degrees * Math.PI) / 180, c = Math.cos(angle), s = Math.sin(angle), m = [...IDENTITY];
  if (degrees) [m[0], m[2], m[8], m[10]] = [c, -s, s, c];
  return m;
}

/* M: mirror, then shear, then scales, then a turn about y, then a move along x. */
export function modelMatrix() {
  const mirror = value("mirror"), sign = (axis) => (mirror === axis ? -1 : 1);
  const shear = [...IDENTITY];
  shear[4] = numberOf("shear");
  const stretched = multiply(scaling(numberOf("scale-x"), numberOf("scale-y"), numberOf("scale-z")), multiply(shear, scaling(sign("x"), sign("y"), sign("z"))));
  return numberOf("turn") || numberOf("move") ? multiply(translation(numberOf("move"), 0, 0), multiply(turning(numberOf("turn")), stretched)) : stretched;
}
