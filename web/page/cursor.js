/* What lies under the cursor, and the numbers beside the picture. */
import { byId } from "./controls.js";
import { showFormula } from "./lesson.js";
import { apply3, degreesBetween, invert, point, unit, upper } from "./matrix.js";
import { panelAt } from "./panels.js";
import { degrees, showMatrix, showMatrixFacts } from "./readouts.js";
import { itemsOf } from "./scene.js";
import { camera, canvas, dirty, page } from "./state.js";

/* The ray under it, through the panel that it is in. */
export function cursorRay() {
  if (!page.cursor) return null;
  const seen = page.cursor.itself ? { panel: page.panels.find(({ side }) => side === "right") ?? page.panels[0], x: 0.08, y: 0.12 } : panelAt(page.panels, page.cursor.x * canvas.clientWidth, page.cursor.y * canvas.clientHeight);
  if (!seen) return null;
  camera.aspect = seen.panel.box.width / seen.panel.box.height;
  return camera.ray(seen.x, seen.y);
}

/* Asks the worker, unless it was asked the same before. */
async function pick(user) {
  const ray = cursorRay(), shown = page.scene, key = [user, shown.model.number, page.computed, ray ? [...ray.from, ...ray.along] : ""].join();
  if (page.picking || shown.picked === key) return;
  shown.picked = key;
  page.picking = true;
  try {
    const items = ray ? itemsOf(page.norma, shown, user, "right") : [], rays = [];
    for (const item of items) {
      const inverse = invert(item.localToWorld);
      if (inverse) rays.push({ mesh: item.mesh, from: point(inverse, ray.from), along: apply3(upper(inverse), ray.along), item });
    }
    const hit = rays.length ? await page.remote.pick(shown.model.number, rays.map(({ mesh, from, along }) => ({ mesh, from, along }))) : null;
    if (shown === page.scene) page.found = hit && hitOf(hit, rays[hit.ray], ray);
  } catch { page.found = null; }
  page.picking = false;
  dirty.draw = true;
}

/* normal, object: before M, the model being as large as a ball of radius 1. inner: the ray where its part lies. */
function hitOf({ at, weights, normals }, { item, ...inner }, ray) {
  const stored = [0, 1, 2].map((i) => weights[0] * normals[i] + weights[1] * normals[3 + i] + weights[2] * normals[6 + i]), { world, local } = page.scene.draws[item.draw], along = ({ from, along: way }) => from.map((x, i) => x + at * way[i]);
  return { point: along(ray), object: point(local, along(inner)), normal: unit(apply3(Array.from(page.norma.normalMatrix(world)), stored)), right: unit(apply3(item.right, stored)), wrong: unit(apply3(item.plain, stored)) };
}

function pickMoving() {
  const ray = cursorRay(), at = ray && pointOnPlane(ray), hit = at && page.moving.at(at[0], at[2]);
  page.found = hit && { point: hit.point, right: hit.normal, wrong: [0, 1, 0] };
}

export function pointOnPlane({ from, along }) {
  const at = -from[1] / along[1];
  return at > 0 && isFinite(at) ? from.map((x, i) => x + at * along[i]) : null;
}

/* The two normals at the cursor. */
export function drawFound(view, pixels, colours) {
  const tip = (direction) => page.found.point.map((x, i) => x + 0.3 * direction[i]), arrow = (kind) => ({ from: page.found.point, to: tip(page.found[kind]), colour: colours[kind] });
  page.graphics.drawArrows(degreesBetween(page.found.wrong, page.found.right) < 0.05 ? [arrow("right")] : [arrow("wrong"), arrow("right")], view, pixels);
}

/* By how much the normals of this model err, from the worker. */
async function measure(user) {
  const shown = page.scene, key = [...user, page.computed].join();
  if (page.measuring || shown.worstKey === key || page.intro.isPlaying()) return;
  shown.worstKey = key;
  page.measuring = true;
  const items = itemsOf(page.norma, shown, user, "right").map(({ mesh, plain, right }) => ({ mesh, plain, right }));
  shown.worst = await page.remote.worst(shown.model.number, items).catch(() => null);
  page.measuring = false;
  dirty.draw = true;
}

let saying = null;

/* To those who listen, once it stands still. */
function say(text) {
  clearTimeout(saying);
  if (!page.intro.isPlaying()) saying = setTimeout(() => { if (byId("said").textContent !== text) byId("said").textContent = text; }, 900);
}

export function showReadouts(info, user, compared) {
  /* Of a file that is at rest, there is nothing of the lesson. */
  byId("worst-box").hidden = byId("under-box").hidden = Boolean(page.scene.model?.format) && compared !== "matrix";
  if (page.moving) {
    pickMoving();
    byId("worst").textContent = degrees(page.moving.worst());
    byId("under").textContent = page.found ? degrees(degreesBetween(page.found.wrong, page.found.right)) : "–";
    return;
  }
  byId("under").textContent = page.found && page.cursor ? degrees(degreesBetween(page.found.wrong, page.found.right)) : "–";
  byId("readouts").hidden = false;
  byId("worst-label").textContent = page.intro.isShown() ? "Wrong by up to" : "Worst angle possible";
  byId("worst").textContent = degrees(info.worstErrorDeg);
  if (compared === "matrix") say(`Worst angle ${degrees(info.worstErrorDeg)}`);
  showMatrix("matrix-plain", upper(user));
  showMatrix("matrix-normal", page.norma.normalMatrix(user));
  showMatrixFacts(info, page.scene.worst ?? null);
  if (byId("lesson").open) showFormula(user, Array.from(page.norma.normalMatrix(user)), page.found);
  pick(user);
  measure(user);
}
