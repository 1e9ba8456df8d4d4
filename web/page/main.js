/* The page: what its controls say is computed and drawn. Nothing is drawn but when something changed; what moves, moves by itself. */
import { makeCamera, steer } from "./camera.js";
import { packTriangles, startEngine } from "./engine.js";
import { listFindings, releaseFindings } from "./findings.js";
import { makeGraphics } from "./graphics.js";
import { apply3, degreesBetween, IDENTITY, invert, length, multiply, point, scaling, translation, unit, upper } from "./matrix.js";
import { makeMoving } from "./moving.js";
import { degrees, notice, showComputeFacts, showMatrix, showMatrixFacts, showModelFacts, showMovingFacts } from "./readouts.js";
import { SHAPES } from "./shapes.js";

const byId = (id) => document.getElementById(id);
const canvas = byId("canvas"), stage = byId("stage");
const camera = makeCamera();
const WRONG = [0.75, 0.03, 0.02, 1], RIGHT = [0.02, 0.45, 0.12, 1];
const MOST_LINES = 60000;
const DEFAULT_CURSOR = { x: 0.08, y: 0.12 };

let engine, graphics, scene = null, moving = null, embedded = null, chosen = null;
let cursor = DEFAULT_CURSOR, errorTop = 1, dirty = { compute: true, draw: true }, timer = { last: 0, frames: 0 };

const isDark = () => matchMedia("(prefers-color-scheme: dark)").matches;

/* ---- controls */

const value = (id) => byId(id).value;
const numberOf = (id) => Number(byId(id).value);
const SPELLED = { crease: (x) => `${x}°`, split: (x) => `${x} %` };
const RANGES = ["scale-x", "scale-y", "scale-z", "shear", "split", "crease", "height"];

function setRange(id, to) {
  byId(id).value = to;
  spell(id);
}
function spell(id) { byId(`${id}-value`).textContent = SPELLED[id] ? SPELLED[id](numberOf(id)) : numberOf(id).toFixed(2); }

/* M: mirror, then shear, then scales. */
function modelMatrix() {
  const mirror = value("mirror"), sign = (axis) => (mirror === axis ? -1 : 1);
  const shear = [...IDENTITY];
  shear[4] = numberOf("shear");
  return multiply(scaling(numberOf("scale-x"), numberOf("scale-y"), numberOf("scale-z")), multiply(shear, scaling(sign("x"), sign("y"), sign("z"))));
}

/* ---- scenes */

const largestOf = (list, measure) => list.reduce((most, element) => Math.max(most, measure(element)), -Infinity);
const largestColumn = (m) => Math.max(length(m.slice(0, 3)), length(m.slice(4, 7)), length(m.slice(8, 11)));
const meanColumn = (m) => (length(m.slice(0, 3)) + length(m.slice(4, 7)) + length(m.slice(8, 11))) / 3;

/* The whole of a model in the unit ball: the middle of the box round the balls of what is drawn, and how far from it they reach. */
function frameOf(model) {
  const balls = model.draws.map(({ mesh, world }) => ({ centre: point(world, model.meshes[mesh].ball), radius: model.meshes[mesh].ball[3] * largestColumn(world) }));
  const most = (sign) => [0, 1, 2].map((i) => largestOf(balls, ({ centre, radius }) => sign * centre[i] + radius));
  const high = most(1), low = most(-1).map((x) => -x), middle = high.map((x, i) => (x + low[i]) / 2);
  const radius = largestOf(balls, (ball) => length(ball.centre.map((x, i) => x - middle[i])) + ball.radius);
  if (!isFinite(radius)) return IDENTITY;
  const scale = 1 / (radius || 1);
  return multiply(scaling(scale, scale, scale), translation(...middle.map((x) => -x)));
}

