/* What the page asks of models, as calls whose arguments and results may travel to a worker and back. Models go by number. */
import { changesOf } from "./changes.js";
import { packTriangles, startEngine } from "./engine.js";
import { seamsOf } from "./seams.js";
import { SHAPES } from "./shapes.js";

const GLTF = new Set(["glTF", "GLB", "B3DM", "I3DM", "CMPT"]);

/* The corners of the box round the points; of no finite point: none. */
function boxOf(positions) {
  const least = [Infinity, Infinity, Infinity], most = least.map((x) => -x);
  for (let i = 0; i < positions.length; i++) {
    const axis = i % 3, x = positions[i];
    if (x < least[axis]) least[axis] = x;
    if (x > most[axis]) most[axis] = x;
  }
  if (![...least, ...most].every(isFinite)) return [];
  return Array.from({ length: 8 }, (_, i) => [0, 1, 2].map((axis) => (i >> axis & 1 ? most : least)[axis]));
}

/* Whether its file says how it is shaded: by normals, or in glTF, where a mesh without any is flat. */
const isShaded = ({ format, meshes }) => GLTF.has(format) || meshes.some(({ stored }) => stored);

/* How far normals are drawn: half of the mean length of the edges, of those that are finite. */
function reachOf(positions) {
  let sum = 0;
  for (let t = 0; t < positions.length; t += 9)
    for (let i = t; i < t + 9; i += 3) {
      const j = i === t + 6 ? t : i + 3, x = positions[i] - positions[j], y = positions[i + 1] - positions[j + 1], z = positions[i + 2] - positions[j + 2];
      sum += Math.sqrt(x * x + y * y + z * z) || 0;
    }
  return (0.5 * sum) / Math.max(1, positions.length / 3);
}

/* What a page knows of a model; its arrays follow by themselves. */
function describe(number, model) {
  const isPlain = ([, part]) => typeof part !== "function";
  const meshes = model.meshes.map((mesh) => ({ ...Object.fromEntries(Object.entries(mesh).filter(isPlain)), reach: reachOf(mesh.positions()) }));
  return { number, name: model.name, format: model.format, unread: model.unread, isShaded: isShaded(model), triangles: model.triangles, faces: model.faces, findings: model.findings, draws: model.draws, meshes, up: model.up,
           arrays: model.meshes.map((mesh) => ({ positions: mesh.positions().slice(), normals: mesh.normals().slice(), box: boxOf(mesh.positions()) })) };
}

