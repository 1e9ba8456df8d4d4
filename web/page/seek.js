/* From where a finding is seen. Cameras are tried in order of liking until enough of what is marked is in the picture: the first guess, other directions and distances, then the same as
 * if the rest were not there. What has almost no area is pinned at last. */
import { cross, length, unit } from "./matrix.js";

/* Parts of the picture; thin marks lose some to smoothed edges. */
const FIRST = 0.01, ENOUGH = 0.008, LEAST = 0.005;
/* Distances of the camera; UNKNOWN: to what has a place, but no size. */
const NEAREST = 0.003, WHOLE = 3.4, UNKNOWN = 0.8;
const MOST_TRIED = 16;
/* Pictures that are looked at together: those after one that is liked are not drawn. */
const AT_ONCE = 4;

const angles = (back) => ({ azimuth: (Math.atan2(back[0], back[2]) * 180) / Math.PI, elevation: (Math.asin(Math.max(-1, Math.min(1, back[1]))) * 180) / Math.PI });

/* Along the normal, a little aside of it, from behind, and from all around. */
function directionsOf(normal, up) {
  const side = unit(cross(Math.abs(normal[1]) < 0.9 ? [0, 1, 0] : [1, 0, 0], normal)), over = cross(normal, side);
  const aside = (a, b, sign = 1) => unit(normal.map((x, i) => sign * x + a * side[i] + b * over[i]));
  const first = unit(normal.map((x, i) => x + 0.35 * up[i] * (Math.abs(x) < 0.9 ? 1 : 0)));
  return [length(first) > 0 ? first : normal, normal, normal.map((x) => -x), aside(0.6, 0.3), aside(-0.6, 0.3), aside(0.2, -0.7), aside(0.5, 0.3, -1), aside(-0.5, -0.3, -1), side, side.map((x) => -x), over, over.map((x) => -x)];
}

/* Poses of the camera for a place: { at, normal, size } in the world. */
export function posesOf({ at, normal, size }, up, everywhere) {
  const wholes = [[38, 18], [-142, 18], [128, -20], [-52, 50]].map(([azimuth, elevation]) => ({ azimuth, elevation, distance: WHOLE, centre: [0, 0, 0] }));
  const near = size > 0 ? Math.max(NEAREST, Math.min(WHOLE, 9 * size)) : UNKNOWN, directions = directionsOf(normal, up);
  const poses = directions.map((back, i) => ({ ...angles(back), distance: i === 0 ? near : Math.max(NEAREST, near * (i % 2 ? 0.5 : 0.8)), centre: at }));
  return (everywhere ? [...wholes, ...poses] : [...poses, ...wholes]).slice(0, MOST_TRIED);
}

/* count(poses, through) gives the part of each picture that is marked. Gives { pose, faint, pinned, seen }. */
export async function seek(poses, count) {
  const best = (list) => list.reduce((most, seen, i) => (seen > list[most] ? i : most), 0);
  const [first] = await count(poses.slice(0, 1), false);
  if (first >= FIRST) return { pose: poses[0], faint: false, pinned: false, seen: first };
  /* More than is seen of it as if the rest were not there is not seen beside the rest. */
  const through = await count(poses, true), clearest = best(through), hopeful = poses.flatMap((_, i) => (i && through[i] >= LEAST ? [i] : [])), seen = poses.map(() => 0);
  seen[0] = first;
  for (let from = 0; from < hopeful.length && seen.every((part) => part < ENOUGH); from += AT_ONCE) {
    const some = hopeful.slice(from, from + AT_ONCE);
    (await count(some.map((i) => poses[i]), false)).forEach((part, k) => { seen[some[k]] = part; });
  }
  const liked = seen.findIndex((part) => part >= ENOUGH), chosen = liked >= 0 ? liked : best(seen);
  if (seen[chosen] >= LEAST) return { pose: poses[chosen], faint: false, pinned: false, seen: seen[chosen] };
  if (through[clearest] >= LEAST) return { pose: poses[clearest], faint: true, pinned: false, seen: through[clearest] };
  return { pose: poses[0], faint: true, pinned: true, seen: through[0] };
}
