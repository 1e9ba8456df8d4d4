/* Numbers and words beside the picture. */

const byId = (id) => document.getElementById(id);
export const degrees = (angle) => `${angle.toFixed(2)}°`;
/* As %.4g prints it. */
export const short = (x) => String(Number(x.toPrecision(4)));
export const count = (number) => number.toLocaleString("en-US");

export const number = (x) => {
  const text = (Math.abs(x) >= 1000 || (x !== 0 && Math.abs(x) < 0.0005) ? x.toExponential(1) : x.toFixed(3).replace(/\.?0+$/, "")).replace("-", "−");
  return text === "−0" ? "0" : text;
};

/* A 3x3, column-major, into a table. */
export function showMatrix(id, matrix) {
  const rows = [0, 1, 2].map((row) => {
    const line = document.createElement("tr");
    for (let column = 0; column < 3; column++) line.insertCell().textContent = number(matrix[3 * column + row]);
    return line;
  });
  byId(id).tBodies[0].replaceChildren(...rows);
}

const KINDS = { identity: "the identity", translation: "a translation", rotation: "a rotation", "uniform-scale": "a uniform scale", "non-uniform-scale": "a non-uniform scale", shear: "a shear", singular: "singular, it flattens the model" };
const SHORTCUTS = { none: "", rotation: "M itself serves for normals.", "uniform-scale": "M itself serves, if normals are made unit length again.", "axis-scale": "M(n/s²) serves as well." };

/* worstHere: the largest angle on this model; null while it is measured. */
export function showMatrixFacts(info, worstHere) {
  const words = [`<i>M</i> is ${KINDS[info.kind]}${info.mirrored ? ", mirrored" : ""}`, `determinant ${number(info.determinant)}`, info.rank === 3 ? `anisotropy ${number(info.anisotropy)}` : `rank ${info.rank}`];
  const here = worstHere === null ? "" : `The normals of this model err by up to <b>${degrees(worstHere)}</b>${worstHere < info.worstErrorDeg - 0.005 ? ", as none of them points where M errs most" : ""}. `;
  byId("matrix-facts").innerHTML = `${words.join(", ")}. ${here}${SHORTCUTS[info.shortcut]}`;
}

export const counted = (amount, one, many = `${one}s`) => `${count(amount)} ${amount === 1 ? one : many}`;

export function showModelFacts(model) {
  const stored = [...new Set(model.meshes.map((mesh) => mesh.stored))];
  const normals = stored.length === 1 ? (stored[0] ? `normals ${stored[0]}` : "no normals") : stored.length ? "normals in some parts" : "";
  const parts = model.meshes.length > 1 ? `, ${count(model.meshes.length)} parts` : "", drawn = model.draws.length > model.meshes.length ? `, drawn ${count(model.draws.length)} times` : "";
  const unread = model.unread ? ` ${counted(model.unread, "part was", "parts were")} not read.` : "";
  byId("model-facts").textContent = `${counted(model.triangles, "triangle")}${parts}${drawn}${model.format ? `, ${model.format}, ${normals}` : ""}.${unread}${model.meshes.some(({ decimated }) => decimated) ? " Decimated for display: the file has more triangles, and what is found is that of the file." : ""}`;
}

/* milliseconds: of each run while everything was warm. */
export function showComputeFacts(milliseconds, { triangles, meshes }, wanted) {
  const middle = [...milliseconds].sort((a, b) => a - b)[Math.floor(milliseconds.length / 2)];
  byId("compute-facts").textContent = wanted === "stored" ? (meshes.some(({ stored }) => stored) ? "As the file has them." : "The file has none: glTF draws such meshes flat.")
    : milliseconds.length ? `${counted(triangles, "triangle")} in ${middle.toFixed(middle < 10 ? 2 : 1)} ms (the median of ${counted(milliseconds.length, "run")}).` : `${counted(triangles, "triangle")}.`;
}

export function showMovingFacts(milliseconds, points, frames) {
  byId("moving-facts").textContent = `${count(points)} normals in ${milliseconds.toFixed(2)} ms${frames ? `; ${counted(Math.round(frames), "picture")} a second` : ""}.`;
}

export function notice(text) { byId("notice").textContent = text; }