function showModel(model, keep) {
  if (scene?.model && scene.model !== model && scene.model !== keep) scene.model.free();
  scene?.surfaces?.forEach((surface) => surface.free());
  const frame = frameOf(model);
  scene = {
    model, frame,
    surfaces: model.meshes.map((mesh) => graphics.makeSurface({ positions: mesh.positions(), normals: mesh.normals(), reach: mesh.reach() })),
    faces: [],
    draws: model.draws.map(({ mesh, world }) => {
      const [x, y, z, radius] = model.meshes[mesh].ball;
      return { mesh, world, local: multiply(multiply(frame, world), multiply(translation(x, y, z), scaling(radius, radius, radius))) };
    }),
  };
  moving?.free();
  moving = null;
  const stored = model.meshes.some((mesh) => mesh.stored);
  byId("source").querySelector('[value="stored"]').disabled = !stored;
  byId("colours").querySelector('[value="error"]').disabled = !stored;
  byId("source").value = stored ? "stored" : "computed";
  chosen = null;
  listFindings(model.findings, chooseFinding);
  byId("colours").querySelector('[value="findings"]').disabled = !model.findings?.length;
  if (!model.findings?.length && value("colours") === "findings") byId("colours").value = "lit";
  if (!stored && value("colours") === "error") byId("colours").value = "lit";
  showModelFacts(model);
  showSections();
  dirty.compute = dirty.draw = true;
}

function showShape(name) {
  const shape = SHAPES[name], { positions, indices } = shape.make();
  showModel(engine.openBytes(packTriangles(positions, indices, shape.colour), shape.title));
  setRange("crease", shape.crease ?? 60);
}

function showMoving() {
  scene?.model?.free();
  scene?.surfaces?.forEach((surface) => surface.free());
  moving?.free();
  moving = makeMoving(engine.norma);
  const surface = graphics.makeSurface({ positions: moving.positions(), normals: moving.normals(), indices: moving.indices });
  scene = { model: null, surfaces: [surface], still: graphics.makeBuffer(moving.still), frame: IDENTITY };
  byId("model-facts").textContent = `${moving.triangles.toLocaleString("en-US")} triangles, made anew for every picture.`;
  if (["error", "findings"].includes(value("colours"))) byId("colours").value = "lit";
  if (value("shading") === "flat") byId("shading").value = "phong";
  chosen = null;
  listFindings(null);
  moving.wave(0, numberOf("height"));
  uploadMoving();
  showSections();
  dirty.draw = true;
}

function showSections() {
  const live = moving !== null;
  byId("matrix-section").hidden = byId("normals-section").hidden = live;
  byId("moving-section").hidden = !live;
  byId("shading").querySelector('[value="flat"]').disabled = live;
  byId("hedgehog").querySelector('[value="face"]').disabled = live;
  if (live) for (const kind of ["error", "findings"]) byId("colours").querySelector(`[value="${kind}"]`).disabled = true;
  byId("side-wrong-text").innerHTML = live ? "normals left as they were" : "normals through <i>M</i>";
  byId("side-right-text").textContent = live ? "normals kept right" : "through the normal matrix";
  canvas.classList.toggle("brush", live && byId("brush").checked);
}

/* ---- findings */

/* The finding's mesh where it is drawn, and its place there. */
function placeOf(finding) {
  const place = finding.mesh >= 0 && scene.model.placeOf(finding.index), draw = scene.draws[finding.draw] ?? scene.draws.find(({ mesh }) => mesh === finding.mesh);
  if (!place || !draw) return null;
  const user = modelMatrix(), toWorld = multiply(fitOf(user), multiply(user, draw.local)), at = point(toWorld, place.point);
  let normal = place.direction;
  try { normal = apply3(Array.from(engine.norma.normalMatrix(toWorld)), place.direction); } catch { /* a node that is not finite */ }
  return { at, normal: length(normal) > 0 ? unit(normal) : camera.axes().back, size: place.size * meanColumn(toWorld) };
}

