/* Opening: a model that is built in, files, what norma view put into the page, the surface that moves; and what the page shows of each. */
import { applyAddress } from "./address.js";
import { triedBy } from "./changes.js";
import { byId, isChecked, numberOf, setMatrix, setRange, value } from "./controls.js";
import { bytesFor, gather, hintFor, listFiles } from "./files.js";
import { listFindings, pressFinding } from "./findings.js";
import { freeMaterials, readMaterials } from "./materials.js";
import { IDENTITY } from "./matrix.js";
import { makeMoving } from "./moving.js";
import { listParts, showMaterialControls } from "./parts.js";
import { chooseFinding } from "./pressed.js";
import { count, counted, notice, showModelFacts } from "./readouts.js";
import { isShown, wantsTangents, wishes } from "./recompute.js";
import { itemsOf, makeScene } from "./scene.js";
import { SHAPES } from "./shapes.js";
import { DEFAULT_CURSOR, UNMARKED, camera, canvas, dirty, hurry, page } from "./state.js";

/* Degrees, of a file that is opened. */
const CREASE = 60;
export const option = (select, kind) => byId(select).querySelector(`[value="${kind}"]`);

function dropScenes() {
  for (const old of [page.scene, page.before]) if (old) { old.free(); if (old.model) page.remote.free(old.model.number); }
  page.moving?.free();
  page.graphics.lit.forget();
  page.animation.forget();
  page.scene = page.before = page.moving = page.chosen = page.found = null;
  page.look = { ...page.look, ...UNMARKED };
}

/* Shows a model instead of what was there; or, changed, beside it. */
export function showModel(model, { changed = false, files = model.files } = {}) {
  if (changed) {
    const original = page.before ?? page.scene;
    if (page.before) { page.scene.free(); page.remote.free(page.scene.model.number); }
    page.before = original;
    page.scene = makeScene(page.graphics, model, original.up, original.frame);
    page.scene.hidden = original.hidden;
    if (page.chosen) camera.reset();      /* it stood close to one finding */
    page.chosen = null;
    byId("places").hidden = true;
    page.look = { ...page.look, ...UNMARKED };
  } else {
    dropScenes();
    page.scene = makeScene(page.graphics, model);
  }
  page.scene.files = files;
  const stored = model.meshes.some((mesh) => mesh.stored);
  option("source", "stored").disabled = !model.isShaded;
  option("colours", "error").disabled = !stored;
  for (const kind of ["deviation", "distance"]) option("colours", kind).disabled = true;
  byId("compared-facts").replaceChildren();
  byId("source").value = model.isShaded ? "stored" : "computed";
  showFindings(model);
  if (byId("colours").selectedOptions[0].disabled) byId("colours").value = "lit";
  if (!changed) showMaterialControls(model);
  showModelFacts(model);
  listParts(page.scene, () => { dirty.draw = true; });
  loadMaterials(page.scene, files);
  if (!changed && files) page.animation.open(files.files, files.path);
  showSections();
  dirty.compute = true;
  hurry();
}

/* unchecked: what norma check says is still to come. */
function showFindings(model) {
  listFindings(model.unchecked ? undefined : model.findings, chooseFinding, (finding) => (model.meshes[finding.mesh] ? page.thumbs.add(finding) : null));
  byId("finding-seen").textContent = "";
  option("colours", "findings").disabled = !model.findings?.length;
  byId("fix").classList.toggle("main", triedBy(model.findings).length > 0);
}

/* Asks norma check, behind the first picture. */
async function check(model) {
  try {
    model.findings = await page.remote.check(model.number, model.source.path, model.source.name);
  } catch (error) {
    model.findings = null;
    throw error;
  } finally {
    model.unchecked = false;
    if (page.scene?.model === model) showFindings(model);
  }
}

/* Into a buffer of its own, slowly. */
async function loadList(shown, surface, name, at, list) {
  if (!list || !isShown(shown)) return;
  const made = page.graphics.reserve(list.byteLength), to = shown.surfaces[surface];
  await page.graphics.fillSlowly(made, list);
  if (at === null) to[name] = made; else to[name][at] = made;
}

