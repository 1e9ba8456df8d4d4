/* The page: what its controls say is computed (in a worker) and drawn (here). Nothing is drawn but when something changed; what moves, moves by itself. */
import { bindCalls } from "../package/calls.js";
import { noDecoders } from "../package/decoders.js";
import { makeAnimation } from "./animation.js";
import { filesServed, servedPath } from "./served.js";
import { applyAddress, makeAddress, readAddress } from "./address.js";
import { makeCamera, steer } from "./camera.js";
import { rulesThatFell, whatStays, wordsOf } from "./changes.js";
import { MATRIX, RANGES, byId, isChecked, modelMatrix, numberOf, setMatrix, setRange, spell, value } from "./controls.js";
import { EXPECTED, bytesFor, downloadLink, filesOfDrop, filesOfInput, gather, hintFor } from "./files.js";
import { keyOf, listFindings, pressFinding, releaseFindings } from "./findings.js";
import { makeGraphics } from "./graphics.js";
import { makeIntro } from "./intro.js";
import { STEPS, showFormula } from "./lesson.js";
import { apply3, degreesBetween, IDENTITY, invert, length, multiply, point, unit, upper } from "./matrix.js";
import { freeMaterials, readMaterials } from "./materials.js";
import { makeMoving } from "./moving.js";
import { listParts, showMaterialControls, showPart } from "./parts.js";
import { NAME, panelAt, panelsOf } from "./panels.js";
import { savePicture, saveTurntable } from "./picture.js";
import { count, counted, degrees, notice, showComputeFacts, showMatrix, showMatrixFacts, showModelFacts, showMovingFacts } from "./readouts.js";
import { bytesOf, moduleOf } from "./inflate.js";
import { startRemote } from "./remote.js";
import { fitOf, itemsOf, largestColumn, makeScene, meanColumn, turning } from "./scene.js";
import { CREDIT, unpackSculpture } from "./sculpture.js";
import { posesOf, seek } from "./seek.js";
import { SHAPES } from "./shapes.js";
import { makeThumbs, viewOf } from "./thumbs.js";

const canvas = byId("canvas"), stage = byId("stage");
const camera = makeCamera();
const COLOURS = { light: { wrong: [0.75, 0.03, 0.02, 1], right: [0.02, 0.45, 0.12, 1], before: [0.2, 0.2, 0.2, 1] }, dark: { wrong: [1, 0.25, 0.18, 1], right: [0.2, 0.85, 0.45, 1], before: [0.8, 0.8, 0.8, 1] } };
const PIN_COLOURS = { error: [0.37, 0.002, 0.002, 1], warning: [0.55, 0.085, 0.001, 1], info: [0.002, 0.037, 0.27, 1] };
const MOST_LINES = 60000, WARM_RUNS = 5, QUIET = 600;
const DEFAULT_CURSOR = { x: 0.5, y: 0.47, itself: true };
const ANGLE_TOPS = [1, 2, 5, 10, 15, 30, 45, 60, 90, 180];
const REACH = 2.2;

let norma, remote, graphics, intro, thumbs, animation, remember = () => undefined;
/* What is shown: a scene, and the one before it was changed; or the surface that moves; and where its file came from. */
let scene = null, before = null, moving = null, source = null, sculpture = null;
const UNMARKED = { through: false, dim: false, pins: null, place: null, outline: null, unpainted: false }, FLIGHT = 450, SWEEP = 2600;
let chosen = null, look = { ...UNMARKED, errorTop: 1, angleTop: 45 };
let cursor = DEFAULT_CURSOR, panels = [], found = null;
let lessonOf = null, dirty = { compute: true, draw: true }, calls = 0, drawing = false, computing = false, picking = false, measuring = false, loading = 0, seeking = 0, computed = 0, opening = 0;
const timer = { last: 0, frames: 0 };

const isDark = () => matchMedia("(prefers-color-scheme: dark)").matches;
const isCalm = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

/* ---- models */

const option = (select, kind) => byId(select).querySelector(`[value="${kind}"]`);

function dropScenes() {
  for (const old of [scene, before]) if (old) { old.free(); if (old.model) remote.free(old.model.number); }
  moving?.free();
  graphics.lit.forget();
  animation.forget();
  scene = before = moving = chosen = found = null;
  look = { ...look, ...UNMARKED };
}

/* Shows a model instead of what was there; or, changed, beside it. */
function showModel(model, { changed = false, files = model.files } = {}) {
  if (changed) {
    const original = before ?? scene;
    if (before) { scene.free(); remote.free(scene.model.number); }
    before = original;
    scene = makeScene(graphics, model, original.up, original.frame);
    scene.hidden = original.hidden;
    if (chosen) camera.reset();      /* it stood close to one finding */
    chosen = null;
    byId("places").hidden = true;
    look = { ...look, ...UNMARKED };
  } else {
    dropScenes();
    scene = makeScene(graphics, model);
  }
  scene.files = files;
  const stored = model.meshes.some((mesh) => mesh.stored);
  option("source", "stored").disabled = option("colours", "error").disabled = !stored;
  byId("source").value = stored ? "stored" : "computed";
  listFindings(model.findings, chooseFinding, (finding) => (model.meshes[finding.mesh] ? thumbs.add(finding) : null));
  byId("finding-seen").textContent = "";
  option("colours", "findings").disabled = !model.findings?.length;
  if (byId("colours").selectedOptions[0].disabled) byId("colours").value = "lit";
  if (!changed) showMaterialControls(model);
  showModelFacts(model);
  listParts(scene, () => { dirty.draw = true; });
  loadMaterials(scene, files);
  if (!changed && files) animation.open(files.files, files.path);
  showSections();
  dirty.compute = dirty.draw = true;
}

const isShown = (one) => one === scene || one === before;
/* Into a buffer of its own, slowly. */
async function loadList(shown, surface, name, at, list) {
  if (!list || !isShown(shown)) return;
  const made = graphics.reserve(list.byteLength), to = shown.surfaces[surface];
  await graphics.fillSlowly(made, list);
  if (at === null) to[name] = made; else to[name][at] = made;
}

/* Materials with their images, and colours of vertices, follow by themselves. files: what the model was read from. */
async function loadMaterials(shown, files) {
  const { model } = shown;
  loading++;
  try {
    if (model.meshes.some(({ hasColours }) => hasColours)) for (const [i, list] of (await remote.colours(model.number)).entries()) await loadList(shown, i, "colours", null, list);
    const read = files ? await readMaterials(files.files, files.path) : null;
    if (!read || !isShown(shown)) { if (read) freeMaterials(read.list); return; }
    for (const [i, sets] of (await remote.texcoords(model.number)).entries()) for (const [set, list] of sets.entries()) await loadList(shown, i, "texcoords", set, list);
    if (!isShown(shown)) { freeMaterials(read.list); return; }
    shown.materials = read.list;
    shown.freeMaterials = () => freeMaterials(read.list);
    showMaterialControls(model, read.list);
    if (read.unread) byId("model-facts").append(` ${counted(read.unread, "image is", "images are")} missing or cannot be read.`);
    if (wantsTangents(shown)) dirty.compute = true;
  } catch (error) {
    notice(error.message);
  } finally {
    loading--;
    dirty.draw = true;
  }
}