/* Looks at its place along the normals there, from two dozen times as far as its edges are long; what has no place, or is nearly everywhere, is looked at as a whole. */
function goTo(finding) {
  const place = placeOf(finding), everywhere = finding.mesh >= 0 && finding.places > scene.model.meshes[finding.mesh].faces / 2;
  if (!place || everywhere) { camera.reset(); return; }
  const start = (side) => place.at.map((x, i) => x + 0.02 * side * place.size * place.normal[i]);
  const [front, behind] = [1, -1].map((side) => freeFrom(start(side), place.normal.map((x) => side * x)));
  /* Within a hollow the other side may be the one that is seen. */
  const side = behind > front ? -1 : 1, free = Math.max(front, behind);
  const back = unit(place.normal.map((x) => side * x).map((x, i) => x + 0.35 * camera.axes().up[i] * (Math.abs(x) < 0.9 ? 1 : 0)));
  camera.reset({ azimuth: (Math.atan2(back[0], back[2]) * 180) / Math.PI, elevation: (Math.asin(Math.max(-1, Math.min(1, back[1]))) * 180) / Math.PI,
                 distance: Math.max(0.15, Math.min(3.4, 24 * place.size, 0.9 * free)) });
  camera.centre.splice(0, 3, ...place.at);
}

/* How far one sees from a place before something stands in the way; there may be nothing. */
function freeFrom(from, along) {
  const user = modelMatrix(), ahead = scene.draws.map(({ mesh, local }) => {
    const inverse = invert(multiply(fitOf(user), multiply(user, local)));
    return (inverse && scene.model.pick(mesh, point(inverse, from), apply3(upper(inverse), along)))?.at ?? Infinity;
  });
  return Math.min(...ahead);
}

function chooseFinding(finding) {
  chosen = finding;
  byId("colours").value = "findings";
  if (finding) {
    byId("sides").value = "right";      /* the divider would stand in front of the place */
    goTo(finding);
  }
  placeDivider();
  dirty.compute = dirty.draw = true;
}

function uploadMarks() {
  scene.model.meshes.forEach((mesh, i) => {
    const surface = scene.surfaces[i], marks = scene.model.marks(i, chosen?.index);
    if (surface.marks) graphics.fillBuffer(surface.marks, marks);
    else surface.marks = graphics.makeBuffer(marks, graphics.gl.DYNAMIC_DRAW);
  });
}

/* An arrow that points at the place of the finding that is chosen. */
function drawChosen(view, pixels) {
  const place = value("colours") === "findings" && chosen && placeOf(chosen), reach = 0.09 * camera.distance, { right, up } = camera.axes();
  if (place) graphics.drawArrows([{ from: place.at.map((x, i) => x + reach * (place.normal[i] + right[i] + up[i])), to: place.at, colour: isDark() ? [1, 1, 1, 1] : [0, 0, 0, 1] }], view, pixels);
}

/* ---- computing */

function wanted() {
  if (value("colours") === "error") return "computed";
  return value("shading") === "flat" && ["lit", "findings"].includes(value("colours")) ? "flat" : value("source");
}

function compute() {
  const options = { wanted: wanted(), weight: value("weight"), weld: value("weld"), crease: numberOf("crease") };
  const { model } = scene, begin = performance.now();
  /* What is stored per facet is held against the facet's own direction. */
  const wantedOf = (mesh) => (value("colours") === "error" && mesh.stored === "per facet" ? "flat" : options.wanted);
  model.meshes.forEach((mesh, i) => model.compute(i, { ...options, wanted: wantedOf(mesh) }));
  const took = performance.now() - begin;
  model.meshes.forEach((mesh, i) => graphics.fillBuffer(scene.surfaces[i].normals, mesh.normals()));
  if (value("colours") === "error") uploadErrors();
  if (value("colours") === "findings") uploadMarks();
  showComputeFacts(took, model.triangles, options.wanted);
}

