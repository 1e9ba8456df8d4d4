/* A second file beside the one that is open, as norma compare BASE OTHER compares them: the numbers, and in colour by how much each place of it differs. */
import { byId } from "./controls.js";
import { bytesFor, gather, hintFor } from "./files.js";
import { point, multiply } from "./matrix.js";
import { option, showModel } from "./opening.js";
import { fly, sweep } from "./pressed.js";
import { counted, short } from "./readouts.js";
import { turning } from "./scene.js";
import { dirty, page } from "./state.js";

const HOW = { corners: "each with its counterpart: the faces are the same", mixed: "with their counterparts in meshes of the same faces, others with the nearest points", nearest: "each with the nearest point" };
const KINDS = ["deviation", "distance"];

const cellsOf = (row, tag, texts) => texts.forEach((text) => row.append(Object.assign(document.createElement(tag), { textContent: text })));

function showDifferences({ corners, missing, degrees, distances, computed, how }, names) {
  const table = document.createElement("table"), paragraph = (text) => Object.assign(document.createElement("p"), { className: "quiet", textContent: text });
  const head = table.createTHead().insertRow();
  head.insertCell();
  cellsOf(head, "th", ["half of the area", "99 % of it", "at most"]);
  for (const [name, numbers, unit] of [["degrees", degrees, "°"], ["distances", distances, ""]]) {
    const row = (table.tBodies[0] ?? table.createTBody()).insertRow();
    cellsOf(row, "th", [name]);
    cellsOf(row, "td", numbers.map((x) => `${short(unit ? Math.round(x * 1e4) / 1e4 : x)}${unit}`));
  }
  const without = names.filter((_, i) => computed[i]), notes = [...(missing ? [`${counted(missing, "corner has", "corners have")} no normal.`] : []), ...(without.length ? [`Normals that ${without.join(" and ")} lacked were computed.`] : [])];
  byId("compared-facts").replaceChildren(paragraph(`${names[1]} against ${names[0]}: ${counted(corners, "corner")}, ${HOW[how]}.`), table, ...notes.map(paragraph));
}

/* The camera faces the place of the largest angle. */
function faceWorst(worst) {
  const { frame, up } = page.scene;
  if (!worst.every(Number.isFinite)) return null;
  const [x, y, z] = point(multiply(frame, turning(up)), worst), reach = Math.hypot(x, y, z), degrees = 180 / Math.PI;
  return reach > 0.05 ? fly({ distance: 3.4, centre: [0, 0, 0], azimuth: Math.atan2(x, z) * degrees, elevation: Math.max(-60, Math.min(60, Math.asin(y / reach) * degrees)) }) : null;
}

/* given: files that were chosen. */
export async function compareWith(given) {
  const mine = page.opening, base = { ...(page.before ?? page.scene).files, name: page.source?.name };
  if (!given.length || !base.name) return;
  byId("compared-facts").textContent = "Comparing …";
  try {
    const { files, models } = await gather(given), needed = await bytesFor(files, models[0]), name = models[0].split("/").pop();
    const { model, ...differences } = await page.remote.compareFiles(base, { ...needed, name });
    if (mine !== page.opening) { page.remote.free(model.number); return; }
    showModel(model, { changed: true, files: needed });
    const most = (lists) => lists.reduce((all, list) => list.reduce((a, b) => Math.max(a, b), all), 0);
    page.scene.compared = { ...differences, worstOf: Object.fromEntries(KINDS.map((kind) => [kind, most(differences.values[kind])])) };
    for (const kind of KINDS) option("colours", kind).disabled = false;
    byId("colours").value = "deviation";
    byId("fix-facts").textContent = byId("computed-facts").textContent = "";
    byId("tint-row").hidden = true;
    dirty.compute = dirty.draw = true;
    showDifferences(differences, [base.name, name]);
    await faceWorst(differences.worst);
    sweep();
  } catch (error) {
    if (mine === page.opening) byId("compared-facts").textContent = hintFor(error.message);
  }
}
