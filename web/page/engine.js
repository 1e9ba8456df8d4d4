/* The page's module: the package's calls; models, which are packs; documents, which are files read, fixed and written by the library's own code. */
import { bindCalls } from "../package/more-calls.js";
import { allLibraries, makeDecoders } from "../package/decoders.js";
import { moduleOf } from "./inflate.js";

const WEIGHTS = ["angle", "area", "uniform", "max", "angle-area", "visible", "angle-lengths"];
const WELDS = ["exact", "none"];
const WANTED = { computed: 0, flat: 1, stored: 2 };
const FORMATS = ["", "OBJ", "PLY", "STL", "glTF", "GLB", "B3DM", "I3DM", "CMPT", "3MF"];
const SEVERITIES = ["note", "info", "warning", "error"];
const TEXTS = ["id", "name", "unit", "label", "message"];
const NOT_CHECKED = 0xffffffff;
const STORAGE = [null, "per vertex", "per corner", "per facet"];

const UPS = ["y", "z"];
const HAS = { texcoords0: 1, texcoords1: 2, tangents: 4, colours: 8, sides: 16 };

const attributesOf = (bits) => ({ hasTexcoords: [(bits & HAS.texcoords0) > 0, (bits & HAS.texcoords1) > 0], hasTangents: (bits & HAS.tangents) > 0, hasColours: (bits & HAS.colours) > 0, isDoubleSided: (bits & HAS.sides) > 0 });

/* packed: draco.wasm as the page holds it; a page of norma view has none. */
async function compileDraco(packed) {
  if (!packed) throw new Error("This page cannot decode Draco's compression (KHR_draco_mesh_compression). The command line can.");
  return WebAssembly.compile(await moduleOf(packed));
}