const wantsTangents = (shown) => value("colours") === "tangents" || (shown.materials && shown.model.meshes.some(({ hasTangents }) => hasTangents));

/* Of the normals that are shown. */
async function uploadTangents(shown) {
  const lists = await remote.tangents(shown.model.number);
  for (const [i, list] of lists.entries()) {
    if (!list || (shown !== scene && shown !== before)) continue;
    shown.surfaces[i].tangents ??= graphics.reserve(list.byteLength);
    await graphics.fillSlowly(shown.surfaces[i].tangents, list);
  }
}

/* Asks for a model; what is asked for last is shown. */
async function show(ask, then = () => undefined) {
  const mine = ++opening;
  try {
    const model = await ask();
    if (mine !== opening) { remote.free(model.number); return; }
    if (!model.triangles) { remote.free(model.number); throw new Error(`${model.name}: there is nothing in it to draw.`); }
    showModel(model);
    then(model);
    follow();
  } catch (error) {
    if (mine !== opening) return;
    if (!scene && sculpture) { byId("model").value = "sculpture"; pickModel(); } // the page's first file: the stage is not left empty
    notice(hintFor(error.message));
  }
}

/* What the address asks of the model that is opened first. */
let atFirst = null;
function follow() {
  const asked = atFirst;
  atFirst = null;
  if (!asked) return;
  applyAddress(asked, camera);
  if (asked.has("finding")) pressFinding(asked.get("finding"));
}

function showMoving() {
  opening++;
  atFirst = null;
  dropScenes();
  moving = makeMoving(norma);
  const surface = graphics.makeSurface({ positions: moving.positions(), normals: moving.normals(), indices: moving.indices });
  scene = { model: null, hidden: new Set(), surfaces: [surface], still: graphics.makeBuffer(moving.still), free: () => surface.free() };
  byId("model-facts").textContent = `${count(moving.triangles)} triangles, computed anew for every picture.`;
  if (["error", "findings", "angle", "tangents"].includes(value("colours"))) byId("colours").value = "lit";
  if (value("shading") === "flat") byId("shading").value = "phong";
  listFindings(null);
  listParts(scene);
  showMaterialControls(null);
  moving.wave(0, numberOf("height"));
  uploadMoving();
  showSections();
  dirty.draw = true;
}

function showSections() {
  const live = moving !== null;
  byId("matrix-section").hidden = byId("normals-section").hidden = live;
  byId("moving-section").hidden = !live;
  option("shading", "flat").disabled = option("hedgehog", "face").disabled = option("colours", "angle").disabled = live;
  if (live) for (const kind of ["error", "findings"]) option("colours", kind).disabled = true;
  byId("fixing").hidden = byId("computing").hidden = !source;
  const isFile = Boolean(scene?.model?.format);
  if (lessonOf !== isFile) byId("matrix-box").open = !isFile;      /* whoever brings a model did not come for the lesson */
  lessonOf = isFile;
  byId("model-credit").hidden = value("model") !== "sculpture";
  canvas.classList.toggle("brush", live && isChecked("brush"));
}

/* ---- findings */

const userMatrix = () => (moving ? IDENTITY : modelMatrix());

/* The finding's mesh where it is drawn, and its place there. */
function placeIn(finding, { point: at, direction, size, points }, shown = scene) {
  const draw = shown.draws[finding.draw] ?? shown.draws.find(({ mesh }) => mesh === finding.mesh);
  if (!at || !draw) return null;
  const user = userMatrix(), toWorld = multiply(fitOf(user), multiply(user, draw.local));
  let normal = direction;
  try { normal = apply3(Array.from(norma.normalMatrix(toWorld)), direction); } catch { /* a node that is not finite */ }
  const pins = Array.from({ length: points.length / 3 }, (_, i) => point(toWorld, points.slice(3 * i, 3 * i + 3))), where = point(toWorld, at);
  return { at: where, normal: length(normal) > 0 ? unit(normal) : camera.axes().back, size: size * meanColumn(toWorld), pins: pins.length ? pins : [where] };
}

/* Whether a finding is about a part rather than about places on it. */
const isOfWhole = (shown, { mesh, places, severity }, place) => shown.model.meshes[mesh] !== undefined && (!place || (severity < 2 && places > shown.model.meshes[mesh].faces / 2));
/* What is drawn of a part that a finding is about: of its node, if that is what it names. */
const partOf = ({ mesh, draw }) => (item) => item.mesh === mesh && (draw < 0 || item.draw === draw);
/* From where the part fills a good part of the picture; all of the model where it lies in more places than one. */
function poseOfPart(finding, items) {
  const parts = items.filter(partOf(finding)), whole = { azimuth: camera.azimuth, elevation: camera.elevation };
  if (parts.length !== 1) return whole;
  const [{ localToWorld }] = parts, radius = largestColumn(localToWorld);
  return radius > 0 && isFinite(radius) ? { ...whole, centre: localToWorld.slice(12, 15), distance: Math.max(0.02, Math.min(3.4, 3.6 * radius)) } : whole;
}

/* What a small picture of a finding is made of. */
async function seenSmall(finding) {
  const shown = scene;
  if (!shown?.model?.findings?.includes(finding)) return null;
  const place = placeIn(finding, await remote.place(shown.model.number, finding.index, 0)), items = itemsOf(norma, shown, userMatrix(), "right"), isWhole = isOfWhole(shown, finding, place), outline = isWhole ? partOf(finding) : null;
  return { scene: shown, items, place: isWhole ? null : place, whole: isWhole ? { ...poseOfPart(finding, items), azimuth: 38, elevation: 18 } : null, up: camera.axes().up, paper: isDark() ? [0.125, 0.16, 0.17] : [0.914, 0.906, 0.875],
           look: { outline, outlineColour: PIN_COLOURS[finding.grade], outlineWidth: 3 }, pins: (view) => graphics.drawPins(place.at, view, PIN_COLOURS[finding.grade], 22) };
}

/* Marks a finding alone, and takes the camera where enough of it is seen. */
async function chooseFinding(finding, which = 0) {
  const mine = ++seeking, shown = scene;
  chosen = finding;
  if (finding) animation.stop();
  byId("colours").value = finding ? "findings" : "lit";
  byId("finding-seen").textContent = "";
  byId("places").hidden = true;
  look = { ...UNMARKED, errorTop: look.errorTop, angleTop: look.angleTop };
  try {
    if (finding) showPart(shown, finding.mesh);
    await uploadMarks(shown, finding?.index);
    const place = finding && placeIn(finding, await remote.place(shown.model.number, finding.index, which));
    if (mine !== seeking || shown !== scene) return;
    if (!finding) return;
    const items = itemsOf(norma, shown, userMatrix(), "right");
    if (!shown.model.meshes[finding.mesh]) { camera.reset(); byId("finding-seen").textContent = "This is about the file, not about a place on its surface."; return; }
    if (isOfWhole(shown, finding, place)) {
      look = { ...look, outline: partOf(finding), unpainted: finding.severity < 2 };
      byId("finding-seen").textContent = "This is about a whole part: the line goes round it.";
      await fly({ distance: 3.4, centre: [0, 0, 0], ...poseOfPart(finding, items) });
      return;
    }
    look.dim = true;
    const everywhere = finding.places > shown.model.meshes[finding.mesh].faces / 2, aspect = canvas.clientWidth / Math.max(1, canvas.clientHeight);
    const counts = (poses, through) => graphics.countMarked(items, poses.map((pose) => viewOf(pose, aspect, REACH)), aspect, through);
    const best = await seek(posesOf(place, camera.axes().up, everywhere), counts);
    if (mine !== seeking || shown !== scene) return;
    look = { ...look, through: best.faint, pins: best.pinned ? [place.at] : null, place };
    byId("finding-seen").textContent = best.pinned ? "What is meant is too thin to be seen: a disc shows where it is." : best.faint ? "Other parts stand in front; it is drawn over them." : "";
    showPlaces(which, place.pins.length);
    await fly({ ...best.pose, centre: [...best.pose.centre] });
  } catch (error) {
    notice(error.message);
  } finally {
    if (mine === seeking) { seeking = 0; placeStage(); }
    dirty.draw = true;
  }
}

