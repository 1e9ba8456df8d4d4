/* What a control asks of the worker: normals, tangents, errors, marks of findings, into the buffers of what is shown. */
import { numberOf, value } from "./controls.js";
import { notice, showComputeFacts } from "./readouts.js";
import { dirty, page } from "./state.js";

const WARM_RUNS = 5, QUIET = 600;

export const isShown = (one) => one === page.scene || one === page.before;

function wanted() {
  if (value("colours") === "error") return "computed";
  return value("shading") === "flat" && value("colours") === "lit" ? "flat" : value("source");
}

export const wishes = () => ({ wanted: wanted(), weight: value("weight"), weld: value("weld"), crease: numberOf("crease"), errors: value("colours") === "error" });
export const wantsTangents = (shown) => value("colours") === "tangents" || (shown.materials && shown.model.meshes.some(({ hasTangents }) => hasTangents));

/* Of the normals that are shown. */
async function uploadTangents(shown) {
  const lists = await page.remote.tangents(shown.model.number);
  for (const [i, list] of lists.entries()) {
    if (!list || (shown !== page.scene && shown !== page.before)) continue;
    shown.surfaces[i].tangents ??= page.graphics.reserve(list.byteLength);
    await page.graphics.fillSlowly(shown.surfaces[i].tangents, list);
  }
}

/* One after the other, since each takes buffers away that another may be filling; of a model only what was asked last is carried to its end. */
const asked = new WeakMap();
let filled = Promise.resolve();

async function fillMarks(shown, finding, mine) {
  const { model, surfaces } = shown, isWanted = () => isShown(shown) && asked.get(shown) === mine;
  if (!isWanted()) return;
  const lists = finding ? new Map([[finding.mesh, surfaces[finding.mesh] && (await page.remote.markOf(model.number, finding.mesh, finding.index))]]) : new Map((await page.remote.marks(model.number)).entries());
  for (const [i, surface] of surfaces.entries()) {
    if (!isWanted()) return;
    const list = lists.get(i);
    if (list) await page.graphics.fillMarks(surface, "marks", list);
    else if (surface.marks) { page.graphics.gl.deleteBuffer(surface.marks); surface.marks = null; }
  }
}

/* What all findings name, or one of a mesh: the others have no marks then. */
export function uploadMarks(shown, finding) {
  const mine = {};
  asked.set(shown, mine);
  const done = filled.then(() => fillMarks(shown, finding, mine));
  filled = done.catch(() => undefined);
  return done;
}

/* Whether a model has these normals since it was opened. */
function asAdded({ model }, options) {
  const { options: had } = model;
  model.options = null;
  return had !== null && Object.keys(options).every((name) => had[name] === options[name]);
}

export async function compute() {
  const options = wishes(), shown = [page.scene, page.before].filter(Boolean);
  page.computing = true;
  dirty.compute = false;
  try {
    for (const one of shown) {
      await one.filled;
      if (asAdded(one, options)) { if (wantsTangents(one)) await uploadTangents(one); continue; }
      const { normals, errors } = await page.remote.compute(one.model.number, options);
      if (one !== page.scene && one !== page.before) continue;
      for (const [i, list] of normals.entries()) await page.graphics.fillSlowly(one.surfaces[i].normals, list);
      const differences = one.compared?.values[value("colours")];
      if (errors ?? differences) uploadErrors(one, errors ?? { worst: one.compared.worstOf[value("colours")], values: differences });
      if (wantsTangents(one)) await uploadTangents(one);
    }
    if (page.scene === shown[0] && value("colours") === "findings") for (const one of shown) await uploadMarks(one, one === page.scene ? page.chosen : null);
  } catch (error) {
    if (shown[0] === page.scene) notice(error.message);
  }
  page.computing = false;
  page.computed++;
  dirty.draw = true;
  if (shown[0] === page.scene) warmUp(options);
}

/* Times what was computed once it has been quiet for a while: nothing was warm before. */
async function warmUp(options) {
  const mine = page.computed, { model } = page.scene, times = [];
  showComputeFacts(times, model, options.wanted);
  await new Promise((done) => setTimeout(done, QUIET));
  while (times.length < WARM_RUNS && mine === page.computed && !dirty.compute && page.scene?.model === model && options.wanted !== "stored") times.push(await page.remote.time(model.number, options));
  if (times.length === WARM_RUNS && mine === page.computed && page.scene?.model === model) showComputeFacts(times, model, options.wanted);
}

function uploadErrors(one, { worst, values }) {
  one.surfaces.forEach((surface, i) => {
    if (surface.values) page.graphics.fillBuffer(surface.values, values[i]);
    else surface.values = page.graphics.makeBuffer(values[i], page.graphics.gl.DYNAMIC_DRAW);
  });
  if (one !== page.scene) return;
  page.look.errorTop = topOfScale(values, worst, value("colours") === "distance" ? 1e-9 : 0.01);
  page.look.errorWorst = worst;
}

/* The scale ends where 99 of 100 corners lie below, so that a single bad one does not make all others look right. */
function topOfScale(lists, worst, least) {
  const sample = [], total = lists.reduce((most, list) => most + list.length, 0), step = Math.max(1, Math.floor(total / 20000));
  for (const list of lists) for (let i = 0; i < list.length; i += step) sample.push(list[i]);
  sample.sort((a, b) => a - b);
  return Math.max(least, Math.min(worst, 1.05 * (sample[Math.floor(0.99 * sample.length)] ?? 0)));
}