export async function startEngine({ bytes, draco: packed }) {
  const decoders = makeDecoders(allLibraries(() => compileDraco(packed)));
  const { instance } = await WebAssembly.instantiate(bytes, decoders.imports);
  const wasm = decoders.serve(instance.exports);
  const norma = bindCalls(wasm);
  const memory = () => wasm.memory.buffer;
  const floats = (at, count) => new Float32Array(memory(), at >>> 0, count);
  const doubles = (at, count) => new Float64Array(memory(), at >>> 0, count);

  const allocate = (size) => {
    const at = wasm.web_allocate(size) >>> 0;
    if (!at) throw new Error(`There is no room for ${size} bytes.`);
    return at;
  };
  const copyIn = (data) => {
    const at = allocate(data.byteLength);
    new Uint8Array(memory(), at, data.byteLength).set(new Uint8Array(data.buffer, data.byteOffset, data.byteLength));
    return at;
  };
  const textAt = (at) => {
    const all = new Uint8Array(memory(), at >>> 0, 1000);
    return new TextDecoder().decode(all.slice(0, all.indexOf(0)));
  };
  const longTextAt = (at) => {
    const all = new Uint8Array(memory()), from = at >>> 0;
    return new TextDecoder().decode(all.slice(from, all.indexOf(0, from)));
  };
  /* Room that a call borrows. */
  const lend = (sizes, work) => {
    const places = sizes.map(allocate);
    try { return work(...places); } finally { places.forEach((at) => wasm.web_release(at)); }
  };

  /* A model over the pack at that address, which it takes over. */
  const openPack = (pack, size, name) => {
    const address = wasm.model_of_pack(pack, size) >>> 0;
    if (!address) throw new Error(`${name}: its meshes cannot be drawn: out of memory, or not what the page expects.`);
    const meshes = Array.from({ length: wasm.model_mesh_count(address) }, (_, i) => {
      const triangles = wasm.model_triangles(address, i);
      return {
        triangles, corners: 3 * triangles, faces: wasm.model_faces(address, i), vertices: wasm.model_vertices(address, i), decimated: wasm.model_is_decimated(address, i) !== 0, stored: STORAGE[wasm.model_storage(address, i)],
        colour: Array.from(floats(wasm.model_colour(address, i), 4)), ball: lend([32], (at) => (wasm.model_ball(address, i, at), Array.from(doubles(at, 4)))),
        positions: () => floats(wasm.model_draw_positions(address, i), 9 * triangles), normals: () => floats(wasm.model_draw_normals(address, i), 9 * triangles),
        ...attributesOf(wasm.model_attributes(address, i)), material: wasm.model_material(address, i) >>> 0, title: longTextAt(wasm.model_name(address, i)),
        texcoords: (set) => floats(wasm.model_texcoords(address, i, set), 6 * triangles), tangents: () => floats(wasm.model_tangents(address, i), 12 * triangles),
        colours: () => new Uint16Array(memory(), wasm.model_colours(address, i) >>> 0, 12 * triangles),
        edges: () => lend([3 * triangles], (at) => (wasm.model_edges(address, i, at), new Uint8Array(memory(), at, 3 * triangles).slice())),
        values: () => floats(wasm.model_draw_values(address, i), 3 * triangles),
      };
    });
    const draws = Array.from({ length: wasm.model_draw_count(address) }, (_, i) => ({ mesh: wasm.model_draw_mesh(address, i), world: Array.from(doubles(wasm.model_draw_world(address, i), 16)) }));
    const readFinding = (_, index) => lend([40], (at) => {
      wasm.model_finding_numbers(address, index, at);
      const [severity, mesh, draw, places, worst] = doubles(at, 5), text = Object.fromEntries(TEXTS.map((name, which) => [name, longTextAt(wasm.model_finding_text(address, index, which))]));
      return { index, severity, grade: SEVERITIES[severity], mesh, draw, places, worst, ...text, fix: withText(text.id, (at) => wasm.rule_fix(at)) };
    });
    const findingCount = wasm.model_finding_count(address) >>> 0;
    const compute = (mesh, { wanted, weight, weld, crease }) => {
      const result = wasm.model_compute(address, mesh, WANTED[wanted], WEIGHTS.indexOf(weight), WELDS.indexOf(weld), crease);
      if (result !== 0) throw new Error(textAt(wasm.web_result_text(result)));
    };
    return {
      name, address, meshes, draws, compute, up: UPS[["OBJ", "PLY", "STL", "3MF"].includes(FORMATS[wasm.model_format(address)]) ? wasm.model_guess_up(address) : 0], format: FORMATS[wasm.model_format(address)], unread: wasm.model_unread_count(address),
      triangles: meshes.reduce((sum, mesh) => sum + mesh.triangles, 0), faces: meshes.reduce((sum, mesh) => sum + mesh.faces, 0),
      /* What norma check says; null: it was not asked. */
      findings: findingCount === NOT_CHECKED ? null : Array.from({ length: findingCount }, readFinding),
      /* Four bytes for each corner: what a finding names, in colour; without one, what all do. */
      marks: (mesh, finding = NOT_CHECKED) => {
        const at = wasm.model_marks(address, mesh, finding) >>> 0;
        if (!at) throw new Error("There is no room for the colours of what was found.");
        return new Uint8Array(memory(), at, 12 * meshes[mesh].triangles);
      },
      /* Where a finding is worst, in the space of positions(), from where it is seen, how long its edges are; null: nowhere. */
      placeOf: (finding, which) => lend([56], (at) => {
        if (!wasm.model_finding_place(address, finding, which, at)) return null;
        const [x, y, z, u, v, w, size] = doubles(at, 7);
        return { point: [x, y, z], direction: [u, v, w], size };
      }),
      /* Where all of it is, at most so many points, in the space of positions(). */
      pointsOf: (finding, most = 300) => lend([24 * most], (at) => Array.from(doubles(at, 3 * wasm.model_finding_points(address, finding, most, at)))),
      /* Degrees between stored and computed, per corner in values(); the largest is returned, null where nothing is stored. */
      errors: (mesh) => { const worst = wasm.model_errors(address, mesh); return worst < 0 ? null : worst; },
      /* The largest angle between a normal through one 3x3 and through another, in degrees. */
      worst: (mesh, plain, right) => lend([72, 72], (a, b) => {
        doubles(a, 9).set(plain);
        doubles(b, 9).set(right);
        const measure = wasm.model_worst(address, mesh, a, b), far = measure > 1, m = far ? 2 - measure : measure;
        const acute = (Math.atan2(m, 1 - m) * 180) / Math.PI;
        return far ? 180 - acute : acute;
      }),
      pick: (mesh, from, along) => lend([48, 40], (a, b) => {
        doubles(a, 6).set([...from, ...along]);
        if (!wasm.model_pick(address, mesh, a, b)) return null;
        const [at, triangle, ...weights] = doubles(b, 5);
        return { at, triangle, weights };
      }),
      free: () => wasm.model_free(address),
    };
  };

  const openBytes = (pack, name) => openPack(copyIn(pack), pack.byteLength, name);

  /* ---- files and documents */
  const withText = (text, work) => {
    const at = copyIn(new TextEncoder().encode(`${text}\0`));
    try { return work(at); } finally { wasm.web_release(at); }
  };
  /* The files that there are from now on: [{ path, bytes }]. */
  const setFiles = (files) => {
    wasm.files_clear();
    for (const { path, bytes } of files)
      withText(path, (at) => { if (!wasm.files_add(at, copyIn(bytes), bytes.byteLength)) throw new Error(`${path}: out of memory`); });
  };
  /* What was written, taken out of the module. */
  const takeWritten = () => {
    const written = Array.from({ length: wasm.files_count() }, (_, i) => i).filter((i) => wasm.files_written(i))
      .map((i) => ({ path: longTextAt(wasm.files_path(i)), bytes: new Uint8Array(memory(), wasm.files_bytes(i) >>> 0, wasm.files_size(i)).slice() }));
    wasm.files_drop_written();
    return written;
  };
  /* Calls with room for an error, whose text is thrown where the call says so. */
  const orError = (path, call, failed) => lend([wasm.model_error_size()], (error) => {
    const result = call(error);
    if (failed(result)) throw new Error(textAt(wasm.model_error_text(error)) || `${path}: out of memory`);
    return result;
  });
  const isSet = (result) => result !== 0, isNull = (result) => !result;

  /* Opens one of the files, for as long as work takes. */
  const withDocument = (path, work) => {
    const document = orError(path, (error) => withText(path, (at) => wasm.document_open(at, error)), isNull);
    try { return work(document); } finally { wasm.document_close(document); }
  };
  const packOf = (document, path, name, unchecked = false) => lend([8], (size) => {
    const pack = orError(path, (error) => wasm.document_pack(document, unchecked ? 1 : 0, size, error), isNull) >>> 0;
    return openPack(pack, new Uint32Array(memory(), size, 1)[0], name);
  });
  const openFile = (path, name, unchecked = false) => decoders.reading(() => withDocument(path, (document) => packOf(document, path, name, unchecked)), (model) => model.free());
  const notesOf = (document, from = 0) => [...new Set(Array.from({ length: wasm.document_note_count(document) - from }, (_, i) => longTextAt(wasm.document_note(document, from + i))))];

  /* A changed copy of one of the files: its model, and the files that it consists of. change(document, numbers) fills the numbers, of which the first says whether anything changed. */
  const changeOnce = (path, name, change, written = (file) => file) => withDocument(path, (document) => lend([24], (numbers) => {
    const before = wasm.document_note_count(document);
    orError(path, (error) => change(document, numbers, error), isSet);
    const [isChanged, verticesBefore, verticesAfter] = doubles(numbers, 3), to = `norma/${written(path.split("/").pop())}`;
    if (!isChanged) return { changed: false, notes: notesOf(document, before) };
    const model = packOf(document, path, name);
    orError(path, (error) => withText(to, (at) => wasm.document_save(document, at, error)), isSet);
    return { changed: true, model, files: takeWritten().map((file) => ({ ...file, path: file.path.replace(/^norma\//, "") })), verticesBefore, verticesAfter, notes: notesOf(document, before) };
  }));
  const changed = (...args) => decoders.reading(() => changeOnce(...args), ({ model }) => model?.free());
  const fixFile = (path, name, { unsafe = false } = {}) => changed(path, name, (document, numbers, error) => wasm.document_fix(document, unsafe ? 1 : 0, numbers, error), (file) => file.replace(/(\.[^.]*)?$/, ".fixed$1"));
  /* crease: degrees; null: as norma compute does it unasked. */
  const computeFile = (path, name, { weight, weld, crease }) =>
    changed(path, name, (document, numbers, error) => wasm.document_compute(document, WEIGHTS.indexOf(weight), WELDS.indexOf(weld), crease ?? NaN, numbers, error));

  const readDifferences = (pair, model) => lend([13 * 8], (at) => {
    wasm.compared_numbers(pair, at);
    const [corners, missing, ...rest] = doubles(at, 13), valuesOf = (distances) => {
      if (!wasm.compared_values(pair, model.address, distances)) throw new Error("There is no room for the differences.");
      return model.meshes.map((mesh) => mesh.values().slice());
    };
    return { corners, missing, degrees: rest.slice(0, 3), distances: rest.slice(3, 6), computed: rest.slice(6, 8).map(Boolean), worst: rest.slice(8), how: textAt(wasm.compared_how(pair)), values: { deviation: valuesOf(0), distance: valuesOf(1) } };
  });
  /* Two of the files as norma compare compares them: { model of other, what both differ by, also at each corner }. base, other: { path, name }. */
  const compareOnce = (base, other) => withDocument(base.path, (first) => withDocument(other.path, (second) => {
    const model = packOf(second, other.path, other.name);
    let pair = 0;
    try {
      pair = orError(other.path, (error) => withText(base.name, (baseName) => withText(other.name, (otherName) => wasm.compared_open(first, second, baseName, otherName, error))), isNull);
      return { model, ...readDifferences(pair, model) };
    } catch (error) {
      model.free();
      throw error;
    } finally {
      if (pair) wasm.compared_close(pair);
    }
  }));
  const compareFiles = (base, other) => decoders.reading(() => compareOnce(base, other), ({ model }) => model?.free());

  const CELL_TEXTS = { tested: 0, sentence: 1, section: 2 }, PATCH_TEXTS = { id: 0, words: 1, mend: 2 };
  /* Functions without their comments. */
  const shaderOf = (cell, patch) => lend([8], (at) => {
    const texts = [];
    while (wasm.patch_shader(cell, patch, texts.length, at)) {
      const [from, size] = new Uint32Array(memory(), at, 2);
      texts.push(new TextDecoder().decode(new Uint8Array(memory(), from, size)).replace(/^\/\/.*\n/gm, ""));
    }
    return texts.join("\n");
  });
  const readPatch = (cell, patch) => {
    const made = wasm.patch_make(cell, patch) >>> 0;
    if (!made) throw new Error("There is no room for the lesson's scenes.");
    const [points, corners, positions, normals, indices] = new Uint32Array(memory(), made, 5);
    const texts = Object.fromEntries(Object.entries(PATCH_TEXTS).map(([name, which]) => [name, longTextAt(wasm.patch_text(cell, patch, which))]));
    try {
      return { ...texts, shader: shaderOf(cell, patch), positions: floats(positions, 3 * points).slice(), normals: floats(normals, 3 * points).slice(), indices: new Uint32Array(memory(), indices, corners).slice() };
    } finally { wasm.patch_free(made); }
  };
  const cells = () => Array.from({ length: wasm.cell_count() }, (_, cell) => ({
    ...Object.fromEntries(Object.entries(CELL_TEXTS).map(([name, which]) => [name, longTextAt(wasm.cell_text(cell, which))])),
    patches: Array.from({ length: wasm.cell_patches(cell) }, (__, patch) => readPatch(cell, patch)),
  })).filter(({ patches }) => patches.length > 1);

  return { norma, cells, compareFiles, openBytes, setFiles, openFile, fixFile, computeFile };
}

/* Triangles as a pack: web/page/model/model_pack.h. indices: four bytes each. */
export function packTriangles(positions, indices, colour = [0.8, 0.8, 0.8]) {
  const HEAD = 40, MESH = 104, DRAW = 136, NONE = 0xffffffff;
  const eight = (size) => Math.ceil(size / 8) * 8;
  const positionsAt = HEAD, indicesAt = positionsAt + eight(positions.byteLength), meshAt = indicesAt + eight(indices.byteLength), drawAt = meshAt + eight(MESH), nameAt = drawAt + DRAW;
  const pack = new Uint8Array(nameAt + 8), view = new DataView(pack.buffer);
  const words = (at, list) => list.forEach((word, i) => view.setUint32(at + 4 * i, word, true));
  words(0, [0x354d524e, pack.length, 1, meshAt, 1, drawAt, 0, 0, NONE, 0]);
  pack.set(new Uint8Array(positions.buffer), positionsAt);
  pack.set(new Uint8Array(indices.buffer), indicesAt);
  words(meshAt, [positions.length / 3, positionsAt, 0, indices.length, indicesAt, indices.length / 3, NONE, NONE, 0, 0, 0, NONE]);
  [...colour, 1].forEach((x, i) => view.setFloat32(meshAt + 48 + 4 * i, x, true));
  words(meshAt + 64, [1, 0, nameAt, NONE, NONE, NONE, NONE, NONE, NONE, 0]);
  for (let i = 0; i < 16; i += 5) view.setFloat64(drawAt + 8 * i, 1, true);
  return pack;
}
