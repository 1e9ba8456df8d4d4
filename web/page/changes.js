/* What a changed copy of a file changed: its faces beside those of the file. A face is known by its corners' positions, wherever it begins. */

/* Linear colours of faces that are no longer there or as they were, and of those in their place. */
const BEFORE = [196, 82, 3, 255], AFTER = [5, 120, 60, 255];
/* Of a mesh's size, where positions had to be written anew; and where its grids lie. */
const STEP = 2 ** -12, SHIFTS = [0, 1 / 3, 2 / 3];
const NONE = -1;
/* The cosine of a hundredth of a degree. */
const SAME = Math.cos((0.01 * Math.PI) / 180);

export const mix = (a, b) => { let h = Math.imul(a ^ (b + 0x9e3779b9 + (a << 6) + (a >>> 2)), 0x85ebca6b); h ^= h >>> 13; h = Math.imul(h, 0xc2b2ae35); return h ^ (h >>> 16); };

/* A number for the position of each corner. step 0: of its bits. Otherwise of where it lies in the world, to a step of the other's size, the grid being shifted by a part of it: positions that were
 * written anew are a little elsewhere. */
function cornersOf({ positions, ball, world: m }, other, step, shift) {
  const count = positions.length / 3, made = new Int32Array(count), bits = new Int32Array(positions.buffer, positions.byteOffset, positions.length), at = [0, 0, 0];
  for (let i = 0; i < count; i++) {
    for (let axis = 0; axis < 3; axis++) at[axis] = positions[3 * i + axis] * ball[3] + ball[axis];
    const of = (axis) => (step === 0 ? bits[3 * i + axis] & (positions[3 * i + axis] === 0 ? 0 : -1) : Math.round((m[axis] * at[0] + m[4 + axis] * at[1] + m[8 + axis] * at[2] + m[12 + axis] - other[axis]) / step + shift));
    made[i] = mix(mix(mix(0, of(0)), of(1)), of(2));
  }
  return made;
}

/* The corner with the least number. */
const firstOf = (corners, t) => { const [a, b, c] = [corners[3 * t], corners[3 * t + 1], corners[3 * t + 2]]; return a <= b && a <= c ? 0 : b <= c ? 1 : 2; };
const key = (a, b, c) => (mix(mix(a, b), c) >>> 0) * 2 ** 21 + (mix(mix(c, ~a), b) & 0x1fffff);
function keyOf(corners, t, turned) {
  const first = firstOf(corners, t), at = (i) => corners[3 * t + ((first + i) % 3)];
  return turned ? key(at(0), at(2), at(1)) : key(at(0), at(1), at(2));
}

/* Pairs of faces: of each of before that of after; NONE: it has none left. turned: looks for those wound the other way among what is left. */
function pair([before, after], partners, taken, turned) {
  const left = new Map();
  for (let t = after.length / 3 - 1; t >= 0; t--) {
    if (taken[t]) continue;
    const found = keyOf(after, t, false), list = left.get(found);
    if (list) list.push(t); else left.set(found, [t]);
  }
  let count = 0;
  for (let t = 0; t < partners.length; t++) {
    if (partners[t] !== NONE) continue;
    const to = left.get(keyOf(before, t, turned))?.pop();
    if (to === undefined) continue;
    partners[t] = to;
    taken[to] = 1;
    count++;
  }
  return count;
}

/* A normal in the world; matrix: column-major, 3x3. */
const moved = (n, i, m) => [0, 1, 2].map((axis) => m[axis] * n[i] + m[3 + axis] * n[i + 1] + m[6 + axis] * n[i + 2]);

/* Whether two normals differ: in length as well, where nothing else was written anew. */
function differs(isSame, a, i, b, j) {
  const [p, q] = isSame ? [a.normals.subarray(i, i + 3), b.normals.subarray(j, j + 3)] : [moved(a.normals, i, a.normalMatrix), moved(b.normals, j, b.normalMatrix)], [r, s] = [Math.hypot(...p), Math.hypot(...q)];
  if (!(r * s > 0)) return isSame ? p.some((x, k) => !Object.is(x, q[k])) : r !== s;
  return p[0] * q[0] + p[1] * q[1] + p[2] * q[2] < SAME * r * s || (isSame && Math.abs(r - s) > 1e-4);
}

/* Of one mesh, { positions, normals or null, ball, world, normalMatrix, determinant } before and after: how many faces are gone, new, turned, and how many corners have other normals; marks for both,
 * four bytes a corner. */
