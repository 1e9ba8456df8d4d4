/* For teachers: the formula with the numbers of this matrix, and steps from a translation to a shear. */
import { byId } from "./controls.js";
import { apply3, degreesBetween, unit } from "./matrix.js";

export const STEPS = [
  { title: "Translation", matrix: { move: 0.5 }, words: "A translation moves points. Directions do not move: the upper 3×3 of M is the identity, and normals stay as they are." },
  { title: "Rotation", matrix: { turn: 40 }, words: "A rotation turns normals with the surface. Its inverse transpose is the rotation itself: M serves for normals." },
  { title: "Uniform scale", matrix: { "scale-x": 1.5, "scale-y": 1.5, "scale-z": 1.5 }, words: "The same scale along every axis changes lengths only: M serves, and normals are made unit length again." },
  { title: "Non-uniform scale", matrix: { "scale-x": 2 }, words: "Stretched along x, a slope becomes flatter, so its normal must turn away from x. M turns it towards x instead." },
  { title: "Mirror", matrix: { mirror: "x" }, words: "A mirror turns the winding of every face. Normals go through M, and faces are read the other way round." },
  { title: "Shear", matrix: { shear: 1 }, words: "A shear slides layers over each other. No scale per axis repairs the normals here; the cofactors do." },
];

const short = (x) => {
  const text = (Math.abs(x) >= 1000 || (x !== 0 && Math.abs(x) < 0.0005) ? x.toExponential(1) : x.toFixed(3).replace(/\.?0+$/, "")).replace("-", "−");
  return text === "−0" ? "0" : text || "0";
};
const inSum = (x) => (x < 0 ? `(${short(x)})` : short(x));
const vector = (v) => `(${v.map(short).join(", ")})`;
const SUBSCRIPTS = ["₁", "₂", "₃"];

/* Of a 3x3, column-major: row i, column j. */
const entry = (m, i, j) => m[3 * j + i];

/* The cofactor at row i, column j with its numbers. */
function cofactorLine(m, i, j) {
  const [r, s] = [(i + 1) % 3, (i + 2) % 3], [c, d] = [(j + 1) % 3, (j + 2) % 3], [a, b, e, f] = [entry(m, r, c), entry(m, s, d), entry(m, r, d), entry(m, s, c)];
  return `C${SUBSCRIPTS[i]}${SUBSCRIPTS[j]} = ${inSum(a)}·${inSum(b)} − ${inSum(e)}·${inSum(f)} = ${short(a * b - e * f)}`;
}

/* plain: M's upper 3x3; right: the normal matrix; normal: the one at the cursor, or null. */
export function showFormula(plain, right, normal) {
  const lines = [0, 1, 2].flatMap((i) => [0, 1, 2].map((j) => cofactorLine(plain, i, j)));
  byId("cofactors").textContent = lines.join("\n");
  if (!normal) { byId("at-cursor").textContent = "Point at the model to see a normal go through both."; return; }
  const wrong = unit(apply3(plain, normal)), good = unit(apply3(right, normal));
  byId("at-cursor").textContent = `n = ${vector(unit(normal))}\nM n = ${vector(apply3(plain, normal))}, unit ${vector(wrong)}\nC n = ${vector(apply3(right, normal))}, unit ${vector(good)}\nbetween them ${degreesBetween(wrong, good).toFixed(2)}°`;
}