/* The camera goes from the whole to a place; whoever moves it stops it. */
let flights = 0;
async function fly(to) {
  const mine = ++flights, whole = makeCamera(), mix = (a, b, part) => a + (b - a) * part;
  whole.azimuth = to.azimuth + Math.max(-40, Math.min(40, ((camera.azimuth - to.azimuth + 540) % 360) - 180));
  for (const begin = performance.now(); mine === flights; await new Promise(requestAnimationFrame)) {
    const time = isCalm() ? 1 : Math.min(1, (performance.now() - begin) / FLIGHT), part = time * time * (3 - 2 * time);
    camera.reset({ azimuth: mix(whole.azimuth, to.azimuth, part), elevation: mix(whole.elevation, to.elevation, part), distance: Math.exp(mix(Math.log(whole.distance), Math.log(to.distance), part)), centre: whole.centre.map((x, i) => mix(x, to.centre[i], 1 - (1 - part) ** 2)) });
    dirty.draw = true;
    if (time === 1) return;
  }
}

/* Buttons from place to place. */
function showPlaces(which, count) {
  byId("places").hidden = count < 2;
  byId("next-place").textContent = `Next place (${which + 1} of ${count})`;
  byId("next-place").onclick = () => chooseFinding(chosen, (which + 1) % count);
  byId("all-places").onclick = () => {
    flights++;
    camera.reset();
    look = { ...look, through: true, pins: look.place.pins };
    dirty.draw = true;
  };
}

async function uploadMarks(shown, index) {
  const marks = await remote.marks(shown.model.number, index);
  for (const [i, surface] of shown.surfaces.entries()) {
    surface.marks ??= graphics.reserve(marks[i].byteLength);
    await graphics.fillSlowly(surface.marks, marks[i]);
  }
}

/* How many of the points are in the picture and not over each other. */
function apart(points, { worldToView, viewToClip }) {
  const toClip = multiply(viewToClip, worldToView), cells = new Set();
  for (const p of points) {
    const [x, y] = point(toClip, p), w = toClip[3] * p[0] + toClip[7] * p[1] + toClip[11] * p[2] + toClip[15];
    if (w > 0 && Math.abs(x) < w && Math.abs(y) < w) cells.add(`${Math.round((25 * x) / w)} ${Math.round((25 * y) / w)}`);
  }
  return Math.max(1, cells.size);
}

/* The whole in a corner, with the place marked. */
function drawCorner(pixels, draw) {
  const width = Math.round(Math.min(200, 0.28 * canvas.clientWidth)), height = Math.round(0.8 * width), box = { x: canvas.clientWidth - width - 12, y: canvas.clientHeight - height - 12, width, height }, whole = makeCamera();
  byId("whole").style.cssText = `width:${width}px;height:${height}px`;
  Object.assign(whole, { azimuth: camera.azimuth, elevation: camera.elevation, aspect: width / height });
  const part = { x: Math.round(box.x * pixels), y: Math.round(12 * pixels), width: Math.round(width * pixels), height: Math.round(height * pixels) };
  graphics.within(part, () => {
    const view = { worldToView: whole.worldToView(), viewToClip: whole.viewToClip(REACH) };
    graphics.paint(isDark() ? [0.11, 0.137, 0.149] : [1, 1, 1]);
    draw(view);
    if (!look.place) return;
    graphics.drawPins(look.place.at, view, isDark() ? [1, 1, 1, 1] : [0, 0, 0, 1], 13 * pixels);
    graphics.drawPins(look.place.at, view, isDark() ? [0, 0, 0, 1] : [1, 1, 1, 1], 8 * pixels);
  });
}

/* An arrow that points at the place of the finding that is chosen; discs where it has no area. */
function drawChosen(view, pixels) {
  if (value("colours") !== "findings" || !chosen || !look.place) return;
  const { place, pins } = look, reach = 0.09 * camera.distance, { right, up } = camera.axes(), ink = isDark() ? [1, 1, 1, 1] : [0, 0, 0, 1];
  if (pins) {
    const size = Math.max(9 * pixels, Math.min(80 * pixels, 2 * Math.sqrt((0.006 * canvas.width * canvas.height) / Math.PI / apart(pins, view))));
    graphics.drawPins(pins.flat(), view, ink, size + 3 * pixels);
    graphics.drawPins(pins.flat(), view, PIN_COLOURS[chosen.grade], size);
    return;
  }
  graphics.drawArrows([{ from: place.at.map((x, i) => x + reach * (place.normal[i] + right[i] + up[i])), to: place.at, colour: ink }], view, pixels);
}

/* ---- changed copies of the file: fixed, computed */

function listFiles(id, files) {
  byId(id).replaceChildren(...files.map((file) => {
    const item = document.createElement("li");
    item.append(downloadLink(file));
    return item;
  }));
}

const countGrade = (findings, grade) => (findings ?? []).filter((finding) => finding.grade === grade).length;
const sum = (findings) => `${counted(countGrade(findings, "error"), "error")} and ${counted(countGrade(findings, "warning"), "warning")}`;

const listWords = (id, words) => byId(id).replaceChildren(...words.map((text) => Object.assign(document.createElement("li"), { textContent: text })));

/* Asks for a changed copy, shows it beside the file as it is, and offers it. */
async function change(facts, links, ask, words, then = () => undefined) {
  const mine = opening;
  byId(facts).textContent = "Working …";
  listFiles(links, []);
  try {
    const wasChosen = chosen, result = await ask();
    if (mine !== opening) { if (result.model) remote.free(result.model.number); return; }
    byId(facts).textContent = words(result);
    const first = before ?? scene;
    if (result.changed) {
      const changes = await remote.changes(first.model.number, result.model.number).catch(() => null); /* then nothing is tinted */
      if (mine !== opening) { remote.free(result.model.number); return; }
      if (value("colours") === "findings") byId("colours").value = "lit";
      showModel(result.model, { changed: true, files: before?.files ?? scene.files });
      listFiles(links, result.files);
      await uploadTint(changes);
      if (mine !== opening) return;
      then(result, changes, first);
      await goToChange(wasChosen, changes);
      sweep();
    } else then(result, null, first);
  } catch (error) {
    byId(facts).textContent = error.message;
  }
}

