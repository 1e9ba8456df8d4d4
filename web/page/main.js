/* The page: what its controls say is computed (in a worker) and drawn (here). Nothing is drawn but when something changed; what moves, moves by itself. */
import { bindCalls } from "../package/more-calls.js";
import { noDecoders } from "../package/decoders.js";
import { applyAddress, makeAddress, readAddress } from "./address.js";
import { makeAnimation } from "./animation.js";
import { steer } from "./camera.js";
import { wireCells } from "./cells.js";
import { compareWith } from "./compare.js";
import { comparison, wordsOf } from "./comparison.js";
import { MATRIX, RANGES, byId, isChecked, numberOf, setMatrix, setRange, spell, value } from "./controls.js";
import { computeCopy, fix } from "./copies.js";
import { cursorRay, pointOnPlane } from "./cursor.js";
import { draw, fits, resize } from "./drawing.js";
import { EXPECTED, filesOfDrop, filesOfInput } from "./files.js";
import { keyOf } from "./findings.js";
import { castShadow, isShadowDue } from "./ground.js";
import { makeGraphics } from "./graphics.js";
import { bytesOf, moduleOf } from "./inflate.js";
import { makeIntro } from "./intro.js";
import { STEPS } from "./lesson.js";
import { forgetChosen, openGiven, option, pickModel, stopIntro, uploadMoving, whenQuiet } from "./opening.js";
import { savePicture, saveTurntable } from "./picture.js";
import { letGo, seenSmall } from "./pressed.js";
import { notice, showMovingFacts } from "./readouts.js";
import { compute } from "./recompute.js";
import { startRemote } from "./remote.js";
import { CREDIT, unpackSculpture } from "./sculpture.js";
import { filesServed, servedPath } from "./served.js";
import { SHAPES } from "./shapes.js";
import { DEFAULT_CURSOR, camera, canvas, dirty, hurry, isCalm, isSlow, page, stage } from "./state.js";
import { makeThumbs } from "./thumbs.js";

const timer = { last: 0, frames: 0 };
/* Milliseconds without movement, after which a picture is drawn with all of its pixels. */
const STILL = 150;

/* ---- the loop */

function moveOn(now) {
  const seconds = timer.last ? Math.min(0.05, (now - timer.last) / 1000) : 0.016;
  if (timer.last) timer.frames = timer.frames * 0.9 + (1000 / Math.max(1, now - timer.last)) * 0.1;
  timer.last = now;
  if (isChecked("waves")) {
    const took = page.moving.wave(seconds, numberOf("height"));
    uploadMoving();
    showMovingFacts(took, page.moving.touched(), timer.frames);
    dirty.draw = true;
  }
}

/* The shadow waits for the picture without one, and for all that is to be in it. */
const mayCast = () => page.warm && page.computed > 0 && !(dirty.draw || dirty.compute || page.drawing || page.computing || page.loading || page.coarse || page.aiming);

/* Whether something is still to come, for those who wait. */
function showBusy() {
  const busy = page.calls > 0 || page.computing || page.picking || page.measuring || page.loading > 0 || page.seeking > 0 || dirty.compute || (!page.animation.isPlaying() && (page.drawing || dirty.draw || page.coarse || isShadowDue())) ? "1" : "";
  if (document.body.dataset.busy !== busy) document.body.dataset.busy = busy;
}

/* Until the card has nothing to do: a canvas that changes its size waits for that, and the page with it. */
function rest() {
  page.drawing = true;
  page.graphics.drained().catch(() => undefined).then(() => { page.drawing = false; page.rested = true; });
}

function frame(now) {
  requestAnimationFrame(frame);
  if (page.graphics.gl.isContextLost() || !page.scene) { showBusy(); return; }
  try {
    if (!page.drawing && !page.aiming && !fits()) {
      if (page.rested) resize();      /* it is empty then, and drawn at once */
      else rest();
    }
    page.intro.tick(now);
    page.animation.tick(now);
    if (page.moving) { moveOn(now); dirty.compute = false; }
    else if (dirty.compute && !page.computing) compute();
    if (isShadowDue() && mayCast()) castShadow();
    const coarse = isSlow() && (page.hasty || performance.now() - page.hurried < STILL);
    if (page.coarse && !coarse) dirty.draw = true;
    if (dirty.draw && (page.moving || (page.computed && page.scene.isFilled)) && !page.drawing && !page.aiming && (page.hasty || !page.awaiting)) {
      dirty.draw = false;
      page.drawing = true;
      page.rested = page.hasty = false;
      const begin = performance.now(), { see } = page.scene;
      draw(coarse, coarse || canvas.classList.contains("coarse"));      /* all of the model, small, takes as long as its place */
      page.graphics.drained().catch(() => undefined).then(() => { page.drawing = false; if (!coarse) page.cost = performance.now() - begin; see?.(); });
      document.body.dataset.drawn = String(Number(document.body.dataset.drawn ?? 0) + 1);
    }
  } catch (error) {
    notice(error.message);
    Object.assign(dirty, { compute: false, draw: false });
    page.drawing = false;
    page.scene.see?.();
  }
  showBusy();
}

/* ---- wiring */

function brushAt(event) {
  if (!page.moving || !isChecked("brush")) return false;
  if (event) placeCursor(event);
  const ray = event ? cursorRay() : camera.ray(0, 0), at = ray && pointOnPlane(ray);
  if (!at || !page.moving.at(at[0], at[2])) return false;
  const took = page.moving.push(at[0], at[2]);
  uploadMoving();
  showMovingFacts(took, page.moving.touched(), 0);
  dirty.draw = true;
  return true;
}