function uploadErrors() {
  let worst = 0;
  scene.model.meshes.forEach((mesh, i) => {
    const surface = scene.surfaces[i], here = scene.model.errors(i);
    if (here !== null) worst = Math.max(worst, here);
    if (surface.values) graphics.fillBuffer(surface.values, mesh.values());
    else surface.values = graphics.makeBuffer(mesh.values(), graphics.gl.DYNAMIC_DRAW);
  });
  errorTop = topOfScale(scene.model.meshes.map((mesh) => mesh.values()), worst);
  byId("legend-top").textContent = `${errorTop < worst ? "≥ " : ""}${degrees(errorTop)}`;
  byId("legend-worst").textContent = `worst ${degrees(worst)}`;
}

/* The scale ends where 99 of 100 corners lie below, so that a single bad one does not make all others look right. */
function topOfScale(lists, worst) {
  const sample = [], total = lists.reduce((sum, list) => sum + list.length, 0), step = Math.max(1, Math.floor(total / 20000));
  for (const list of lists) for (let i = 0; i < list.length; i += step) sample.push(list[i]);
  sample.sort((a, b) => a - b);
  return Math.max(0.01, Math.min(worst, 1.05 * (sample[Math.floor(0.99 * sample.length)] ?? 0)));
}

/* Points and normals of faces, for their hedgehog. */
function faceLines(index) {
  const mesh = scene.model.meshes[index], positions = mesh.positions(), reach = mesh.reach(), triangles = mesh.triangles;
  const from = new Float32Array(3 * triangles), to = new Float32Array(3 * triangles), length_ = new Float32Array(triangles);
  const normals = engine.norma.faceNormals(positions);
  for (let t = 0; t < triangles; t++) {
    for (let i = 0; i < 3; i++) from[3 * t + i] = (positions[9 * t + i] + positions[9 * t + 3 + i] + positions[9 * t + 6 + i]) / 3;
    length_[t] = (reach[3 * t] + reach[3 * t + 1] + reach[3 * t + 2]) / 3;
  }
  to.set(normals);
  return { from: graphics.makeBuffer(from), to: graphics.makeBuffer(to), reach: graphics.makeBuffer(length_), points: triangles };
}

/* ---- drawing */

/* What is drawn on one side: each with its matrices. */
function itemsOf(user, fit, side) {
  if (moving) {
    const surface = scene.surfaces[0];
    return [{ surface, normals: side === "wrong" ? scene.still : surface.normals, localToWorld: IDENTITY, normalMatrix: upper(IDENTITY), mirrored: false, colour: [0.16, 0.42, 0.55], mesh: 0, size: 0.02 }];
  }
  return scene.draws.map(({ mesh, world, local }) => {
    const through = multiply(user, world), plain = upper(through);
    let right = plain;
    try { right = Array.from(engine.norma.normalMatrix(through)); } catch { /* a node that is not finite: nothing is right there */ }
    return { surface: scene.surfaces[mesh], normals: scene.surfaces[mesh].normals, localToWorld: multiply(fit, multiply(user, local)), normalMatrix: side === "wrong" ? plain : right,
             plain, right, mirrored: determinant(plain) < 0, colour: scene.model.meshes[mesh].colour.slice(0, 3), mesh, size: meanColumn(local) * fit[0] };
  });
}
const determinant = (m) => m[0] * (m[4] * m[8] - m[5] * m[7]) + m[3] * (m[7] * m[2] - m[8] * m[1]) + m[6] * (m[1] * m[5] - m[2] * m[4]);

/* A large scale is shown smaller as a whole, so that the model stays in the picture: that turns no normal. By how far the matrix takes a ball, and a little by how far a cube: most models are neither. */
function fitOf(user) {
  const signs = [[1, 1, 1], [1, 1, -1], [1, -1, 1], [-1, 1, 1]], cube = Math.max(...signs.map((corner) => length(apply3(upper(user), corner)))) / Math.sqrt(3);
  const scale = 1 / Math.max(1, (cube + 3 * largestColumn(user)) / 4);
  return scaling(scale, scale, scale);
}