/* Materials with their images, and colours of vertices, follow by themselves. files: what the model was read from. */
async function loadMaterials(shown, files) {
  const { model } = shown;
  await shown.seen;
  if (!isShown(shown)) return;
  page.loading++;
  try {
    if (model.meshes.some(({ hasColours }) => hasColours)) for (const [i, list] of (await page.remote.colours(model.number)).entries()) await loadList(shown, i, "colours", null, list);
    const read = files ? await readMaterials(files.files, files.path) : null;
    if (!read || !isShown(shown)) { if (read) freeMaterials(read.list); return; }
    for (const [i, sets] of (await page.remote.texcoords(model.number)).entries()) for (const [set, list] of sets.entries()) await loadList(shown, i, "texcoords", set, list);
    if (!isShown(shown)) { freeMaterials(read.list); return; }
    const dressed = itemsOf(page.norma, { ...shown, materials: read.list, hidden: new Set() }, IDENTITY, "right");
    await page.graphics.lit.prepare(dressed, { materials: true, normalMaps: true }, whenQuiet);
    if (!isShown(shown)) { freeMaterials(read.list); return; }
    shown.materials = read.list;
    shown.freeMaterials = () => freeMaterials(read.list);
    showMaterialControls(model, read.list);
    if (read.ktx2) byId("model-facts").append(` ${counted(read.ktx2, "texture is", "textures are")} KTX2, which this page does not show: plain colours stand there.`);
    if (read.unread) byId("model-facts").append(` ${counted(read.unread, "image is", "images are")} missing or cannot be read.`);
    if (wantsTangents(shown)) dirty.compute = true;
  } catch (error) {
    notice(error.message);
  } finally {
    page.loading--;
    dirty.draw = true;
  }
}

/* When no picture is being drawn, and the card has done all else; while an animation plays, between two of its pictures, which never end. */
export async function whenQuiet() {
  do await page.graphics.drained(); while (page.drawing && !page.animation.isPlaying());
}

let lessonOf = null;
export function showSections() {
  const live = page.moving !== null;
  byId("matrix-section").hidden = byId("normals-section").hidden = live;
  byId("moving-section").hidden = !live;
  option("shading", "flat").disabled = option("hedgehog", "face").disabled = option("colours", "angle").disabled = live;
  if (live) for (const kind of ["error", "findings", "deviation", "distance"]) option("colours", kind).disabled = true;
  byId("fixing").hidden = byId("computing").hidden = byId("comparing").hidden = !page.source;
  const isFile = Boolean(page.scene?.model?.format);
  if (lessonOf !== isFile) byId("matrix-box").open = !isFile;      /* whoever brings a model did not come for the lesson */
  lessonOf = isFile;
  byId("model-credit").hidden = value("model") !== "sculpture";
  canvas.classList.toggle("brush", live && isChecked("brush"));
}

/* Whoever does something has seen enough of the first seconds. */
export function stopIntro() {
  if (!page.intro.isShown()) return;
  page.intro.end();
  camera.reset({ azimuth: camera.azimuth, elevation: camera.elevation });      /* the panel takes a part of the window */
  page.cursor = DEFAULT_CURSOR;
  dirty.draw = true;
}

/* The files that may be shown, { files, path } each; and what is shown: one of them, or the value of another option. */
let fileChoices = [], shownChoice = null;
const choiceNow = () => fileChoices[Number(value("model").slice(4))] ?? value("model");

function listChoices(choices, chosen) {
  const select = byId("model");
  select.querySelectorAll('[value^="file"]').forEach((old) => old.remove());
  fileChoices = choices;
  select.prepend(...choices.map(({ path }, i) => new Option(choices.length > 1 ? path : path.split("/").pop(), `file${i}`)));
  select.value = choices.includes(chosen) ? `file${choices.indexOf(chosen)}` : chosen;
}

/* What was shown stays: its name, and its files, which the worker gave up for those of the other. */
function keepShown(failed) {
  const others = fileChoices.filter((choice) => choice !== failed), isListed = typeof shownChoice === "string" || others.includes(shownChoice);
  listChoices(isListed ? others : [shownChoice, ...others], shownChoice);
  forgetChosen();
  if (page.source) page.remote.giveFiles((page.before ?? page.scene).files.files).catch((error) => notice(error.message));
}

/* Asks for a model; what is asked for last is shown. */
export async function show(ask, then = () => undefined) {
  const mine = ++page.opening, choice = choiceNow();
  page.awaiting = true;      /* of what was there nothing is drawn unasked: the new one would wait for it */
  try {
    const model = await ask();
    if (mine !== page.opening) { page.remote.free(model.number); return; }
    page.awaiting = false;
    if (!model.triangles) { page.remote.free(model.number); throw new Error(`${model.name}: there is nothing in it to draw.`); }
    showModel(model);
    shownChoice = choice;
    then(model);
    const asked = follow();
    await page.scene.seen;
    if (model.unchecked) await check(model);
    if (asked?.has("finding") && page.scene?.model === model) pressFinding(asked.get("finding"));
  } catch (error) {
    if (mine !== page.opening) return;
    page.awaiting = false;
    if (page.scene) { if (choice !== shownChoice) keepShown(choice); }
    else if (page.sculpture) { byId("model").value = "sculpture"; pickModel(); } // the page's first file: the stage is not left empty
    notice(hintFor(error.message));
  }
}

