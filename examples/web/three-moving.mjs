/* three.js: a BufferGeometry that waves. Its normals are kept right by a plan: what depends on the indices is done once.   node three-moving.mjs */
import { PlaneGeometry } from "three";
import { computeNormals, load, planFor } from "norma-mesh/three";

await load();

const plane = new PlaneGeometry(2, 2, 100, 100), { position, normal } = plane.attributes;
const plan = planFor(plane);
const height = (x, y, time) => 0.1 * Math.sin(5 * x + time) * Math.cos(4 * y);

for (const time of [0, 0.5, 1]) {
  for (let i = 0; i < position.count; i++) position.setZ(i, height(position.getX(i), position.getY(i), time));
  plan.update();
  /* The exact normal is along (-dz/dx, -dz/dy, 1). */
  let worst = 0;
  for (let i = 0; i < position.count; i++) {
    const x = position.getX(i), y = position.getY(i), a = -0.5 * Math.cos(5 * x + time) * Math.cos(4 * y), b = 0.4 * Math.sin(5 * x + time) * Math.sin(4 * y);
    const cosine = (normal.getX(i) * a + normal.getY(i) * b + normal.getZ(i)) / Math.hypot(a, b, 1);
    if (Math.abs(x) < 0.99 && Math.abs(y) < 0.99) worst = Math.max(worst, (Math.acos(Math.min(1, cosine)) * 180) / Math.PI);
  }
  console.log(`time ${time}: ${normal.count} normals within ${worst.toFixed(2)} degrees of the surface's own; left as they were they would be up to ${leaning(normal).toFixed(1)} wrong`);
}

/* By how much they lean from where they began. */
function leaning({ array }) {
  let least = 1;
  for (let i = 2; i < array.length; i += 3) least = Math.min(least, array[i]);
  return (Math.acos(least) * 180) / Math.PI;
}

const before = normal.array.slice();
position.setZ(5100, 1);
plan.update({ moved: [5100] });
const changed = before.filter((x, i) => i % 3 === 2 && x !== normal.array[i]).length;
console.log(`one vertex moved: ${changed} normals written anew of ${normal.count}`);

const recomputed = computeNormals(plane.clone()).attributes.normal.array;
console.log(`the same bits as from the beginning: ${recomputed.every((x, i) => x === normal.array[i])}`);
plane.dispose();
