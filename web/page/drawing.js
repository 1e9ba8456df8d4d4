/* The picture: each panel of it with its surfaces, lines and arrows. */
import { comparison, isOfTwo, panelKind, placeStage } from "./comparison.js";
import { byId, isChecked, numberOf, value } from "./controls.js";
import { drawFound, showReadouts } from "./cursor.js";
import { drawShadow } from "./ground.js";
import { IDENTITY, multiply, upper } from "./matrix.js";
import { panelsOf } from "./panels.js";
import { drawChosen, drawCorner } from "./pressed.js";
import { notice } from "./readouts.js";
import { fitOf, itemsOf, turning } from "./scene.js";
import { PIN_COLOURS, REACH, UNMARKED, camera, canvas, dirty, isDark, page, userMatrix } from "./state.js";

const COLOURS = { light: { wrong: [0.75, 0.03, 0.02, 1], right: [0.02, 0.45, 0.12, 1], before: [0.2, 0.2, 0.2, 1] }, dark: { wrong: [1, 0.25, 0.18, 1], right: [0.2, 0.85, 0.45, 1], before: [0.8, 0.8, 0.8, 1] } };
const COARSE = 0.5, MOST_LINES = 60000, ANGLE_TOPS = [1, 2, 5, 10, 15, 30, 45, 60, 90, 180];

function movingItems(side) {
  const surface = page.scene.surfaces[0];
  return [{ surface, normals: side === "wrong" ? page.scene.still : surface.normals, localToWorld: IDENTITY, normalMatrix: upper(IDENTITY), mirrored: false, clay: [0.16, 0.42, 0.55], mesh: 0, size: 0.02 }];
}

function sideItems(side, user, compared) {
  if (page.moving) return movingItems(side);
  return side === "wrong" && isOfTwo(compared) ? itemsOf(page.norma, page.before, user, "right") : itemsOf(page.norma, page.scene, user, side);
}

/* Faces' lines come from the worker, once. */
function faceLinesOf(item) {
  const lines = page.scene.faces;
  if (lines[item.mesh] === undefined) {
    const shown = page.scene;
    lines[item.mesh] = null;
    page.remote.faceLines(shown.model.number, item.mesh).then(({ from, to }) => {
      lines[item.mesh] = { from: page.graphics.makeBuffer(from), to: page.graphics.makeBuffer(to), points: to.length / 3 };
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
    page.loading++;
    page.remote[kind](shown.model.number, item.mesh).then(async ({ ends, count }) => {
      const made = { ends: page.graphics.reserve(ends.byteLength), count };
      await page.graphics.fillSlowly(made.ends, ends);
      lines[item.mesh] = made;
      dirty.draw = true;
    }).catch((error) => notice(error.message)).finally(() => { page.loading--; });
  }
  if (lines[item.mesh]?.count) page.graphics.drawWire(item, view, lines[item.mesh], width * pixels, colour);
}

function drawHedgehog(item, view, pixels, colour) {
  const kind = value("hedgehog");
  if (!kind) return;
  const { surface } = item, common = { colour, pixels, scale: numberOf("line-length") * item.size * (item.material?.reach ?? 1) };
  const lines = page.moving || kind === "vertex" ? { from: surface.positions, to: item.normals, points: surface.points } : faceLinesOf(item);
  if (lines) page.graphics.drawHedgehog(item, view, { ...common, ...lines, most: Math.min(MOST_LINES, (numberOf("line-density") / 100) * lines.points) });
}

function drawPanel({ side, box, from, to }, pixels, draw) {
  const part = { x: Math.round(box.x * pixels), y: Math.round((canvas.clientHeight - box.y - box.height) * pixels), width: Math.round(box.width * pixels), height: Math.round(box.height * pixels) };
  const cut = from === undefined ? undefined : { x: Math.round(from * pixels), width: Math.round(to * pixels) - Math.round(from * pixels) };
  camera.aspect = box.width / box.height;
  page.graphics.within(part, () => draw(side, { worldToView: camera.worldToView(), viewToClip: camera.viewToClip(REACH + Math.abs(page.moving ? 0 : numberOf("move"))) }), cut);
}

/* coarse: with half of the pixels each way, in the canvas' lower left quarter, which is then shown twice as large: another size of the canvas would have to wait for the card. bare: without the whole in the corner. */
export function draw(coarse = false, bare = coarse) {
  const wantsCorner = Boolean(page.chosen && (page.look.place || page.look.outline) && value("colours") === "findings"), inCorner = wantsCorner && !bare;
  page.coarse = coarse || (wantsCorner && bare);
  canvas.classList.toggle("coarse", coarse);
  const pixels = (canvas.width / (canvas.clientWidth || 1)) * (coarse ? COARSE : 1), user = userMatrix(), compared = comparison();
  const info = page.norma.matrixInfo(user), colours = isDark() ? COLOURS.dark : COLOURS.light;
  page.panels = panelsOf(panelKind(compared), canvas.clientWidth, canvas.clientHeight, numberOf("split") / 100);
  page.look.angleTop = ANGLE_TOPS.find((top) => top >= info.worstErrorDeg - 0.005) ?? 180;
  page.graphics.clear();
  for (const panel of page.panels) drawPanel(panel, pixels, (side, view) => {
    /* A scene that plays stands where the model stands. */
    const angle = side === "angle", posed = compared || page.chosen || page.moving || value("colours") !== "lit" ? null : page.animation.root(multiply(multiply(fitOf(user), user), multiply(page.scene.frame, turning(page.scene.up))));
    const items = posed ? [] : sideItems(angle ? "right" : side, user, compared), how = { posed, ...page.look, tinted: compared === "change" && isChecked("tint"), outlineColour: page.chosen && PIN_COLOURS[page.chosen.grade], outlineWidth: 3.5 * pixels, materials: isChecked("textures"), normalMaps: isChecked("normal-maps"), colours: angle ? "angle" : side === "wrong" && compared === "files" && value("colours") in page.scene.compared.values ? "lit" : value("colours"), shading: value("shading") };
    page.graphics.drawSurfaces(items, view, how);
    if (!angle && !posed) drawShadow(view);
    for (const [kind, box] of [["wire", "wireframe"], ["seams", "seams"]]) if (!angle && isChecked(box) && !page.moving) for (const item of items) drawEdges(kind, item, view, pixels, side === "wrong" && isOfTwo(compared) ? page.before : page.scene);
    if (!angle) for (const item of items) drawHedgehog(item, view, pixels, isOfTwo(compared) ? colours.before : colours[side]);
    if (!page.moving) drawChosen(view, pixels);
    if (page.found && !page.chosen && compared && !isOfTwo(compared) && !angle && !page.intro.isShown()) drawFound(view, pixels, colours);
  });
  byId("whole").hidden = !inCorner;
  if (inCorner) drawCorner(pixels, (view) => page.graphics.drawSurfaces(sideItems("right", user, null), view, { ...UNMARKED, outline: page.look.outline, outlineColour: page.chosen && PIN_COLOURS[page.chosen.grade], outlineWidth: 2 * pixels, materials: isChecked("textures"), normalMaps: false, colours: "lit", shading: "phong" }));
  placeStage();
  showReadouts(info, user, compared);
  page.remember();
}

const sizeWanted = () => [canvas.clientWidth, canvas.clientHeight].map((length) => Math.max(1, Math.round(length * Math.min(2, devicePixelRatio || 1))));
export const fits = () => { const [width, height] = sizeWanted(); return canvas.width === width && canvas.height === height; };
export function resize() {
  [canvas.width, canvas.height] = sizeWanted();
  dirty.draw = true;
}