/* What was changed, in colour on both sides. */
async function uploadTint(changes) {
  const mine = opening;
  byId("tint-row").hidden = !changes;
  for (const [shown, name] of [[before, "before"], [scene, "after"]])
    for (const [i, one] of (changes ?? []).entries()) {
      if (mine !== opening) return;
      shown.surfaces[i].tint ??= graphics.reserve(one.marks[name].byteLength);
      await graphics.fillSlowly(shown.surfaces[i].tint, one.marks[name]);
    }
  dirty.draw = true;
}

/* The camera goes to the place that was pressed, or else to the worst that is no longer found. */
async function goToChange(wasChosen, changes) {
  const [old, shown] = [before, scene], fell = new Set(rulesThatFell(old.model.findings, shown.model.findings).map(({ id }) => id)), gone = (old.model.findings ?? []).filter(({ id }) => fell.has(id)).sort((a, b) => b.severity - a.severity);
  const finding = gone.find(({ id, mesh }) => id === wasChosen?.id && mesh === wasChosen.mesh) ?? gone[0];
  if (!finding || !changes) return;
  const place = placeIn(finding, await remote.place(old.model.number, finding.index, 0), old);
  if (!place || isOfWhole(old, finding, place) || old !== before || shown !== scene) return;
  const items = itemsOf(norma, old, userMatrix(), "right"), aspect = canvas.clientWidth / Math.max(1, canvas.clientHeight);
  const best = await seek(posesOf(place, camera.axes().up), (poses, through) => graphics.countMarked(items, poses.map((pose) => viewOf(pose, aspect, REACH)), aspect, through, "tint"));
  /* Further away than one that is pressed: what was changed is seen among what was not. */
  const distance = 2.2 * best.pose.distance, isFar = distance > 3.4;
  if (old === before && shown === scene) await fly({ ...best.pose, centre: isFar ? [0, 0, 0] : [...best.pose.centre], distance: isFar ? 3.4 : distance });
}

/* The line goes once over what was changed. */
async function sweep() {
  const mine = ++flights;
  for (const begin = performance.now(); !isCalm() && mine === flights; await new Promise(requestAnimationFrame)) {
    const time = Math.min(1, (performance.now() - begin) / SWEEP);
    setRange("split", Number((50 + 42 * Math.sin(2 * Math.PI * time) * (1 - 0.3 * time)).toFixed(1)));
    dirty.draw = true;
    if (time === 1) return;
  }
}

function fix() {
  const unsafe = isChecked("fix-unsafe");
  return change("fix-facts", "fixed-files", () => remote.fix(source.path, source.name, { unsafe }), ({ changed, model }) => (changed
    ? `Before: ${sum((before ?? scene).model.findings)}. After: ${sum(model.findings)}. The line in the picture divides before from after.` : unsafe ? "Nothing here can be fixed by a program." : "Nothing can be fixed without changing how it looks: tick the box to allow that."),
  ({ model, notes }, changes, first) => {
    const counts = (changes ?? []).reduce((all, one) => Object.fromEntries(Object.entries(one.counts).map(([name, x]) => [name, x + (all[name] ?? 0)])), {}), after = model?.findings ?? first.model.findings, stays = whatStays(after, notes, unsafe);
    listWords("fixed-list", model ? wordsOf(counts, rulesThatFell(first.model.findings, after)) : []);
    listWords("stays", stays);
    byId("stays-box").hidden = !stays.length;
  });
}

/* Per vertex in PLY and per facet in STL there are no creases. */
const computeCopy = () => change("computed-facts", "computed-files",
  () => remote.computeFile(source.path, source.name, { weight: value("weight"), weld: value("weld"), crease: ["PLY", "STL"].includes(scene.model.format) ? null : numberOf("crease") }),
  ({ changed, verticesBefore, verticesAfter, notes }) => (changed ? `Computed${verticesAfter > verticesBefore ? `; ${counted(verticesAfter - verticesBefore, "vertex was", "vertices were")} added at creases` : ""}. The line in the picture divides before from after.` : "The file has these normals already.") + (notes.length ? ` ${notes.join(". ")}.` : ""));

/* ---- computing */

function wanted() {
  if (value("colours") === "error") return "computed";
  return value("shading") === "flat" && value("colours") === "lit" ? "flat" : value("source");
}
const wishes = () => ({ wanted: wanted(), weight: value("weight"), weld: value("weld"), crease: numberOf("crease"), errors: value("colours") === "error" });

async function compute() {
  const options = wishes(), shown = [scene, before].filter(Boolean);
  computing = true;
  dirty.compute = false;
  try {
    for (const one of shown) {
      const { normals, errors } = await remote.compute(one.model.number, options);
      if (one !== scene && one !== before) continue;
      for (const [i, list] of normals.entries()) await graphics.fillSlowly(one.surfaces[i].normals, list);
      if (errors) uploadErrors(one, errors);
      if (wantsTangents(one)) await uploadTangents(one);
    }
    if (scene === shown[0] && value("colours") === "findings") for (const one of shown) await uploadMarks(one, one === scene ? chosen?.index : undefined);
  } catch (error) {
    if (shown[0] === scene) notice(error.message);
  }
  computing = false;
  computed++;
  dirty.draw = true;
  if (shown[0] === scene) warmUp(options);
}

/* Times what was computed once it has been quiet for a while: nothing was warm before. */
async function warmUp(options) {
  const mine = computed, { model } = scene, times = [];
  showComputeFacts(times, model.triangles, options.wanted);
  await new Promise((done) => setTimeout(done, QUIET));
  while (times.length < WARM_RUNS && mine === computed && !dirty.compute && scene?.model === model && options.wanted !== "stored") times.push(await remote.time(model.number, options));
  if (times.length === WARM_RUNS && mine === computed && scene?.model === model) showComputeFacts(times, model.triangles, options.wanted);
}

function uploadErrors(one, { worst, values }) {
  one.surfaces.forEach((surface, i) => {
    if (surface.values) graphics.fillBuffer(surface.values, values[i]);
    else surface.values = graphics.makeBuffer(values[i], graphics.gl.DYNAMIC_DRAW);
  });
  if (one !== scene) return;
  look.errorTop = topOfScale(values, worst);
  look.errorWorst = worst;
}

/* The scale ends where 99 of 100 corners lie below, so that a single bad one does not make all others look right. */
function topOfScale(lists, worst) {
  const sample = [], total = lists.reduce((most, list) => most + list.length, 0), step = Math.max(1, Math.floor(total / 20000));
  for (const list of lists) for (let i = 0; i < list.length; i += step) sample.push(list[i]);
  sample.sort((a, b) => a - b);
  return Math.max(0.01, Math.min(worst, 1.05 * (sample[Math.floor(0.99 * sample.length)] ?? 0)));
}

/* ---- the stage */

const differs = () => !(norma.matrixInfo(modelMatrix()).worstErrorDeg < 0.005);

/* What is compared: nothing while M changes no angle. */
function comparison() {
  if (moving) return "moving";
  if (chosen) return null;
  if (intro.isShown() || differs()) return "matrix";
  return before ? "change" : null;
}

function panelKind(compared) {
  if (!compared) return "right";
  if (intro.isShown()) return "split";
  return compared !== "matrix" && value("sides") === "beside" ? "split" : value("sides");
}

