/* A surface that waves, and that a brush pushes: 200,000 triangles. A plan keeps its normals right; beside them lie those of the flat surface, as they were. */

const COLUMNS = 400, ROWS = 250, WIDTH = 1, DEPTH = 0.625;
const WAVES = [{ kx: 7, kz: 3, speed: 2.1, height: 0.032 }, { kx: -4, kz: 9, speed: 1.5, height: 0.026 }, { kx: 13, kz: -5, speed: 3.2, height: 0.011 }];
const BRUSH = 0.13, PUSH = 0.012, RELAX = 0.985;

export function makeMoving(norma) {
  const across = COLUMNS + 1, points = across * (ROWS + 1);
  const rest = new Float32Array(3 * points), still = new Float32Array(3 * points), indices = new Uint32Array(6 * COLUMNS * ROWS);
  for (let j = 0, k = 0; j <= ROWS; j++)
    for (let i = 0; i < across; i++, k += 3) {
      rest.set([WIDTH * ((2 * i) / COLUMNS - 1), 0, DEPTH * ((2 * j) / ROWS - 1)], k);
      still[k + 1] = 1;
    }
  for (let j = 0, k = 0; j < ROWS; j++)
    for (let i = 0; i < COLUMNS; i++, k += 6) {
      const a = j * across + i, b = a + 1, c = a + across, d = c + 1;
      indices.set([a, c, d, a, d, b], k);
    }

  /* A wave at a time t is sin(phase) cos(t) - cos(phase) sin(t): the phases of points are looked up. */
  const phases = WAVES.map(({ kx, kz }) => {
    const sines = new Float32Array(points), cosines = new Float32Array(points);
    for (let p = 0; p < points; p++) {
      const phase = kx * rest[3 * p] + kz * rest[3 * p + 2];
      sines[p] = Math.sin(phase);
      cosines[p] = Math.cos(phase);
    }
    return { sines, cosines };
  });
  const dents = new Float32Array(points), swell = new Float32Array(points);

  let plan = norma.plan(rest, indices, { weld: "none" });
  plan.positions.set(rest);
  plan.update(plan.positions, { out: plan.normals });
  let touched = null, time = 0;

  /* All of it, at the time that has passed. */
  const wave = (seconds, height) => {
    time += seconds;
    const factors = WAVES.map(({ speed, height: part }) => [part * height * Math.cos(speed * time), part * height * Math.sin(speed * time)]);
    const [[c0, s0], [c1, s1], [c2, s2]] = factors, [a, b, c] = phases, positions = plan.positions;
    for (let p = 0; p < points; p++) {
      swell[p] = a.sines[p] * c0 - a.cosines[p] * s0 + b.sines[p] * c1 - b.cosines[p] * s1 + c.sines[p] * c2 - c.cosines[p] * s2;
      dents[p] *= RELAX;
      positions[3 * p + 1] = swell[p] + dents[p];
    }
    touched = null;
    return update();
  };

  /* Pushes what lies round a point of the surface, and brings only the normals that this can change up to date. */
  const push = (x, z) => {
    const list = [], positions = plan.positions;
    const column = (at) => Math.round(((at / WIDTH + 1) / 2) * COLUMNS), row = (at) => Math.round(((at / DEPTH + 1) / 2) * ROWS);
    for (let j = Math.max(0, row(z - BRUSH)); j <= Math.min(ROWS, row(z + BRUSH)); j++)
      for (let i = Math.max(0, column(x - BRUSH)); i <= Math.min(COLUMNS, column(x + BRUSH)); i++) {
        const p = j * across + i, distance = Math.hypot(rest[3 * p] - x, rest[3 * p + 2] - z) / BRUSH;
        if (distance >= 1) continue;
        dents[p] = Math.max(-0.35, dents[p] - PUSH * (1 - distance * distance) ** 2);
        positions[3 * p + 1] = swell[p] + dents[p];
        list.push(p);
      }
    touched = Uint32Array.from(list);
    return list.length ? update() : 0;
  };

  const flatten = () => {
    dents.fill(0);
    swell.fill(0);
    plan.positions.set(rest);
    touched = null;
    return update();
  };

  /* The milliseconds that it took. */
  const update = () => {
    const begin = performance.now();
    plan.update(plan.positions, { moved: touched, out: plan.normals });
    return performance.now() - begin;
  };

  /* The point of the surface nearest to x, z, and its normal; null beside it. */
  const at = (x, z) => {
    if (Math.abs(x) > WIDTH || Math.abs(z) > DEPTH) return null;
    const p = Math.round(((z / DEPTH + 1) / 2) * ROWS) * across + Math.round(((x / WIDTH + 1) / 2) * COLUMNS);
    return { point: Array.from(plan.positions.subarray(3 * p, 3 * p + 3)), normal: Array.from(plan.normals.subarray(3 * p, 3 * p + 3)) };
  };

  /* By how many degrees the normals left as they were are wrong, at most. */
  const worst = () => {
    const normals = plan.normals;
    let least = 1;
    for (let i = 1; i < normals.length; i += 3) if (normals[i] < least) least = normals[i];
    return (Math.acos(Math.max(-1, least)) * 180) / Math.PI;
  };

  return {
    triangles: indices.length / 3, indices, still, wave, push, flatten, at, worst,
    positions: () => plan.positions, normals: () => plan.normals,
    touched: () => (touched ? touched.length : points),
    free: () => { plan.free(); plan = null; },
  };
}
