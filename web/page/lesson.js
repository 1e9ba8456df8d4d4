/* For teachers: the formula with the numbers of this matrix, the spaces that a point and its normal go through, and steps from a translation to a shear. */
import { byId, numberOf } from "./controls.js";
import { apply3, cross, degreesBetween, multiply, point, unit, upper } from "./matrix.js";
import { degrees, number } from "./readouts.js";
import { fitOf } from "./scene.js";
import { REACH, camera } from "./state.js";

export const STEPS = [
  { title: "Translation", matrix: { move: 0.5 }, words: "A translation moves points. Directions do not move: the upper 3×3 of M is the identity, and normals stay as they are." },
  { title: "Rotation", matrix: { turn: 40 }, words: "A rotation turns normals with the surface. Its inverse transpose is the rotation itself: M serves for normals." },
  { title: "Uniform scale", matrix: { "scale-x": 1.5, "scale-y": 1.5, "scale-z": 1.5 }, words: "The same scale along every axis changes lengths only: M serves, and normals are made unit length again." },
  { title: "Non-uniform scale", matrix: { "scale-x": 2 }, words: "Stretched along x, a slope becomes flatter, so its normal must turn away from x. M turns it towards x instead." },
  { title: "Mirror", matrix: { mirror: "x" }, words: "A mirror turns the winding of every face. Normals go through M, and faces are read the other way round." },
  { title: "Shear", matrix: { shear: 1 }, words: "A shear slides layers over each other. No scale per axis repairs the normals here; the cofactors do." },
];

const inSum = (x) => (x < 0 ? `(${number(x)})` : number(x));
const vector = (v) => `(${v.map(number).join(", ")})`;
const SUBSCRIPTS = ["₁", "₂", "₃"];

/* Of a 3x3, column-major: row i, column j. */
const entry = (m, i, j) => m[3 * j + i];

/* The cofactor at row i, column j with its numbers. */
function cofactorLine(m, i, j) {
  const [r, s] = [(i + 1) % 3, (i + 2) % 3], [c, d] = [(j + 1) % 3, (j + 2) % 3], [a, b, e, f] = [entry(m, r, c), entry(m, s, d), entry(m, r, d), entry(m, s, c)];
  return `C${SUBSCRIPTS[i]}${SUBSCRIPTS[j]} = ${inSum(a)}·${inSum(b)} − ${inSum(e)}·${inSum(f)} = ${number(a * b - e * f)}`;
}

/* Of a normal map: some way along the tangent. */
const MAPPED = [0.6, 0, 0.8];

/* Each space: its name, where the point is, how a normal comes there, and what mistakes make of it. found: the point and the normal of the file; right: the normal matrix of user. */
function spacesOf({ object: p, normal: n }, user, right) {
  const m = upper(user), toView = multiply(camera.worldToView(), fitOf(user)), toClip = camera.viewToClip(REACH + Math.abs(numberOf("move")));
  const world = point(user, p), seen = point(toView, world), clip = [...point(toClip, seen), -seen[2]], normal = unit(apply3(right, n)), wrong = unit(apply3(m, n)), view = unit(apply3(upper(toView), normal));
  const tangent = unit(apply3(m, unit(cross(Math.abs(n[1]) < 0.9 ? [0, 1, 0] : [0, 0, 1], n)))), mapped = (last) => unit(tangent.map((x, i) => MAPPED[0] * x + MAPPED[2] * last[i]));
  return [
    ["Object", `p = ${vector(p)}`, ["n", n], []],
    ["World", `M p = ${vector(world)}`, ["C n", normal], [["M n", wrong], ["n as it was", unit(n)]]],
    ["View", `V M p = ${vector(seen)}`, ["V C n", view], [["C n as it was", normal]]],
    ["Clip", `P V M p = ${vector(clip)}, no normals`, ["", view], [["P V C n", unit(apply3(upper(toClip), view))]]],
    ["Tangent", `${vector(MAPPED)} of a normal map`, ["T by M, N by C", mapped(normal)], [["T, N by M", mapped(wrong)]]],
  ];
}

function addRow(name, cells) {
  const row = Object.assign(byId("spaces").tBodies[0].insertRow(), { className: name });
  for (const text of cells) row.insertCell().textContent = text;
}

/* right: the normal matrix of user; found: what is at the cursor, or null. */
export function showFormula(user, right, found) {
  const plain = upper(user), body = byId("spaces").tBodies[0];
  byId("cofactors").textContent = [0, 1, 2].flatMap((i) => [0, 1, 2].map((j) => cofactorLine(plain, i, j))).join("\n");
  byId("at-cursor").hidden = Boolean(found);
  body.replaceChildren();
  for (const [name, where, [how, normal], mistakes] of found ? spacesOf(found, user, right) : []) {
    const head = Object.assign(document.createElement("th"), { colSpan: 3, scope: "rowgroup", textContent: name });
    head.append(Object.assign(document.createElement("span"), { textContent: ` ${where}` }));
    body.insertRow().append(head);
    if (how) addRow("right", [how, vector(normal), ""]);
    for (const [words, wrong] of mistakes) addRow("wrong", [words, vector(wrong), `${degrees(degreesBetween(normal, wrong))} off`]);
  }
}