const WORDS = {
  matrix: ["Wrong", "normals through <i>M</i>", "Right", "through the normal matrix"],
  moving: ["Wrong", "normals left as they were", "Right", "normals kept right"],
  change: ["Before", "as the file is", "After", "the changed copy"],
};

/* Words, divider and legend where the panels are. */
function placeStage() {
  const compared = comparison(), kind = panelKind(compared), sides = panels.map(({ side }) => side), angle = panels.find(({ side }) => side === "angle"), colours = value("colours");
  const [left, leftText, right, rightText] = WORDS[compared ?? "matrix"];
  byId("divider").hidden = kind !== "split";
  byId("divider").style.left = `${numberOf("split")}%`;
  byId("side-wrong").hidden = !compared || !sides.includes("wrong");
  byId("side-right").hidden = !compared || !sides.includes("right");
  byId("side-angle").hidden = !angle;
  if (angle) byId("side-angle").style.top = `${angle.box.y - NAME + 6}px`;
  byId("side-wrong-name").textContent = left;
  byId("side-right-name").textContent = right;
  byId("side-wrong").classList.toggle("plain", compared === "change");
  byId("side-right").classList.toggle("plain", compared === "change");
  if (byId("side-wrong-text").innerHTML !== leftText) byId("side-wrong-text").innerHTML = leftText;
  byId("side-right-text").textContent = rightText;
  byId("split").disabled = kind !== "split";
  stage.classList.toggle("beside", Boolean(angle));
  showLegend(colours === "error" ? "error" : colours === "angle" || angle ? "angle" : null);
}

function showLegend(of) {
  byId("legend").hidden = of === null;
  if (of === "error") {
    byId("legend-top").textContent = `${look.errorTop < look.errorWorst ? "≥ " : ""}${degrees(look.errorTop)}`;
    byId("legend-worst").textContent = `worst ${degrees(look.errorWorst ?? 0)}`;
  } else if (of === "angle") {
    byId("legend-top").textContent = `${look.angleTop}°`;
    byId("legend-worst").textContent = "";
  }
}

/* ---- drawing */

function movingItems(side) {
  const surface = scene.surfaces[0];
  return [{ surface, normals: side === "wrong" ? scene.still : surface.normals, localToWorld: IDENTITY, normalMatrix: upper(IDENTITY), mirrored: false, clay: [0.16, 0.42, 0.55], mesh: 0, size: 0.02 }];
}

function sideItems(side, user, compared) {
  if (moving) return movingItems(side);
  return side === "wrong" && compared === "change" ? itemsOf(norma, before, user, "right") : itemsOf(norma, scene, user, side);
}

/* Faces' lines come from the worker, once. */
function faceLinesOf(item) {
  const lines = scene.faces;
  if (lines[item.mesh] === undefined) {
    const shown = scene;
    lines[item.mesh] = null;
    remote.faceLines(shown.model.number, item.mesh).then(({ from, to, lengths }) => {
      lines[item.mesh] = { from: graphics.makeBuffer(from), to: graphics.makeBuffer(to), reach: graphics.makeBuffer(lengths), points: lengths.length };
      dirty.draw = true;
    }, (error) => notice(error.message));
  }
  return lines[item.mesh];
}

const EDGES = { wire: { colour: [0.02, 0.02, 0.02, 0.75], pixels: 1.1 }, seams: { colour: [0.9, 0.1, 0.55, 1], pixels: 2.4 } };
/* Edges, or those at which texture coordinates are cut, come from the worker, once. */
function drawEdges(kind, item, view, pixels, shown) {
  const lines = (shown.edges[kind] ??= []), { colour, pixels: width } = EDGES[kind];
  if (lines[item.mesh] === undefined) {
    lines[item.mesh] = null;
    remote[kind](shown.model.number, item.mesh).then(async ({ from, to, count }) => {
      const made = { from: graphics.reserve(from.byteLength), to: graphics.reserve(to.byteLength), count };
      await graphics.fillSlowly(made.from, from);
      await graphics.fillSlowly(made.to, to);
      lines[item.mesh] = made;
      dirty.draw = true;
    }, (error) => notice(error.message));
  }
  if (lines[item.mesh]?.count) graphics.drawWire(item, view, lines[item.mesh], width * pixels, colour);
}

function drawHedgehog(item, view, pixels, colour) {
  const kind = value("hedgehog");
  if (!kind) return;
  const { surface } = item, common = { colour, pixels, scale: numberOf("line-length") * item.size };
  const lines = moving ? { from: surface.positions, to: item.normals, reachConstant: 1, points: surface.points }
    : kind === "vertex" ? { from: surface.positions, to: item.normals, reach: surface.reach, points: surface.points } : faceLinesOf(item);
  if (lines) graphics.drawHedgehog(item, view, { ...common, ...lines, most: Math.min(MOST_LINES, (numberOf("line-density") / 100) * lines.points) });
}

function drawPanel({ side, box, from, to }, pixels, draw) {
  const part = { x: Math.round(box.x * pixels), y: Math.round((canvas.clientHeight - box.y - box.height) * pixels), width: Math.round(box.width * pixels), height: Math.round(box.height * pixels) };
  const cut = from === undefined ? undefined : { x: Math.round(from * pixels), width: Math.round(to * pixels) - Math.round(from * pixels) };
  camera.aspect = box.width / box.height;
  graphics.within(part, () => draw(side, { worldToView: camera.worldToView(), viewToClip: camera.viewToClip(REACH + Math.abs(moving ? 0 : numberOf("move"))) }), cut);
}

function draw() {
  const pixels = canvas.width / (canvas.clientWidth || 1), user = userMatrix(), compared = comparison();
  const info = norma.matrixInfo(user), colours = isDark() ? COLOURS.dark : COLOURS.light;
  panels = panelsOf(panelKind(compared), canvas.clientWidth, canvas.clientHeight, numberOf("split") / 100);
  look.angleTop = ANGLE_TOPS.find((top) => top >= info.worstErrorDeg - 0.005) ?? 180;
  graphics.clear();
  for (const panel of panels) drawPanel(panel, pixels, (side, view) => {
    /* A scene that plays stands where the model stands. */
    const angle = side === "angle", posed = compared || chosen || moving || value("colours") !== "lit" ? null : animation.root(multiply(multiply(fitOf(user), user), multiply(scene.frame, turning(scene.up))));
    const items = posed ? [] : sideItems(angle ? "right" : side, user, compared), how = { posed, ...look, tinted: compared === "change" && isChecked("tint"), outlineColour: chosen && PIN_COLOURS[chosen.grade], outlineWidth: 3.5 * pixels, materials: isChecked("textures"), normalMaps: isChecked("normal-maps"), colours: angle ? "angle" : value("colours"), shading: value("shading") };
    graphics.drawSurfaces(items, view, how);
    for (const [kind, box] of [["wire", "wireframe"], ["seams", "seams"]]) if (!angle && isChecked(box) && !moving) for (const item of items) drawEdges(kind, item, view, pixels, side === "wrong" && compared === "change" ? before : scene);
    if (!angle) for (const item of items) drawHedgehog(item, view, pixels, compared === "change" ? colours.before : colours[side]);
    if (!moving) drawChosen(view, pixels);
    if (found && !chosen && compared && compared !== "change" && !angle && !intro.isShown()) drawFound(view, pixels, colours);
  });
  const inCorner = Boolean(chosen && (look.place || look.outline) && value("colours") === "findings");
  byId("whole").hidden = !inCorner;
  if (inCorner) drawCorner(pixels, (view) => graphics.drawSurfaces(sideItems("right", user, null), view, { ...UNMARKED, outline: look.outline, outlineColour: chosen && PIN_COLOURS[chosen.grade], outlineWidth: 2 * pixels, materials: isChecked("textures"), normalMaps: false, colours: "lit", shading: "phong" }));
  placeStage();
  showReadouts(info, user, compared);
  remember();
}