export function changesOf(before, after) {
  const isSame = [...before.ball, ...before.world].every((x, i) => x === [...after.ball, ...after.world][i]), corners = before.positions.length / 3, others = after.positions.length / 3;
  const size = Math.cbrt(Math.abs(before.determinant)) * before.ball[3], origin = before.world.slice(12, 15), grids = isSame || !(size > 0) ? [[0, 0]] : SHIFTS.map((shift) => [size * STEP, shift]);
  const keys = grids.map(([step, shift]) => [cornersOf(before, origin, step, shift), cornersOf(after, origin, step, shift)]), flips = before.determinant < 0 !== after.determinant < 0;
  const partners = new Int32Array(corners / 3).fill(NONE), taken = new Uint8Array(others / 3), grid = new Uint8Array(corners / 3);
  const marks = { before: new Uint8Array(4 * corners), after: new Uint8Array(4 * others) }, counts = { gone: 0, made: 0, turned: 0, normals: 0 };
  const paint = (list, corner, colour) => list.set(colour, 4 * corner), face = (list, t, colour) => { for (let i = 0; i < 3; i++) paint(list, 3 * t + i, colour); };
  keys.forEach((lists, i) => { const left = partners.slice(); pair(lists, partners, taken, flips); left.forEach((was, t) => { if (was === NONE) grid[t] = i; }); });
  const kept = partners.slice();
  for (const lists of keys) counts.turned += pair(lists, partners, taken, !flips);
  for (let t = 0; t < partners.length; t++) {
    const other = partners[t];
    if (other === NONE) { counts.gone++; face(marks.before, t, BEFORE); continue; }
    if (kept[t] === NONE) { face(marks.before, t, BEFORE); face(marks.after, other, AFTER); continue; }
    if (!after.normals) continue;
    const [from, to] = keys[grid[t]], a = firstOf(from, t), b = firstOf(to, other);
    for (let i = 0; i < 3; i++) {
      const one = 3 * t + ((a + i) % 3), two = 3 * other + ((b + (flips ? 3 - i : i)) % 3);
      if (before.normals && !differs(isSame, before, 3 * one, after, 3 * two)) continue;
      counts.normals++;
      paint(marks.before, one, BEFORE);
      paint(marks.after, two, AFTER);
    }
  }
  taken.forEach((is, t) => { if (!is) { counts.made++; face(marks.after, t, AFTER); } });
  return { counts, marks };
}

const many = (count, one) => `${count.toLocaleString("en-US")} ${one}${count === 1 ? "" : "s"}`;
/* Rules whose faults go with their faces. */
const DROPPED = { N305: "duplicate", N401: "degenerate" };

/* In words, for a list; without counts where the meshes are others. rules: by how much each rule's findings fell, { id, name, before, after }. */
export function wordsOf({ gone, made, turned, normals }, rules) {
  const faces = rules.filter(({ id, before, after }) => DROPPED[id] && before - after === gone), words = [];
  if (gone) words.push(`${many(gone, `${faces.length ? `${DROPPED[faces[0].id]} ` : ""}face`)} removed`);
  if (turned) words.push(`${many(turned, "face")} turned round`);
  if (normals) words.push(`${many(normals, "corner normal")} changed`);
  if (made) words.push(`${many(made, "face")} added`);
  if (gone === 0 && !words.length) words.push("no triangle and no normal of the picture changed");
  return [...words, ...rules.map(({ id, name, before, after }) => `${id} ${name}: ${many(before, "place")} before, ${after ? many(after, "place").replace(/ .*/, "") : "none"} after`)];
}

/* How often each rule finds something, before and after, where it finds less. */
export function rulesThatFell(before, after) {
  const sum = (list, id) => list.reduce((total, finding) => total + (finding.id === id ? finding.places : 0), 0), all = [...(before ?? [])].sort((a, b) => b.severity - a.severity);
  return [...new Map(all.map(({ id, name }) => [id, name]))].map(([id, name]) => ({ id, name, before: sum(before, id), after: sum(after ?? [], id) })).filter((rule) => rule.after < rule.before);
}

/* Errors and warnings, which a fix is about; those whose rule has one, which may yet not help. */
export const problemsIn = (findings) => (findings ?? []).filter(({ severity }) => severity > 1);
export const triedBy = (findings) => problemsIn(findings).filter(({ fix }) => fix > 0);

/* What stays and why: what a note says, of the rules that found something, otherwise what kind of fix its rule has. */
export function whatStays(findings, notes, unsafe) {
  const stays = [...new Map(problemsIn(findings).map((finding) => [finding.id, finding])).values()], of = (id) => notes.find((note) => note.includes(id));
  const why = ({ fix }) => (fix === 0 ? "no program can know what was meant" : fix === 2 && !unsafe ? "its fix would change how the model looks: tick the box to try it" : "its fix would not remove it");
  const isFound = (rule) => (findings ?? []).some(({ id }) => id === rule), ofFound = (note) => note.replace(/^(N\d+, )*N\d+(?=: )/, (rules) => rules.split(", ").filter(isFound).join(", ") || rules);
  return [...notes.map(ofFound), ...stays.filter(({ id }) => !of(id)).map((finding) => `${finding.id} ${finding.name} stays: ${why(finding)}`)];
}
