/* A model on the graphics card: a surface for each of its meshes, and where each is drawn. */
import { IDENTITY, apply3, length, multiply, point, scaling, translation, upper } from "./matrix.js";

const largestOf = (list, measure) => list.reduce((most, element) => Math.max(most, measure(element)), -Infinity);
export const largestColumn = (m) => Math.max(length(m.slice(0, 3)), length(m.slice(4, 7)), length(m.slice(8, 11)));
export const meanColumn = (m) => (length(m.slice(0, 3)) + length(m.slice(4, 7)) + length(m.slice(8, 11))) / 3;
const determinant = (m) => m[0] * (m[4] * m[8] - m[5] * m[7]) + m[3] * (m[7] * m[2] - m[8] * m[1]) + m[6] * (m[1] * m[5] - m[2] * m[4]);

/* What has no material is mid-grey clay: light shows no shape on white. */
const CLAY = [0.5, 0.5, 0.5];

/* The whole of a model in the unit ball: the middle of the box round the balls of what is drawn, and how far from it they reach. */
function frameOf(model, draws) {
  const balls = draws.map(({ mesh, world }) => ({ centre: point(world, model.meshes[mesh].ball), radius: model.meshes[mesh].ball[3] * largestColumn(world) }));
  const most = (sign) => [0, 1, 2].map((i) => largestOf(balls, ({ centre, radius }) => sign * centre[i] + radius));
  const high = most(1), low = most(-1).map((x) => -x), middle = high.map((x, i) => (x + low[i]) / 2);
  const radius = largestOf(balls, (ball) => length(ball.centre.map((x, i) => x - middle[i])) + ball.radius);
  if (!isFinite(radius)) return IDENTITY;
  const scale = 1 / (radius || 1);
  return multiply(scaling(scale, scale, scale), translation(...middle.map((x) => -x)));
}

/* Turns what the file calls up to y; the front is where norma render has it. */
const TURNED = { y: [1, 0, 0, 0, 1, 0, 0, 0, 1], z: [1, 0, 0, 0, 0, -1, 0, 1, 0], x: [0, 1, 0, -1, 0, 0, 0, 0, 1], "-y": [1, 0, 0, 0, -1, 0, 0, 0, -1], "-z": [1, 0, 0, 0, 0, 1, 0, -1, 0], "-x": [0, -1, 0, 1, 0, 0, 0, 0, 1] };
export const turning = (up) => { const m = TURNED[up]; return [m[0], m[1], m[2], 0, m[3], m[4], m[5], 0, m[6], m[7], m[8], 0, 0, 0, 0, 1]; };

/* fixed: the frame of another model, to stand where that does. */
export function makeScene(graphics, model, up = model.up ?? "y", fixed = null) {
  const surfaces = model.arrays.map(graphics.makeSurface), boxes = model.arrays.map(({ box }) => box);
  model.arrays = null;
  /* Nothing is drawn of it before all is filled in. */
  const fill = async () => { for (const surface of surfaces) await surface.fill(); scene.isFilled = true; };
  const scene = { model, surfaces, isFilled: false, faces: [], edges: {}, hidden: new Set(), free: () => { surfaces.forEach((surface) => surface.free()); scene.freeMaterials?.(); } };
  /* Kept when its first picture is there: all that can wait waits for it. */
  scene.seen = new Promise((see) => { scene.see = see; });
  /* Where everything stands, with this axis up. */
  scene.place = (axis, frame = null) => {
    const turned = model.draws.map(({ mesh, world }) => ({ mesh, world: multiply(turning(axis), world) }));
    scene.up = axis;
    scene.frame = frame ?? frameOf(model, turned);
    scene.draws = turned.map(({ mesh, world }) => {
      const [x, y, z, radius] = model.meshes[mesh].ball;
      return { mesh, world, local: multiply(multiply(scene.frame, world), multiply(translation(x, y, z), scaling(radius, radius, radius))) };
    });
  };
  /* Of the boxes round what is drawn. */
  scene.corners = () => scene.draws.flatMap(({ mesh, local }) => boxes[mesh].map((corner) => point(local, corner)));
  scene.place(up, fixed);
  scene.filled = fill();
  return scene;
}

/* A large scale is shown smaller as a whole, so that the model stays in the picture: that turns no normal. By how far the matrix takes a ball, and a little by how far a cube: most models are neither. */
export function fitOf(user) {
  const signs = [[1, 1, 1], [1, 1, -1], [1, -1, 1], [-1, 1, 1]], cube = Math.max(...signs.map((corner) => length(apply3(upper(user), corner)))) / Math.sqrt(3);
  const scale = 1 / Math.max(1, (cube + 3 * largestColumn(user)) / 4);
  return scaling(scale, scale, scale);
}

/* What is drawn on one side, wrong or right: each with its matrices. */
export function itemsOf(norma, scene, user, side) {
  const fit = fitOf(user);
  return scene.draws.flatMap(({ mesh, world, local }, draw) => {
    if (scene.hidden.has(mesh)) return [];
    const through = multiply(user, world), plain = upper(through);
    let right = plain;
    try { right = Array.from(norma.normalMatrix(through)); } catch { /* a node that is not finite: nothing is right there */ }
    const surface = scene.surfaces[mesh], material = scene.model.meshes[mesh];
    return { surface, normals: surface.normals, localToWorld: multiply(fit, multiply(user, local)), normalMatrix: side === "wrong" ? plain : right, plain, right,
             mirrored: determinant(plain) < 0, clay: scene.model.format && !material.decimated ? CLAY : material.colour.slice(0, 3), mesh, draw, material, materials: scene.materials, isDoubleSided: material.isDoubleSided, isShiny: !scene.model.format, isWooden: scene.model.isWooden, size: meanColumn(local) * fit[0] };
  });
}