/* The two normals at the cursor. */
function drawFound(view, pixels, colours) {
  const tip = (direction) => found.point.map((x, i) => x + 0.3 * direction[i]), arrow = (kind) => ({ from: found.point, to: tip(found[kind]), colour: colours[kind] });
  graphics.drawArrows(degreesBetween(found.wrong, found.right) < 0.05 ? [arrow("right")] : [arrow("wrong"), arrow("right")], view, pixels);
}

/* ---- what lies under the cursor */

/* The ray under it, through the panel that it is in. */
function cursorRay() {
  if (!cursor) return null;
  const seen = cursor.itself ? { panel: panels.find(({ side }) => side === "right") ?? panels[0], x: 0.08, y: 0.12 } : panelAt(panels, cursor.x * canvas.clientWidth, cursor.y * canvas.clientHeight);
  if (!seen) return null;
  camera.aspect = seen.panel.box.width / seen.panel.box.height;
  return camera.ray(seen.x, seen.y);
}

/* Asks the worker, unless it was asked the same before. */
async function pick(user) {
  const ray = cursorRay(), shown = scene, key = [user, shown.model.number, computed, ray ? [...ray.from, ...ray.along] : ""].join();
  if (picking || shown.picked === key) return;
  shown.picked = key;
  picking = true;
  try {
    const items = ray ? itemsOf(norma, shown, user, "right") : [], rays = [];
    for (const item of items) {
      const inverse = invert(item.localToWorld);
      if (inverse) rays.push({ mesh: item.mesh, from: point(inverse, ray.from), along: apply3(upper(inverse), ray.along), item });
    }
    const hit = rays.length ? await remote.pick(shown.model.number, rays.map(({ mesh, from, along }) => ({ mesh, from, along }))) : null;
    if (shown === scene) found = hit && hitOf(hit, rays[hit.ray].item, ray);
  } catch { found = null; }
  picking = false;
  dirty.draw = true;
}

function hitOf({ at, weights, normals }, item, ray) {
  const normal = [0, 1, 2].map((i) => weights[0] * normals[i] + weights[1] * normals[3 + i] + weights[2] * normals[6 + i]);
  return { point: ray.from.map((x, i) => x + at * ray.along[i]), normal, right: unit(apply3(item.right, normal)), wrong: unit(apply3(item.plain, normal)) };
}

function pickMoving() {
  const ray = cursorRay(), at = ray && pointOnPlane(ray), hit = at && moving.at(at[0], at[2]);
  found = hit && { point: hit.point, right: hit.normal, wrong: [0, 1, 0] };
}

function pointOnPlane({ from, along }) {
  const at = -from[1] / along[1];
  return at > 0 && isFinite(at) ? from.map((x, i) => x + at * along[i]) : null;
}

/* ---- numbers */

/* By how much the normals of this model err, from the worker. */
async function measure(user) {
  const shown = scene, key = [...user, computed].join();
  if (measuring || shown.worstKey === key || intro.isPlaying()) return;
  shown.worstKey = key;
  measuring = true;
  const items = itemsOf(norma, shown, user, "right").map(({ mesh, plain, right }) => ({ mesh, plain, right }));
  shown.worst = await remote.worst(shown.model.number, items).catch(() => null);
  measuring = false;
  dirty.draw = true;
}

let saying = null;
/* To those who listen, once it stands still. */
function say(text) {
  clearTimeout(saying);
  if (!intro.isPlaying()) saying = setTimeout(() => { if (byId("said").textContent !== text) byId("said").textContent = text; }, 900);
}

function showReadouts(info, user, compared) {
  /* Of a file that is at rest, there is nothing of the lesson. */
  byId("worst-box").hidden = byId("under-box").hidden = Boolean(scene.model?.format) && compared !== "matrix";
  if (moving) {
    pickMoving();
    byId("worst").textContent = degrees(moving.worst());
    byId("under").textContent = found ? degrees(degreesBetween(found.wrong, found.right)) : "–";
    return;
  }
  byId("under").textContent = found && cursor ? degrees(degreesBetween(found.wrong, found.right)) : "–";
  byId("readouts").hidden = false;
  byId("worst-label").textContent = intro.isShown() ? "Wrong by up to" : "Worst angle possible";
  byId("worst").textContent = degrees(info.worstErrorDeg);
  if (compared === "matrix") say(`Worst angle ${degrees(info.worstErrorDeg)}`);
  showMatrix("matrix-plain", upper(user));
  showMatrix("matrix-normal", norma.normalMatrix(user));
  showMatrixFacts(info, scene.worst ?? null);
  if (byId("lesson").open) showFormula(upper(user), Array.from(norma.normalMatrix(user)), found?.normal);
  pick(user);
  measure(user);
}

/* ---- the loop */

function uploadMoving() {
  graphics.fillBuffer(scene.surfaces[0].positions, moving.positions());
  graphics.fillBuffer(scene.surfaces[0].normals, moving.normals());
}

function moveOn(now) {
  const seconds = timer.last ? Math.min(0.05, (now - timer.last) / 1000) : 0.016;
  if (timer.last) timer.frames = timer.frames * 0.9 + (1000 / Math.max(1, now - timer.last)) * 0.1;
  timer.last = now;
  if (isChecked("waves")) {
    const took = moving.wave(seconds, numberOf("height"));
    uploadMoving();
    showMovingFacts(took, moving.touched(), timer.frames);
    dirty.draw = true;
  }
}

function resize() {
  const ratio = Math.min(2, devicePixelRatio || 1), width = Math.max(1, Math.round(canvas.clientWidth * ratio)), height = Math.max(1, Math.round(canvas.clientHeight * ratio));
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
    dirty.draw = true;
  }
}

/* Whether something is still to come, for those who wait. */
function showBusy() {
  const busy = calls > 0 || computing || picking || measuring || loading > 0 || seeking > 0 || dirty.compute || (!animation.isPlaying() && (drawing || dirty.draw)) ? "1" : "";
  if (document.body.dataset.busy !== busy) document.body.dataset.busy = busy;
}

function frame(now) {
  requestAnimationFrame(frame);
  if (graphics.gl.isContextLost() || !scene) { showBusy(); return; }
  try {
    resize();
    intro.tick(now);
    animation.tick(now);
    if (moving) { moveOn(now); dirty.compute = false; }
    else if (dirty.compute && !computing) compute();
    if (dirty.draw && (moving || computed) && !drawing) {
      dirty.draw = false;
      draw();
      drawing = true;
      graphics.drained().catch(() => undefined).then(() => { drawing = false; });
      document.body.dataset.drawn = String(Number(document.body.dataset.drawn ?? 0) + 1);
    }
  } catch (error) {
    notice(error.message);
    dirty = { compute: false, draw: false };
  }
  showBusy();
}

