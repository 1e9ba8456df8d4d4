/* A finding that is pressed: its place, the way the camera flies there, and what marks it. */
import { makeCamera } from "./camera.js";
import { placeStage } from "./comparison.js";
import { byId, setRange, value } from "./controls.js";
import { releaseFindings } from "./findings.js";
import { apply3, length, multiply, point, unit } from "./matrix.js";
import { showPart } from "./parts.js";
import { notice } from "./readouts.js";
import { uploadMarks } from "./recompute.js";
import { fitOf, itemsOf, largestColumn, meanColumn } from "./scene.js";
import { posesOf, seek } from "./seek.js";
import { PIN_COLOURS, REACH, UNMARKED, camera, canvas, dirty, hurry, isCalm, isDark, isSlow, page, userMatrix } from "./state.js";
import { viewOf } from "./thumbs.js";

/* Milliseconds. */
const FLIGHT = 450, SWEEP = 2600;

/* The finding's mesh where it is drawn, and its place there. */
export function placeIn(finding, { point: at, direction, size, points }, shown = page.scene) {
  const draw = shown.draws[finding.draw] ?? shown.draws.find(({ mesh }) => mesh === finding.mesh);
  if (!at || !draw) return null;
  const user = userMatrix(), toWorld = multiply(fitOf(user), multiply(user, draw.local));
  let normal = direction;
  try { normal = apply3(Array.from(page.norma.normalMatrix(toWorld)), direction); } catch { /* a node that is not finite */ }
  const pins = Array.from({ length: points.length / 3 }, (_, i) => point(toWorld, points.slice(3 * i, 3 * i + 3))), where = point(toWorld, at);
  return { at: where, normal: length(normal) > 0 ? unit(normal) : camera.axes().back, size: size * meanColumn(toWorld), pins: pins.length ? pins : [where] };
}

/* Whether a finding is about a part rather than about places on it. Of angles that all of a part has, the greatest has a place. */
export const isOfWhole = (shown, { mesh, places, severity, unit }, place) => shown.model.meshes[mesh] !== undefined && (!place || (severity < 2 && unit !== "deg" && places > shown.model.meshes[mesh].faces / 2));
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
export async function seenSmall(finding) {
  const shown = page.scene;
  if (!shown?.model?.findings?.includes(finding)) return null;
  const place = placeIn(finding, await page.remote.place(shown.model.number, finding.index, 0)), items = itemsOf(page.norma, shown, userMatrix(), "right"), isWhole = isOfWhole(shown, finding, place), outline = isWhole ? partOf(finding) : null;
  return { scene: shown, items, place: isWhole ? null : place, whole: isWhole ? { ...poseOfPart(finding, items), azimuth: 38, elevation: 18 } : null, up: camera.axes().up, paper: isDark() ? [0.125, 0.16, 0.17] : [0.914, 0.906, 0.875],
           look: { outline, outlineColour: PIN_COLOURS[finding.grade], outlineWidth: 3 }, pins: (view) => page.graphics.drawPins(place.at, view, PIN_COLOURS[finding.grade], 22) };
}

/* No number is given twice, though none is sought in between. */
let presses = 0;

/* Marks a finding alone, and takes the camera where enough of it is seen. */
export async function chooseFinding(finding, which = 0) {
  const mine = ++presses, shown = page.scene;
  page.seeking = mine;
  page.chosen = finding;
  page.aiming = finding !== null;      /* what is drawn before it is known where would only be waited for */
  if (finding) page.animation.stop();
  byId("colours").value = finding ? "findings" : "lit";
  byId("finding-seen").textContent = "";
  byId("places").hidden = true;
  page.look = { ...UNMARKED, errorTop: page.look.errorTop, angleTop: page.look.angleTop };
  try {
    if (finding) showPart(shown, finding.mesh);
    const [found] = finding ? await Promise.all([page.remote.place(shown.model.number, finding.index, which), uploadMarks(shown, finding), shown.filled]) : [], place = finding && placeIn(finding, found);
    if (mine !== page.seeking || shown !== page.scene) return;
    if (!finding) return;
    const items = itemsOf(page.norma, shown, userMatrix(), "right");
    if (!shown.model.meshes[finding.mesh]) { camera.reset(); byId("finding-seen").textContent = "This is about the file, not about a place on its surface."; return; }
    if (isOfWhole(shown, finding, place)) {
      page.look = { ...page.look, outline: partOf(finding), unpainted: finding.severity < 2 };
      byId("finding-seen").textContent = "This is about a whole part: the line goes round it.";
      await fly({ ...camera.home, ...poseOfPart(finding, items) });
      return;
    }
    page.look.dim = true;
    const everywhere = finding.severity > 1 && finding.places > shown.model.meshes[finding.mesh].faces / 2, aspect = canvas.clientWidth / Math.max(1, canvas.clientHeight);
    const counts = (poses, through) => page.graphics.countMarked(items, poses.map((pose) => viewOf(pose, aspect, REACH)), aspect, through);
    const best = await seek(posesOf(place, camera.axes().up, everywhere), counts);
    if (mine !== page.seeking || shown !== page.scene) return;
    page.look = { ...page.look, through: best.faint, pins: best.pinned ? [place.at] : null, place };
    byId("finding-seen").textContent = best.pinned ? "What is meant is too thin to be seen: a disc shows where it is." : best.faint ? "Other parts stand in front; it is drawn over them." : "";
    showPlaces(which, place.pins.length);
    await fly({ ...best.pose, centre: [...best.pose.centre] });
  } catch (error) {
    notice(error.message);
  } finally {
    if (mine === page.seeking) { page.seeking = 0; page.aiming = false; placeStage(); }
    dirty.draw = true;
  }
}