function follow() {
  const asked = page.atFirst;
  page.atFirst = null;
  if (asked) applyAddress(asked, camera);
  return asked;
}

export function showMoving() {
  page.opening++;
  page.awaiting = false;
  page.atFirst = null;
  dropScenes();
  shownChoice = "moving";
  page.moving = makeMoving(page.norma);
  const surface = page.graphics.makeSurface({ positions: page.moving.positions(), normals: page.moving.normals(), indices: page.moving.indices });
  page.scene = { model: null, hidden: new Set(), surfaces: [surface], still: page.graphics.makeBuffer(page.moving.still), free: () => surface.free() };
  byId("model-facts").textContent = `${count(page.moving.triangles)} triangles, computed anew for every picture.`;
  if (["error", "findings", "angle", "tangents", "deviation", "distance"].includes(value("colours"))) byId("colours").value = "lit";
  if (value("shading") === "flat") byId("shading").value = "phong";
  listFindings(null);
  listParts(page.scene);
  showMaterialControls(null);
  page.moving.wave(0, numberOf("height"));
  uploadMoving();
  showSections();
  dirty.draw = true;
}

export function uploadMoving() {
  page.graphics.fillBuffer(page.scene.surfaces[0].positions, page.moving.positions());
  page.graphics.fillBuffer(page.scene.surfaces[0].normals, page.moving.normals());
}

/* The model fills the picture, as large as that is now: the first seconds had all of the window. */
function settle() {
  camera.aspect = canvas.clientWidth / Math.max(1, canvas.clientHeight);
  camera.settle(camera.framing(page.scene.corners()));
}

export async function openGiven(given) {
  notice("");
  page.atFirst = null;
  stopIntro();
  if (!given.length) return;
  try {
    const { files, models } = await gather(given);
    const choices = models.map((path) => ({ files, path }));
    listChoices(choices, choices[0]);
    openFile(files, models[0]);
  } catch (error) {
    notice(error.message);
  }
}

/* What was said of another file's copies. */
function forgetCopies() {
  for (const id of ["fix-facts", "computed-facts", "fixed-list", "stays"]) byId(id).textContent = "";
  byId("stays-box").hidden = byId("tint-row").hidden = true;
  for (const id of ["fixed-files", "computed-files"]) listFiles(id, []);
}

function openFile(files, path) {
  page.graphics.lit.warmUp();
  return show(async () => {
    const needed = await bytesFor(files, path), name = path.split("/").pop(), model = await page.remote.openFiles(needed.files, needed.path, name, { ...wishes(), crease: CREASE, errors: false });
    model.unchecked = true;
    model.files = needed;
    model.source = { path: needed.path, name };
    return model;
  }, (model) => {
    page.source = model.source;
    byId("other").value = "";
    forgetCopies();
    setMatrix();
    if (value("sides") === "beside") byId("sides").value = "split";
    byId("colours").value = "lit";
    setRange("crease", CREASE);
    settle();
    document.title = `${page.source.name} · Norma`;
    byId("model").title = byId("model").selectedOptions[0].textContent;
    showSections();
  });
}

/* The model of norma view: drawn from its pack; what may be fixed is its file, where the page holds that. */
function openEmbedded() {
  const { text, name, files } = page.embedded;
  page.graphics.lit.warmUp();
  return show(async () => {
    if (files) await page.remote.giveFiles(files.files);
    return { ...(await page.remote.openText(text, name, { ...wishes(), errors: false })), files };
  }, () => {
    page.source = files && { path: files.path, name };
    forgetCopies();
    settle();
    showSections();
  });
}

/* What is shown now is not the file that was chosen before. */
export function forgetChosen() { byId("file").value = byId("folder").value = ""; }

const VIEWS = { moving: { azimuth: 20, elevation: 34, distance: 3.3 }, sculpture: { azimuth: 24, elevation: 10, distance: 2.2 } };

export function pickModel() {
  const key = value("model");
  byId("model").title = "";
  notice("");
  if (!key.startsWith("file")) { forgetChosen(); page.source = null; byId("model").querySelectorAll('[value^="file"]').forEach((old) => old.remove()); }
  if (key === "moving") showMoving();
  else if (key === "embedded") openEmbedded();
  else if (key === "sculpture") show(async () => ({ ...(await page.remote.openTriangles({ ...page.sculpture, positions: page.sculpture.positions.slice(), indices: page.sculpture.indices.slice() })), isWooden: true }), () => { setRange("crease", 180); if (page.intro.isShown()) page.intro.frame(); });
  else if (key.startsWith("file")) { const { files, path } = fileChoices[Number(key.slice(4))]; openFile(files, path); }
  else if (SHAPES[key]) show(() => page.remote.openShape(key), () => setRange("crease", SHAPES[key].crease ?? 60));
  camera.settle(VIEWS[key]);
}