function drawHedgehog(item, view, pixels, colour) {
  const kind = value("hedgehog");
  if (!kind) return;
  const { surface } = item, common = { colour, pixels, most: MOST_LINES, scale: item.size };
  if (moving) graphics.drawHedgehog(item, view, { ...common, from: surface.positions, to: item.normals, reachConstant: 1, points: surface.points });
  else if (kind === "vertex") graphics.drawHedgehog(item, view, { ...common, from: surface.positions, to: item.normals, reach: surface.reach, points: surface.points });
  else graphics.drawHedgehog(item, view, { ...common, ...(scene.faces[item.mesh] ??= faceLines(item.mesh)) });
}

function draw() {
  const pixels = canvas.width / (canvas.clientWidth || 1);
  const user = moving ? IDENTITY : modelMatrix(), fit = fitOf(user);
  camera.aspect = canvas.width / canvas.height;
  const view = { worldToView: camera.worldToView(), viewToClip: camera.viewToClip(2.2) };
  const look = { colours: value("colours"), shading: value("shading"), errorTop };
  const sides = value("sides"), middle = Math.round(canvas.width * (sides === "split" ? numberOf("split") / 100 : sides === "wrong" ? 1 : 0));
  const right = itemsOf(user, fit, "right"), wrong = itemsOf(user, fit, "wrong");
  const lineColours = isDark() ? { wrong: [1, 0.25, 0.18, 1], right: [0.2, 0.85, 0.45, 1] } : { wrong: WRONG, right: RIGHT };
  const found = find(right);
  graphics.clear();
  const paint = (items, colour) => {
    for (const item of items) graphics.drawSurface(item, view, look);
    for (const item of items) drawHedgehog(item, view, pixels, colour);
  };
  graphics.within(0, middle, () => paint(wrong, lineColours.wrong));
  graphics.within(middle, canvas.width, () => paint(right, lineColours.right));
  if (!moving) drawChosen(view, pixels);
  if (found && !chosen) {
    const tip = (direction) => found.point.map((x, i) => x + 0.3 * direction[i]);
    const arrows = [{ from: found.point, to: tip(found.wrong), colour: lineColours.wrong }, { from: found.point, to: tip(found.right), colour: lineColours.right }];
    graphics.drawArrows(degreesBetween(found.wrong, found.right) < 0.05 ? arrows.slice(1) : arrows, view, pixels);
  }
  showReadouts(user, right, found);
}

/* ---- what lies under the cursor */

function find(items) {
  if (!cursor) return null;
  const ray = camera.ray(cursor.x, cursor.y);
  if (moving) {
    const at = pointOnPlane(ray), hit = at && moving.at(at[0], at[2]);
    return hit && { point: hit.point, right: hit.normal, wrong: [0, 1, 0] };
  }
  let best = null;
  for (const item of items) {
    const inverse = invert(item.localToWorld);
    const hit = inverse && scene.model.pick(item.mesh, point(inverse, ray.from), apply3(upper(inverse), ray.along));
    if (hit && (!best || hit.at < best.hit.at)) best = { hit, item };
  }
  if (!best) return null;
  const normals = scene.model.meshes[best.item.mesh].normals(), { hit, item } = best, at = 9 * hit.triangle;
  const normal = [0, 1, 2].map((i) => hit.weights[0] * normals[at + i] + hit.weights[1] * normals[at + 3 + i] + hit.weights[2] * normals[at + 6 + i]);
  const right = unit(apply3(item.right, normal)), wrong = unit(apply3(item.plain, normal));
  return { point: ray.from.map((x, i) => x + hit.at * ray.along[i]), right, wrong };
}

function pointOnPlane({ from, along }) {
  const at = -from[1] / along[1];
  return at > 0 && isFinite(at) ? from.map((x, i) => x + at * along[i]) : null;
}