/* modules: the bytes of the page's module, and draco.wasm as the page holds it. */
export async function startModels(modules) {
  const engine = await startEngine(modules), models = new Map();
  let next = 1;
  /* options: what its normals are to be from the beginning, which then need not be asked for. */
  const add = (model, options) => {
    if (options) run(model, { ...options, wanted: isShaded(model) ? "stored" : "computed" });
    models.set(next, model);
    return { ...describe(next++, model), options: model.options ?? null };
  };
  const addChanged = ({ model, ...rest }) => ({ ...rest, model: model ? add(model) : null });

  const run = (model, options) => {
    model.options = options;
    const begin = performance.now();
    /* What is stored per facet is held against the facet's own direction. */
    const isFlat = ({ stored }) => (options.errors ? stored === "per facet" : options.wanted === "stored" && !stored && GLTF.has(model.format)), wantedOf = (mesh) => (isFlat(mesh) ? "flat" : options.wanted);
    model.meshes.forEach((mesh, i) => model.compute(i, { ...options, wanted: wantedOf(mesh) }));
    return performance.now() - begin;
  };
  const errorsOf = (model) => ({ worst: Math.max(0, ...model.meshes.map((_, i) => model.errors(i) ?? 0)), values: model.meshes.map((mesh) => mesh.values().slice()) });

  return {
    openShape: (name) => {
      const { positions, indices } = SHAPES[name].make();
      return add(engine.openBytes(packTriangles(positions, indices, SHAPES[name].colour), SHAPES[name].title));
    },
    openTriangles: ({ positions, indices, colour, name }) => add(engine.openBytes(packTriangles(positions, indices, colour), name)),
    /* A pack in base64. */
    openText: (text, name, options) => add(engine.openBytes(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)), name), options),
    /* Unchecked, so that it is seen soon: check follows. */
    openFiles: async (files, path, name, options) => {
      engine.setFiles(files);
      return add(await engine.openFile(path, name, true), options);
    },
    /* What norma check finds in the file of an unchecked model, which from now on is one with findings; null: it is not there any more, or cannot be judged. */
    check: async (number, path, name) => {
      const old = models.get(number), checked = old && (await engine.openFile(path, name));
      if (!checked) return null;
      try { run(checked, old.options); } catch (error) { checked.free(); throw error; }
      models.set(number, checked);
      old.free();
      return checked.findings;
    },
    giveFiles: (files) => engine.setFiles(files),
    fix: async (path, name, options) => addChanged(await engine.fixFile(path, name, options)),
    computeFile: async (path, name, options) => addChanged(await engine.computeFile(path, name, options)),
    /* base, other: { files, path, name }. The files of base are then those that there are. */
    compareFiles: async (base, other) => {
      const within = (folder, { files }) => files.map(({ path, bytes }) => ({ path: `${folder}/${path}`, bytes }));
      engine.setFiles([...within("base", base), ...within("other", other)]);
      try {
        return addChanged(await engine.compareFiles({ path: `base/${base.path}`, name: base.name }, { path: `other/${other.path}`, name: other.name }));
      } finally { engine.setFiles(base.files); }
    },
    /* Of each mesh what a changed copy changed; null: it has other meshes. Leaves the normals of both as they are stored. */
    changes: (one, other) => {
      const [before, after] = [models.get(one), models.get(other)];
      if (before.meshes.length !== after.meshes.length) return null;
      const read = (model, i) => {
        if (model.meshes[i].stored) model.compute(i, { wanted: "stored", weight: "angle", weld: "exact", crease: 60 });
        const { world } = model.draws.find(({ mesh }) => mesh === i) ?? { world: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] }, { determinant } = engine.norma.matrixInfo(world);
        return { positions: model.meshes[i].positions().slice(), normals: model.meshes[i].stored ? model.meshes[i].normals().slice() : null, ball: model.meshes[i].ball, world, determinant, normalMatrix: Array.from(engine.norma.normalMatrix(world)) };
      };
      return before.meshes.map((_, i) => changesOf(read(before, i), read(after, i)));
    },
    /* Of the acid scenes: { tested, sentence, section, patches: [{ id, words, mend, shader, positions, normals, indices }] }, the first patch of each being right. */
    cells: () => engine.cells(),
    free: (number) => {
      models.get(number)?.free();
      models.delete(number);
    },

    /* Normals as the page wants them; errors: by how much the stored ones differ from them. */
    compute: (number, options) => {
      const model = models.get(number), milliseconds = run(model, options);
      return { milliseconds, normals: model.meshes.map((mesh) => mesh.normals().slice()), errors: options.errors ? errorsOf(model) : null };
    },
    /* The time alone. */
    time: (number, options) => run(models.get(number), options),
    marks: (number, finding) => models.get(number).meshes.map((_, i) => models.get(number).marks(i, finding ?? undefined).slice()),
    markOf: (number, mesh, finding) => models.get(number).marks(mesh, finding).slice(),
    place: (number, finding, which) => ({ ...(models.get(number).placeOf(finding, which) ?? { point: null }), points: models.get(number).pointsOf(finding) }),
    /* items: [{ mesh, plain, right }], matrices. */
    worst: (number, items) => items.reduce((most, { mesh, plain, right }) => Math.max(most, models.get(number).worst(mesh, plain, right)), 0),
    /* rays: [{ mesh, from, along }]. The nearest hit, with the normals at its corners. */
    pick: (number, rays) => {
      const model = models.get(number);
      let best = null;
      rays.forEach(({ mesh, from, along }, ray) => {
        const hit = model.pick(mesh, from, along);
        if (hit && (!best || hit.at < best.at)) best = { ...hit, ray, normals: Array.from(model.meshes[mesh].normals().subarray(9 * hit.triangle, 9 * hit.triangle + 9)) };
      });
      return best;
    },
    /* Where images are looked up, of both sets; null: it has none. */
    texcoords: (number) => models.get(number).meshes.map((mesh) => mesh.hasTexcoords.map((has, set) => (has ? mesh.texcoords(set).slice() : null))),
    /* Of vertices; null: it has none. */
    colours: (number) => models.get(number).meshes.map((mesh) => (mesh.hasColours ? mesh.colours().slice() : null)),
    /* Those of the file, otherwise as MikkTSpace makes them of the normals that were computed last; null: there is nothing to make them of. */
    tangents: (number) => models.get(number).meshes.map((mesh) => (mesh.hasTangents || mesh.hasTexcoords.some(Boolean) ? mesh.tangents().slice() : null)),
    /* Both ends of every edge of the file's polygons. */
    wire: (number, index) => {
      const { positions, edges: read, triangles } = models.get(number).meshes[index], edges = read(), p = positions(), ends = new Float32Array(18 * triangles);
      let count = 0;
      for (let i = 0; i < 3 * triangles; i++) {
        if (!edges[i]) continue;
        const next = i % 3 === 2 ? i - 2 : i + 1;
        for (let k = 0; k < 3; k++) { ends[6 * count + k] = p[3 * i + k]; ends[6 * count + 3 + k] = p[3 * next + k]; }
        count++;
      }
      return { ends: ends.slice(0, 6 * count), count };
    },
    seams: (number, index) => {
      const mesh = models.get(number).meshes[index];
      return mesh.hasTexcoords[0] ? seamsOf(mesh.positions().slice(), mesh.texcoords(0).slice()) : { ends: new Float32Array(), count: 0 };
    },
    /* Middles and normals of faces. */
    faceLines: (number, index) => {
      const { positions: read, triangles } = models.get(number).meshes[index], positions = read().slice(), to = engine.norma.faceNormals(positions).slice(); // the call may move the memory that read() looks at
      const from = new Float32Array(3 * triangles);
      for (let t = 0; t < triangles; t++) for (let i = 0; i < 3; i++) from[3 * t + i] = (positions[9 * t + i] + positions[9 * t + 3 + i] + positions[9 * t + 6 + i]) / 3;
      return { from, to };
    },
  };
}

/* The buffers of all arrays within a value: a worker gives them away instead of copying them. */
export function buffersIn(value, found = new Set()) {
  if (ArrayBuffer.isView(value)) found.add(value.buffer);
  else if (value && typeof value === "object") for (const part of Object.values(value)) buffersIn(part, found);
  return [...found];
}
