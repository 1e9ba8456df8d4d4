/* The soft shadow that a file's model casts on the ground it stands on: one small picture of it from below, blurred; made anew for each model and matrix, once nothing else is going on. */
import { value } from "./controls.js";
import { multiply, point } from "./matrix.js";
import { fitOf, itemsOf } from "./scene.js";
import { camera, dirty, isDark, page, userMatrix } from "./state.js";

/* How high above the ground, by the model's size, what still casts; the ground beside the model; how dark it is. */
const HEIGHT = 0.45, BESIDE = 0.25, DARK = { light: 0.5, dark: 0.8 };

let cast = null;

/* What the shadow is of; null: none is shown. */
function wanted() {
  const { scene } = page;
  if (!scene?.model?.format || page.before || page.chosen || value("colours") !== "lit") return null;
  return [scene.model.number, scene.up, ...scene.hidden, ...userMatrix()].join();
}

export const isShadowDue = () => { const key = wanted(); return key !== null && key !== cast?.key; };

export function castShadow() {
  const key = wanted(), user = userMatrix(), whole = multiply(fitOf(user), user), points = page.scene.corners().map((corner) => point(whole, corner));
  cast = { key, ground: null };
  if (!points.length) return;
  const ends = [0, 1, 2].map((axis) => [Math.min(...points.map((p) => p[axis])), Math.max(...points.map((p) => p[axis]))]);
  const size = Math.max(...ends.map(([low, high]) => high - low)), beside = BESIDE * size, [x, z] = [ends[0], ends[2]].map(([low, high]) => ({ middle: (low + high) / 2, half: (high - low) / 2 + beside })), y = ends[1][0] - 0.002 * size;
  cast.ground = { y, localToWorld: [x.half, 0, 0, 0, 0, 1, 0, 0, 0, 0, z.half, 0, x.middle, y, z.middle, 1] };
  /* From below, upwards: right is x, up is z. */
  const height = HEIGHT * size, view = { worldToView: [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, -x.middle, -z.middle, y, 1], viewToClip: [1 / x.half, 0, 0, 0, 0, 1 / z.half, 0, 0, 0, 0, -2 / height, 0, 0, 0, -1, 1] };
  page.graphics.castShadow(itemsOf(page.norma, page.scene, user, "right"), view, [beside / x.half, beside / z.half]);
  dirty.draw = true;
}

/* From above; from below the model would be seen through it. */
export function drawShadow(view) {
  if (cast?.ground && cast.key === wanted() && camera.eye()[1] > cast.ground.y) page.graphics.drawShadow(cast.ground.localToWorld, view, isDark() ? DARK.dark : DARK.light);
}