function showReadouts(user, items, found) {
  byId("under").textContent = found ? degrees(degreesBetween(found.wrong, found.right)) : "–";
  if (moving) {
    byId("worst").textContent = degrees(moving.worst());
    return;
  }
  const info = engine.norma.matrixInfo(user);
  byId("worst").textContent = degrees(info.worstErrorDeg);
  showMatrix("matrix-plain", upper(user));
  showMatrix("matrix-normal", engine.norma.normalMatrix(user));
  const key = [...user, items.length, scene.computed].join();
  if (scene.worstKey !== key) {
    scene.worstKey = key;
    scene.worst = largestOf(items, (item) => scene.model.worst(item.mesh, item.plain, item.right));
  }
  showMatrixFacts(info, scene.worst);
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
  if (byId("waves").checked) {
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

function frame(now) {
  requestAnimationFrame(frame);
  if (graphics.gl.isContextLost() || !scene) return;
  try {
    resize();
    if (moving) moveOn(now);
    else if (dirty.compute) { compute(); scene.computed = now; dirty.draw = true; }
    dirty.compute = false;
    if (dirty.draw) { dirty.draw = false; draw(); document.body.dataset.drawn = String(Number(document.body.dataset.drawn ?? 0) + 1); }
  } catch (error) {
    notice(error.message);
    dirty = { compute: false, draw: false };
  }
}

/* ---- files */

async function openFile(file) {
  notice("");
  try {
    const model = engine.openFile(new Uint8Array(await file.arrayBuffer()), file.name);
    if (!model.triangles) { model.free(); throw new Error(`${file.name}: there is nothing in it to draw.`); }
    addModelOption("file", file.name);
    showModel(model);
    setRange("crease", 60);
    document.title = `${file.name} · Norma`;
  } catch (error) {
    notice(error.message);
  }
}

function addModelOption(key, title) {
  const select = byId("model");
  let option = select.querySelector(`[value="${key}"]`);
  if (!option) { option = new Option(title, key); select.prepend(option); }
  option.textContent = title;
  select.value = key;
}

/* What is shown now is not the file that was chosen before. */
function forgetChosen() { byId("file").value = ""; }

function pickModel() {
  const key = value("model");
  notice("");
  if (key !== "file") forgetChosen();
  if (key === "moving") showMoving();
  else if (key === "embedded") showModel(engine.openBytes(embedded.bytes, embedded.name));
  else if (SHAPES[key]) showShape(key);
  if (key !== "file") byId("model").querySelector('[value="file"]')?.remove();
  camera.reset(key === "moving" ? { azimuth: 20, elevation: 34, distance: 3.3 } : {});
}

/* ---- wiring */

function brushAt(event) {
  if (!moving || !byId("brush").checked) return false;
  const at = event ? (placeCursor(event), pointOnPlane(camera.ray(cursor.x, cursor.y))) : pointOnPlane(camera.ray(0, 0));
  if (!at || !moving.at(at[0], at[2])) return false;
  const took = moving.push(at[0], at[2]);
  uploadMoving();
  showMovingFacts(took, moving.touched(), 0);
  dirty.draw = true;
  return true;
}

function placeCursor(event) {
  const box = canvas.getBoundingClientRect();
  cursor = { x: (2 * (event.clientX - box.left)) / box.width - 1, y: 1 - (2 * (event.clientY - box.top)) / box.height };
}

function wireCanvas() {
  steer(canvas, camera, {
    changed: () => { dirty.draw = true; },
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

function placeDivider() {
  const sides = value("sides");
  byId("divider").hidden = sides !== "split";
  byId("side-wrong").hidden = sides === "right";
  byId("side-right").hidden = sides === "wrong";
  byId("divider").style.left = `${numberOf("split")}%`;
  byId("legend").hidden = value("colours") !== "error";
}

function wireDivider() {
  const grip = byId("grip");
  grip.addEventListener("pointerdown", (event) => { grip.setPointerCapture(event.pointerId); event.preventDefault(); });
  grip.addEventListener("pointermove", (event) => {
    if (!grip.hasPointerCapture(event.pointerId)) return;
    const box = stage.getBoundingClientRect();
    setRange("split", Math.max(0, Math.min(100, (100 * (event.clientX - box.left)) / box.width)));
    placeDivider();
    dirty.draw = true;
  });
}

function wireControls() {
  const recompute = new Set(["source", "crease", "weight", "weld", "shading", "colours"]);
  for (const control of document.querySelectorAll("#panel input:not([type=file]), #panel select:not(#model)")) {
    const changed = () => {
      if (RANGES.includes(control.id)) spell(control.id);
      /* Who turns these wants to see what they do. */
      if (["crease", "weight", "weld"].includes(control.id)) byId("source").value = "computed";
      if (recompute.has(control.id)) dirty.compute = true;
      if (control.id === "colours") { chosen = null; releaseFindings(); }
      canvas.classList.toggle("brush", moving !== null && byId("brush").checked);
      placeDivider();
      dirty.draw = true;
    };
    control.addEventListener("input", changed);
    control.addEventListener("change", changed);
  }
  byId("model").addEventListener("change", pickModel);
  byId("file").addEventListener("change", (event) => { if (event.target.files[0]) openFile(event.target.files[0]); });
  byId("reset-matrix").addEventListener("click", () => {
    for (const id of ["scale-x", "scale-y", "scale-z"]) setRange(id, 1);
    setRange("shear", 0);
    byId("mirror").value = "";
    dirty.draw = true;
  });
  byId("reset-view").addEventListener("click", () => { camera.reset(moving ? { azimuth: 0, elevation: 34, distance: 3.3 } : { azimuth: 0, elevation: 0 }); dirty.draw = true; });
  byId("flatten").addEventListener("click", () => { if (moving) { moving.flatten(); uploadMoving(); dirty.draw = true; } });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { dirty.draw = true; });
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
    if (event.dataTransfer.files[0]) openFile(event.dataTransfer.files[0]);
  });
}

/* ---- start */

function bytesOf(id) {
  const text = byId(id).textContent, characters = atob(text), bytes = new Uint8Array(characters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = characters.charCodeAt(i);
  byId(id).textContent = "";
  return bytes;
}

function fallBack(reason) {
  byId("fallback").hidden = false;
  byId("fallback-reason").textContent = reason;
  byId("readouts").hidden = byId("divider").hidden = byId("side-wrong").hidden = byId("side-right").hidden = true;
}

function fillModels() {
  const select = byId("model");
  for (const [key, { title }] of Object.entries(SHAPES)) select.append(new Option(title, key));
  select.append(new Option("A surface that moves, 200,000 triangles", "moving"));
}

/* The colour scale of surface.frag, for its legend. */
function paintLegend(texts) {
  const stops = [...texts["colour.glsl"].matchAll(/vec3\((0\.\d+), (0\.\d+), (0\.\d+)\)[,)]/g)].map((match) => match.slice(1, 4).map((x) => Math.round(255 * Number(x))));
  byId("legend-bar").style.background = `linear-gradient(90deg, ${stops.map((stop) => `rgb(${stop.join(" ")})`).join(", ")})`;
}

export async function startPage(texts) {
  RANGES.forEach(spell);
  graphics = makeGraphics(canvas, texts);
  if (!graphics) { fallBack(""); return; }
  engine = await startEngine(bytesOf("wasm"));
  byId("version").textContent = engine.norma.version;
  paintLegend(texts);
  fillModels();
  wireCanvas();
  wireDivider();
  wireControls();
  wireDrop();
  if (matchMedia("(prefers-reduced-motion: reduce)").matches) byId("waves").checked = false;
  const pack = bytesOf("pack");
  if (pack.length) {
    embedded = { bytes: pack, name: byId("pack").dataset.name };
    addModelOption("embedded", embedded.name);
    document.title = `${embedded.name} · Norma`;
  } else {
    setRange("scale-x", 2);
  }
  pickModel();
  placeDivider();
  requestAnimationFrame(frame);
}

startPage(SHADERS).catch((error) => fallBack(error.message));