function placeCursor(event) {
  const box = stage.getBoundingClientRect();
  page.cursor = { x: (event.clientX - box.left) / box.width, y: (event.clientY - box.top) / box.height };
}

function wireCanvas() {
  steer(canvas, camera, {
    changed: () => { page.flights++; page.intro.pause(); hurry(); },
    hover: (event) => { if (event) placeCursor(event); else page.cursor = DEFAULT_CURSOR; dirty.draw = true; },
    taken: (event, phase) => (phase === "up" ? true : brushAt(event)),
  });
  canvas.addEventListener("keydown", (event) => {
    if (event.key === " " && page.moving) { brushAt(null); event.preventDefault(); }
  });
  canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
  canvas.addEventListener("webglcontextrestored", () => location.reload());
  new ResizeObserver(() => { dirty.draw = true; }).observe(canvas);
}

/* The divider is dragged wherever on its line it is taken. */
function wireDivider() {
  const divider = byId("divider");
  divider.addEventListener("pointerdown", (event) => { page.flights++; divider.setPointerCapture(event.pointerId); event.preventDefault(); });
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
  canvas.classList.toggle("brush", page.moving !== null && isChecked("brush"));
  dirty.draw = true;
}

function turnUp() {
  if (!page.scene?.place) return;
  letGo();
  page.before?.place(value("up"));
  page.scene.place(value("up"), page.before?.frame);
  page.scene.worstKey = page.scene.picked = null;
  byId("up-facts").textContent = "";
}

/* What a saved picture says. */
const shownNow = () => [page.panels, { title: document.title, words: wordsOf(comparison()), compared: comparison() !== null, angle: byId("worst").textContent }];

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
  byId("other").addEventListener("change", () => compareWith(filesOfInput(byId("other"))));
  const onClick = (id, act) => byId(id).addEventListener("click", () => { act(); dirty.draw = true; });
  onClick("reset-matrix", () => { stopIntro(); setMatrix(); });
  onClick("reset-view", () => camera.reset(page.moving ? { azimuth: 0 } : page.scene.model.format ? camera.framing(page.scene.corners(), { azimuth: 0, elevation: 0 }) : { azimuth: 0, elevation: 0 }));
  onClick("flatten", () => { if (page.moving) { page.moving.flatten(); uploadMoving(); } });
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
  if (page.sculpture) select.append(new Option(page.sculpture.name, "sculpture"));
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
  const [{ instance }, started] = await Promise.all([WebAssembly.instantiate(bytes, noDecoders), startRemote(textOf("worker"), modules, (now) => { page.calls = now; })]);
  page.norma = bindCalls(instance.exports);
  page.remote = started;
}

/* What somebody has opened meanwhile stays. */
function openServed(path) {
  const mine = ++page.opening, asked = page.atFirst;
  filesServed(path).then((files) => {
    if (mine !== page.opening) return;
    openGiven(files);
    page.atFirst = asked;
  }, (error) => {
    if (mine !== page.opening) return;
    pickModel();
    notice(error.message);
  });
}

/* What is shown first: what the address asks for, the model of norma view, or the sculpture. */
function showFirst(asked) {
  const wantedModel = asked?.get("model"), known = wantedModel && option("model", CSS.escape(wantedModel));
  const path = page.embedded ? null : servedPath();
  if (known) byId("model").value = wantedModel;
  page.atFirst = asked;
  if (path) openServed(path);
  else pickModel();
  if (!page.embedded && !asked && !path && value("model") === "sculpture") page.intro.begin(!isCalm());
  if (asked) applyAddress(asked, camera);
  if (asked?.has("crease")) { const crease = asked.get("crease"), later = () => (page.computed ? setRange("crease", crease) : setTimeout(later, 30)); later(); }
}

export async function startPage(texts) {
  RANGES.forEach(spell);
  page.graphics = makeGraphics(canvas, texts);
  if (!page.graphics) { fallBack(""); return; }
  await startEngines();
  page.thumbs = makeThumbs(page.graphics, page.remote, seenSmall, () => !(page.computing || page.picking || page.measuring || page.loading || page.seeking || page.coarse || dirty.compute || page.intro.isPlaying()) && (page.animation.isPlaying() || !(page.drawing || dirty.draw)) && page.computed > 0 && page.warm);
  byId("version").textContent = page.norma.version;
  page.sculpture = unpackSculpture(bytesOf(textOf("sculpture")));
  paintLegend(texts);
  fillModels();
  page.animation = makeAnimation(() => { dirty.draw = true; }, isCalm, (scene) => page.graphics.lit.prepare([], { posed: scene }, whenQuiet));
  page.intro = makeIntro(() => { dirty.draw = true; });
  wireCanvas();
  wireDivider();
  wireControls();
  wireLesson();
  wireCells();
  wireDrop();
  if (isCalm()) byId("waves").checked = false;
  const pack = textOf("pack");
  if (pack) {
    page.embedded = { text: pack, name: byId("pack").dataset.name, files: filesIn(textOf("files")) };
    byId("model").prepend(new Option(page.embedded.name, "embedded"));
    byId("model").value = "embedded";
    document.title = `${page.embedded.name} · Norma`;
  }
  const asked = readAddress();
  const kept = makeAddress(camera, () => page.chosen && keyOf(page.chosen));
  showFirst(asked);
  page.graphics.warmUp(whenQuiet).catch((error) => notice(error.message)).then(() => { page.warm = true; });
  page.remember = () => { if (!page.intro.isPlaying() && !page.intro.isShown()) kept(); };
  requestAnimationFrame(frame);
}

startPage(SHADERS).catch((error) => fallBack(error.message));