/* The camera goes from the whole to a place, at once where pictures are slow; whoever moves it stops it. */
export async function fly(to) {
  page.aiming = false;
  const mine = ++page.flights, whole = { ...camera.home }, mix = (a, b, part) => a + (b - a) * part;
  whole.azimuth = to.azimuth + Math.max(-40, Math.min(40, ((camera.azimuth - to.azimuth + 540) % 360) - 180));
  for (const begin = performance.now(); mine === page.flights; await new Promise(requestAnimationFrame)) {
    const time = isCalm() || isSlow() ? 1 : Math.min(1, (performance.now() - begin) / FLIGHT), part = time * time * (3 - 2 * time);
    camera.reset({ azimuth: mix(whole.azimuth, to.azimuth, part), elevation: mix(whole.elevation, to.elevation, part), distance: Math.exp(mix(Math.log(whole.distance), Math.log(to.distance), part)), centre: whole.centre.map((x, i) => mix(x, to.centre[i], 1 - (1 - part) ** 2)) });
    hurry();
    if (time === 1) return;
  }
}

/* The line goes once over what was changed. */
export async function sweep() {
  const mine = ++page.flights;
  for (const begin = performance.now(); !isCalm() && mine === page.flights; await new Promise(requestAnimationFrame)) {
    const time = Math.min(1, (performance.now() - begin) / SWEEP);
    setRange("split", Number((50 + 42 * Math.sin(2 * Math.PI * time) * (1 - 0.3 * time)).toFixed(1)));
    dirty.draw = true;
    if (time === 1) return;
  }
}

/* Buttons from place to place. */
function showPlaces(which, count) {
  byId("places").hidden = count < 2;
  byId("next-place").textContent = `Next place (${which + 1} of ${count})`;
  byId("next-place").onclick = () => chooseFinding(page.chosen, (which + 1) % count);
  byId("all-places").onclick = () => {
    page.flights++;
    camera.reset();
    page.look = { ...page.look, through: true, pins: page.look.place.pins };
    dirty.draw = true;
  };
}

/* No finding is chosen any more. */
export function letGo() {
  page.chosen = null;
  page.flights++;
  page.look = { ...page.look, ...UNMARKED };
  byId("places").hidden = true;
  byId("finding-seen").textContent = "";
  releaseFindings();
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

/* Far from the paper, and near it. */
const inks = () => (isDark() ? [[1, 1, 1, 1], [0, 0, 0, 1]] : [[0, 0, 0, 1], [1, 1, 1, 1]]);

/* The whole in a corner, with the place marked. */
export function drawCorner(pixels, draw) {
  const width = Math.round(Math.min(200, 0.28 * canvas.clientWidth)), height = Math.round(0.8 * width), box = { x: canvas.clientWidth - width - 12, y: canvas.clientHeight - height - 12, width, height }, whole = makeCamera();
  byId("whole").style.cssText = `width:${width}px;height:${height}px`;
  Object.assign(whole, { azimuth: camera.azimuth, elevation: camera.elevation, aspect: width / height });
  const part = { x: Math.round(box.x * pixels), y: Math.round(12 * pixels), width: Math.round(width * pixels), height: Math.round(height * pixels) };
  page.graphics.within(part, () => {
    const view = { worldToView: whole.worldToView(), viewToClip: whole.viewToClip(REACH) };
    page.graphics.paint(isDark() ? [0.11, 0.137, 0.149] : [1, 1, 1]);
    draw(view);
    if (!page.look.place) return;
    inks().forEach((colour, i) => page.graphics.drawPins(page.look.place.at, view, colour, [13, 8][i] * pixels));
  });
}

/* An arrow that points at the place of the finding that is chosen; discs where it has no area. */
export function drawChosen(view, pixels) {
  if (value("colours") !== "findings" || !page.chosen || !page.look.place) return;
  const { place, pins } = page.look, reach = 0.09 * camera.distance, { right, up } = camera.axes(), [ink, paper] = inks();
  if (pins) {
    const size = Math.max(9 * pixels, Math.min(80 * pixels, 2 * Math.sqrt((0.006 * pixels * pixels * canvas.clientWidth * canvas.clientHeight) / Math.PI / apart(pins, view))));
    page.graphics.drawPins(pins.flat(), view, ink, size + 3 * pixels);
    page.graphics.drawPins(pins.flat(), view, PIN_COLOURS[page.chosen.grade], size);
    return;
  }
  page.graphics.drawPointer({ from: place.at.map((x, i) => x + reach * (place.normal[i] + right[i] + up[i])), to: place.at, colour: ink }, paper, view, pixels);
}