/* ---- files */

async function openGiven(given) {
  notice("");
  atFirst = null;
  stopIntro();
  if (!given.length) return;
  try {
    const { files, models } = await gather(given);
    addFileOptions(files, models);
    openFile(files, models[0]);
  } catch (error) {
    notice(error.message);
  }
}

function openFile(files, path) {
  return show(async () => {
    const needed = await bytesFor(files, path), name = path.split("/").pop(), model = await remote.openFiles(needed.files, needed.path, name);
    model.files = needed;
    model.source = { path: needed.path, name };
    return model;
  }, (model) => {
    source = model.source;
    for (const id of ["fix-facts", "computed-facts", "fixed-list", "stays"]) byId(id).textContent = "";
    byId("stays-box").hidden = byId("tint-row").hidden = true;
    for (const id of ["fixed-files", "computed-files"]) listFiles(id, []);
    setMatrix();
    if (value("sides") === "beside") byId("sides").value = "split";
    byId("colours").value = "lit";
    setRange("crease", 60);
    camera.reset();
    document.title = `${source.name} · Norma`;
    byId("model").title = byId("model").selectedOptions[0].textContent;
    showSections();
  });
}

/* The model of norma view: drawn from its pack; what may be fixed is its file, where the page holds that. */
function openEmbedded() {
  const { text, name, files } = embedded;
  return show(async () => {
    if (files) await remote.giveFiles(files.files);
    return { ...(await remote.openText(text, name)), files };
  }, () => {
    source = files && { path: files.path, name };
    showSections();
  });
}

let fileChoices = [];
function addFileOptions(files, models) {
  const select = byId("model");
  select.querySelectorAll('[value^="file"]').forEach((old) => old.remove());
  fileChoices = models.map((path) => ({ files, path }));
  models.slice().reverse().forEach((path, i) => select.prepend(new Option(models.length > 1 ? path : path.split("/").pop(), `file${models.length - 1 - i}`)));
  select.value = "file0";
}

/* What is shown now is not the file that was chosen before. */
function forgetChosen() { byId("file").value = byId("folder").value = ""; }

const VIEWS = { moving: { azimuth: 20, elevation: 34, distance: 3.3 }, sculpture: { azimuth: 24, elevation: 10, distance: 2.2 } };
let embedded = null;
function pickModel() {
  const key = value("model");
  byId("model").title = "";
  notice("");
  if (!key.startsWith("file")) { forgetChosen(); source = null; byId("model").querySelectorAll('[value^="file"]').forEach((old) => old.remove()); }
  if (key === "moving") showMoving();
  else if (key === "embedded") openEmbedded();
  else if (key === "sculpture") show(() => remote.openTriangles({ ...sculpture, positions: sculpture.positions.slice(), indices: sculpture.indices.slice() }), () => setRange("crease", 180));
  else if (key.startsWith("file")) { const { files, path } = fileChoices[Number(key.slice(4))]; openFile(files, path); }
  else if (SHAPES[key]) show(() => remote.openShape(key), () => setRange("crease", SHAPES[key].crease ?? 60));
  camera.reset(VIEWS[key] ?? {});
}

/* ---- wiring */

/* Whoever does something has seen enough of the first seconds. */
function stopIntro() {
  if (!intro.isShown()) return;
  intro.end();
  cursor = DEFAULT_CURSOR;
  dirty.draw = true;
}

function brushAt(event) {
  if (!moving || !isChecked("brush")) return false;
  if (event) placeCursor(event);
  const ray = event ? cursorRay() : camera.ray(0, 0), at = ray && pointOnPlane(ray);
  if (!at || !moving.at(at[0], at[2])) return false;
  const took = moving.push(at[0], at[2]);
  uploadMoving();
  showMovingFacts(took, moving.touched(), 0);
  dirty.draw = true;
  return true;
}

function placeCursor(event) {
  const box = canvas.getBoundingClientRect();
  cursor = { x: (event.clientX - box.left) / box.width, y: (event.clientY - box.top) / box.height };
}

function wireCanvas() {
  steer(canvas, camera, {
    changed: () => { flights++; intro.pause(); dirty.draw = true; },
    hover: (event) => { if (event) placeCursor(event); else cursor = DEFAULT_CURSOR; dirty.draw = true; },
    taken: (event, phase) => (phase === "up" ? true : brushAt(event)),
  });
  canvas.addEventListener("keydown", (event) => {
    if (event.key === " " && moving) { brushAt(null); event.preventDefault(); }
  });
  canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
  canvas.addEventListener("webglcontextrestored", () => location.reload());
  new ResizeObserver(() => { dirty.draw = true; }).observe(canvas);
}

/* The divider is dragged wherever on its line it is taken. */
function wireDivider() {
  const divider = byId("divider");
  divider.addEventListener("pointerdown", (event) => { flights++; divider.setPointerCapture(event.pointerId); event.preventDefault(); });
  divider.addEventListener("pointermove", (event) => {
    if (!divider.hasPointerCapture(event.pointerId)) return;
    const box = stage.getBoundingClientRect();
    setRange("split", Math.max(0, Math.min(100, (100 * (event.clientX - box.left)) / box.width)));
    dirty.draw = true;
  });
}

const RECOMPUTED = new Set(["source", "crease", "weight", "weld", "shading", "colours", "normal-maps"]);
/* Who turns these wants to see what they do. */
const OF_COMPUTED = new Set(["crease", "weight", "weld"]);

function controlChanged(control) {
  if (control.id in MATRIX || control.id === "sides") stopIntro();
  if (RANGES.includes(control.id)) spell(control.id);
  if (OF_COMPUTED.has(control.id)) byId("source").value = "computed";
  if (RECOMPUTED.has(control.id)) dirty.compute = true;
  if (control.id === "colours") letGo();
  if (control.id === "up") turnUp();
  canvas.classList.toggle("brush", moving !== null && isChecked("brush"));
  dirty.draw = true;
}

function turnUp() {
  if (!scene?.place) return;
  letGo();
  before?.place(value("up"));
  scene.place(value("up"), before?.frame);
  scene.worstKey = scene.picked = null;
  byId("up-facts").textContent = "";
}

/* No finding is chosen any more. */
function letGo() {
  chosen = null;
  flights++;
  look = { ...look, ...UNMARKED };
  byId("places").hidden = true;
  byId("finding-seen").textContent = "";
  releaseFindings();
}

/* What a saved picture says. */
const shownNow = () => [panels, { title: document.title, words: WORDS[comparison() ?? "matrix"], compared: comparison() !== null, angle: byId("worst").textContent }];

/* Once round the model; the line sweeps to and fro meanwhile, where there is one. */
async function turnOnce() {
  const button = byId("save-turntable"), name = button.textContent, from = camera.azimuth, split = value("split");
  stopIntro();
  button.disabled = true;
  try {
    await saveTurntable(canvas, shownNow, (part) => {
      camera.azimuth = from + 360 * part;
      if (!byId("divider").hidden) setRange("split", 50 + 40 * Math.sin(2 * Math.PI * part));
      draw();
    }, (part) => { button.textContent = part < 1 ? `Recording, ${Math.floor(100 * part)} %` : name; });
  } catch (error) {
    notice(error.message);
  } finally {
    Object.assign(button, { disabled: false, textContent: name });
    camera.azimuth = from;
    setRange("split", split);
    dirty.draw = true;
  }
}

