/* The calls on a module's exports. Every argument is checked before the heap is touched. */
import { makeChecks, NormaError, RESULT } from "./arguments.js";
import { makeHeap } from "./heap.js";

const KINDS = ["identity", "translation", "rotation", "uniform-scale", "non-uniform-scale", "shear", "singular"];
const SHORTCUTS = ["none", "rotation", "uniform-scale", "axis-scale"];
const DEGREES = 180 / Math.PI;

export function bindCalls(wasm) {
  const heap = makeHeap(wasm, (bytes) => check.fail(RESULT.MEMORY, `${bytes} bytes of the heap`));
  const check = makeChecks((result) => heap.text(wasm.web_result_text(result)));
  const expect = (result) => { if (result !== RESULT.OK) check.fail(result); };

  /* positions, indices and options, checked; indices may be left out. */
  const readMesh = (positions, indices, given) => {
    const leftOut = given === undefined && indices !== null && typeof indices === "object" && !ArrayBuffer.isView(indices) && !Array.isArray(indices);
    const options = check.options(leftOut ? indices : given);
    const used = leftOut ? undefined : indices;
    const format = check.vectors(positions, "positions");
    const corners = check.indices(used, positions);
    const weight = check.weight(options.weight ?? "angle");
    const [weld, distance] = check.weld(options.weld ?? "exact");
    const nonManifold = check.nonManifold(options.nonManifold ?? "hard"), fallback = check.fallback(options.fallback ?? "zero");
    return { positions, indices: used, options, format, corners, vertices: positions.length / 3, weight, weld, distance, nonManifold, fallback };
  };

  /* The same as the exports take it. */
  const hand = (mesh, lender) => [
    lender.input(mesh.positions), mesh.vertices, mesh.format,
    mesh.indices ? lender.input(mesh.indices) : 0, mesh.corners, mesh.indices ? mesh.indices.BYTES_PER_ELEMENT : 4,
    mesh.weight, mesh.weld, mesh.distance, mesh.nonManifold, mesh.fallback,
  ];

  /* One normal for each of count elements. */
  const normals = (mesh, count, call, ...more) => {
    const out = check.output(mesh.options.out, 3 * count);
    return heap.lend((lender) => {
      const written = lender.output(out, 3 * count);
      expect(call(...hand(mesh, lender), ...more, written.at, count));
      return written.fetch();
    });
  };

  const faceNormals = (positions, indices, options) => {
    const mesh = readMesh(positions, indices, options);
    return normals(mesh, mesh.corners / 3, wasm.web_face_normals);
  };

  const vertexNormals = (positions, indices, options) => {
    const mesh = readMesh(positions, indices, options);
    return normals(mesh, mesh.vertices, wasm.web_vertex_normals);
  };

  const cornerNormals = (positions, indices, options) => {
    const mesh = readMesh(positions, indices, options);
    return normals(mesh, mesh.corners, wasm.web_corner_normals, check.degrees(mesh.options.crease ?? 60, "crease"));
  };

  const split = (positions, indices, options) => {
    const mesh = readMesh(positions, indices, options);
    const crease = check.degrees(mesh.options.crease ?? 60, "crease");
    const most = mesh.corners;
    return heap.lend((lender) => {
      const corners = lender.block(4 * most), sources = lender.block(4 * most), normalsAt = lender.block(12 * most), count = lender.block(4);
      expect(wasm.web_split(...hand(mesh, lender), crease, corners, most, sources, normalsAt, most, count));
      const vertices = new Uint32Array(wasm.memory.buffer, count, 1)[0];
      const result = { indices: new Uint32Array(most), sourceVertices: new Uint32Array(vertices), normals: new Float32Array(3 * vertices) };
      lender.copyOut(corners, result.indices);
      lender.copyOut(sources, result.sourceVertices);
      lender.copyOut(normalsAt, result.normals);
      return result;
    });
  };

  const matrices = (models, count, options) => {
    const winding = check.winding(options.winding ?? "reversed");
    const out = check.output(options.out, 9 * count);
    return heap.lend((lender) => {
      const written = lender.output(out, 9 * count);
      const result = wasm.web_normal_matrices(lender.input(models), count, winding, written.at);
      /* A model that is not finite has a matrix of zeros, and the others are done. */
      if (result === RESULT.OK || result === RESULT.ARGUMENT) written.fetch();
      expect(result);
      return out;
    });
  };

  const normalMatrix = (model, options) => matrices(check.floats(model, 16, "model"), 1, check.options(options));

  const normalMatrices = (models, options) => {
    const floats = check.floats(models, 16, "models", true);
    return matrices(floats, floats.length / 16, check.options(options));
  };

  const matrixInfo = (model) => {
    const floats = check.floats(model, 16, "model");
    return heap.lend((lender) => {
      const at = lender.block(80);
      expect(wasm.web_matrix_info(lender.input(floats), at));
      const [determinant, anisotropy, worst, x, y, z, kind, rank, mirrored, shortcut] = new Float64Array(wasm.memory.buffer, at, 10);
      return { kind: KINDS[kind], rank, mirrored: mirrored !== 0, determinant, anisotropy, worstErrorDeg: worst * DEGREES,
               worstNormal: Float32Array.of(x, y, z), shortcut: SHORTCUTS[shortcut] };
    });
  };

  const transformNormals = (matrix, vectors, options) => {
    const floats = check.floats(matrix, 9, "normalMatrix");
    const format = check.vectors(vectors, "normals");
    const out = check.output(check.options(options).out, vectors.length);
    return heap.lend((lender) => {
      const written = lender.output(out, vectors.length);
      expect(wasm.web_transform_normals(lender.input(floats), lender.input(vectors), vectors.length / 3, format, written.at));
      return written.fetch();
    });
  };

  /* A plan's own room in the heap, for callers who want nothing copied: made when it is first asked for. */
  const makeRoom = (length) => {
    let at = 0;
    return {
      array: () => new Float32Array(wasm.memory.buffer, (at ||= heap.allocate(4 * length)), length),
      free: () => { if (at) wasm.web_release(at); at = 0; },
    };
  };

  const createPlan = (mesh, per, crease) => heap.lend((lender) => {
    const result = lender.block(4);
    const address = wasm.web_plan_create(...hand(mesh, lender), per, crease, result) >>> 0;
    expect(new Int32Array(wasm.memory.buffer, result, 1)[0]);
    return address;
  });

  const plan = (positions, indices, given) => {
    const mesh = readMesh(positions, indices, given);
    const per = check.element(mesh.options.per ?? "vertex"), { vertices } = mesh;
    const crease = check.degrees(mesh.options.crease ?? (per === 0 ? 180 : 60), "crease");
    const count = per === 0 ? vertices : mesh.corners;
    let address = createPlan(mesh, per, crease);
    const rooms = { positions: makeRoom(3 * vertices), normals: makeRoom(3 * count) };
    const alive = () => address || check.wrong("this plan has been freed");

    const update = (now, options) => {
      alive();
      const { moved: list, out: array } = check.options(options);
      const format = check.vectors(now, "positions");
      if (now.length !== 3 * vertices) check.wrong(`positions: ${now.length / 3} vectors where the plan has ${vertices}`);
      const moved = check.moved(list, vertices);
      if (moved && !array) check.wrong("moved: needs out, which holds the normals of the last update");
      const out = check.output(array, 3 * count);
      return heap.lend((lender) => {
        const written = lender.output(out, 3 * count, moved !== null);
        expect(wasm.web_plan_update(address, lender.input(now), vertices, format, moved ? lender.input(moved) : 0, moved ? moved.length : 0, written.at, count));
        return written.fetch();
      });
    };
    const free = () => {
      if (address) wasm.web_plan_free(address);
      address = 0;
      rooms.positions.free();
      rooms.normals.free();
    };
    return {
      count, update, free,
      get bytes() { return wasm.web_plan_bytes(alive()) >>> 0; },
      get positions() { return alive() && rooms.positions.array(); },
      get normals() { return alive() && rooms.normals.array(); },
    };
  };

  return { version: heap.text(wasm.web_version()), faceNormals, vertexNormals, cornerNormals, split, plan, normalMatrix, normalMatrices, matrixInfo, transformNormals };
}

export { NormaError };
