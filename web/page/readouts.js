/* Numbers and words beside the picture. */

const byId = (id) => document.getElementById(id);
export const degrees = (angle) => `${angle.toFixed(2)}°`;
export const count = (number) => number.toLocaleString("en-US");

const number = (x) => {
  const size = Math.abs(x);
  if (size !== 0 && (size < 0.0005 || size >= 1000)) return x.toExponential(1).replace("-", "−");
  return x.toFixed(3).replace(/\.?0+$/, "").replace("-", "−") || "0";
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

const KINDS = { "uniform-scale": "uniform scale", "non-uniform-scale": "non-uniform scale" };
const SHORTCUTS = { none: "", rotation: "M itself serves for normals.", "uniform-scale": "M itself serves, renormalised.", "axis-scale": "M(n/s²) serves as well." };

export function showMatrixFacts(info, worstHere) {
  const words = [`<i>M</i> is ${info.kind === "identity" ? "the identity" : `a ${KINDS[info.kind] ?? info.kind}`}${info.mirrored ? ", mirrored" : ""}`,
                 `determinant ${number(info.determinant)}`, info.rank === 3 ? `anisotropy ${number(info.anisotropy)}` : `rank ${info.rank}`];
  byId("matrix-facts").innerHTML = `${words.join(", ")}. On this model up to <b>${degrees(worstHere)}</b>. ${SHORTCUTS[info.shortcut]}`;
}

export function showModelFacts(model) {
  const stored = [...new Set(model.meshes.map((mesh) => mesh.stored))];
  const normals = stored.length === 1 ? (stored[0] ? `normals ${stored[0]}` : "no normals") : stored.length ? "normals in some parts" : "";
  const parts = model.meshes.length > 1 ? `, ${count(model.meshes.length)} parts` : "", drawn = model.draws.length > model.meshes.length ? `, drawn ${count(model.draws.length)} times` : "";
  const unread = model.unread ? ` ${count(model.unread)} ${model.unread === 1 ? "part was" : "parts were"} not read.` : "";
  byId("model-facts").textContent = `${count(model.triangles)} triangles${parts}${drawn}${model.format ? `, ${model.format}, ${normals}` : ""}.${unread}`;
}

export function showComputeFacts(milliseconds, triangles, wanted) {
  const rate = milliseconds > 0 ? `, ${count(Math.round(1000 / milliseconds))} a second` : "";
  byId("compute-facts").textContent = wanted === "stored" ? "As the file has them." : `${count(triangles)} triangles in ${milliseconds.toFixed(milliseconds < 10 ? 2 : 1)} ms${rate}.`;
}

export function showMovingFacts(milliseconds, points, frames) {
  byId("moving-facts").textContent = `${count(points)} normals in ${milliseconds.toFixed(2)} ms${frames ? `; ${Math.round(frames)} pictures a second` : ""}.`;
}

export function notice(text) { byId("notice").textContent = text; }