function wireControls() {
  for (const control of document.querySelectorAll("#panel input:not([type=file]), #panel select:not(#model)")) {
    control.addEventListener("input", () => controlChanged(control));
    control.addEventListener("change", () => controlChanged(control));
  }
  byId("model").addEventListener("change", () => { stopIntro(); pickModel(); });
  for (const id of ["file", "folder"]) byId(id).addEventListener("change", () => openGiven(filesOfInput(byId(id))));
  const onClick = (id, act) => byId(id).addEventListener("click", () => { act(); dirty.draw = true; });
  onClick("reset-matrix", () => { stopIntro(); setMatrix(); });
  onClick("reset-view", () => camera.reset(moving ? { azimuth: 0, elevation: 34, distance: 3.3 } : { azimuth: 0, elevation: 0 }));
  onClick("flatten", () => { if (moving) { moving.flatten(); uploadMoving(); } });
  onClick("intro-open", () => byId("file").click());
  onClick("intro-more", stopIntro);
  onClick("fix", fix);
  onClick("compute", computeCopy);
  onClick("save-picture", () => { draw(); savePicture(canvas, shownNow); });
  onClick("save-turntable", turnOnce);
  byId("lesson").addEventListener("toggle", () => { dirty.draw = true; });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { dirty.draw = true; });
}

function wireLesson() {
  STEPS.forEach(({ title, matrix, words }, i) => {
    const button = document.createElement("button");
    button.type = "button";
    button.id = `step-${i + 1}`;
    button.textContent = `${i + 1} ${title}`;
    button.addEventListener("click", () => {
      stopIntro();
      setMatrix(matrix);
      byId("step-words").textContent = words;
      dirty.draw = true;
    });
    byId("steps").append(button);
  });
}

function wireDrop() {
  const drop = byId("drop");
  const hasFile = (event) => [...(event.dataTransfer?.types ?? [])].includes("Files");
  addEventListener("dragover", (event) => { if (hasFile(event)) { event.preventDefault(); drop.hidden = false; } });
  addEventListener("dragleave", (event) => { if (!event.relatedTarget) drop.hidden = true; });
  addEventListener("drop", (event) => {
    event.preventDefault();
    drop.hidden = true;
    forgetChosen();
    filesOfDrop(event.dataTransfer).then((given) => (given.length ? openGiven(given) : notice(`That is no file. Drop ${EXPECTED}.`)), (error) => notice(error.message));
  });
}

/* ---- start */

function textOf(id) {
  const text = byId(id).textContent;
  byId(id).textContent = "";
  return text;
}
function fallBack(reason) {
  byId("fallback").hidden = false;
  byId("fallback-reason").textContent = reason;
  for (const id of ["readouts", "divider", "side-wrong", "side-right", "intro"]) byId(id).hidden = true;
}

function fillModels() {
  const select = byId("model");
  if (sculpture) select.append(new Option(sculpture.name, "sculpture"));
  for (const [key, { title }] of Object.entries(SHAPES)) select.append(new Option(title, key));
  select.append(new Option("A surface that moves", "moving"));
  byId("model-credit").textContent = CREDIT;
}

/* The files that norma view put into the page: paths and bytes in base64, the one that is shown first. */
function filesIn(text) {
  const files = text.split("\n").filter(Boolean).map((line) => line.split(" ")).map(([path, bytes]) => ({ path: new TextDecoder().decode(bytesOf(path)), bytes: bytesOf(bytes) }));
  return files.length ? { files, path: files[0].path } : null;
}

/* The colour scale of surface.frag, for its legend. */
function paintLegend(texts) {
  const stops = [...texts["colour.glsl"].matchAll(/vec3\((0\.\d+), (0\.\d+), (0\.\d+)\)[,)]/g)].map((match) => match.slice(1, 4).map((x) => Math.round(255 * Number(x))));
  byId("legend-bar").style.background = `linear-gradient(90deg, ${stops.map((stop) => `rgb(${stop.join(" ")})`).join(", ")})`;
}

async function startEngines() {
  const bytes = await moduleOf(textOf("wasm")), modules = { bytes, draco: textOf("draco") };
  const [{ instance }, started] = await Promise.all([WebAssembly.instantiate(bytes, noDecoders), startRemote(textOf("worker"), modules, (now) => { calls = now; })]);
  norma = bindCalls(instance.exports);
  remote = started;
}

/* What somebody has opened meanwhile stays. */
function openServed(path) {
  const mine = ++opening, asked = atFirst;
  filesServed(path).then((files) => {
    if (mine !== opening) return;
    openGiven(files);
    atFirst = asked;
  }, (error) => {
    if (mine !== opening) return;
    pickModel();
    notice(error.message);
  });
}

/* What is shown first: what the address asks for, the model of norma view, or the sculpture. */
function showFirst(asked) {
  const wantedModel = asked?.get("model"), known = wantedModel && option("model", CSS.escape(wantedModel));
  const path = embedded ? null : servedPath();
  if (known) byId("model").value = wantedModel;
  atFirst = asked;
  if (path) openServed(path);
  else pickModel();
  if (!embedded && !asked && !path && value("model") === "sculpture") intro.begin(!isCalm());
  if (asked) applyAddress(asked, camera);
  if (asked?.has("crease")) { const crease = asked.get("crease"), later = () => (computed ? setRange("crease", crease) : setTimeout(later, 30)); later(); }
}

export async function startPage(texts) {
  RANGES.forEach(spell);
  graphics = makeGraphics(canvas, texts);
  if (!graphics) { fallBack(""); return; }
  await startEngines();
  thumbs = makeThumbs(graphics, remote, seenSmall, () => !(computing || picking || measuring || loading || seeking || dirty.compute || intro.isPlaying()) && (animation.isPlaying() || !(drawing || dirty.draw)) && computed > 0);
  byId("version").textContent = norma.version;
  sculpture = unpackSculpture(bytesOf(textOf("sculpture")));
  paintLegend(texts);
  fillModels();
  animation = makeAnimation(() => { dirty.draw = true; }, isCalm);
  intro = makeIntro(() => { dirty.draw = true; });
  wireCanvas();
  wireDivider();
  wireControls();
  wireLesson();
  wireDrop();
  if (isCalm()) byId("waves").checked = false;
  const pack = textOf("pack");
  if (pack) {
    embedded = { text: pack, name: byId("pack").dataset.name, files: filesIn(textOf("files")) };
    byId("model").prepend(new Option(embedded.name, "embedded"));
    byId("model").value = "embedded";
    document.title = `${embedded.name} · Norma`;
  }
  const asked = readAddress();
  const kept = makeAddress(camera, () => chosen && keyOf(chosen));
  showFirst(asked);
  remember = () => { if (!intro.isPlaying() && !intro.isShown()) kept(); };
  requestAnimationFrame(frame);
  graphics.warmUp().catch((error) => notice(error.message));
}

startPage(SHADERS).catch((error) => fallBack(error.message));
