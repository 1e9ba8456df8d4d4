/* The calls on a module's exports. Every argument is checked before the heap is touched. */
import * as given from "./arguments.js";
import { NormaError, RESULT, fail } from "./arguments.js";
import { makeHeap } from "./heap.js";
import { makePlans } from "./plans.js";

const KINDS = ["identity", "translation", "rotation", "uniform-scale", "non-uniform-scale", "shear", "singular"];
const SHORTCUTS = ["none", "rotation", "uniform-scale", "axis-scale"];
const DEGREES = 180 / Math.PI;
const COUNTS = ["degenerateFaces", "nonFinite", "unreferenced", "cancelled", "nonManifoldEdges", "windingConflicts"];
const MESH_OPTIONS = "weight weld nonManifold fallback report";
const TEXCOORD_SIZE = 2, TANGENT_SIZE = 4, NO_MEMORY = 0xffffffff;

/* check: (bytes, options) => a promise of what norma check finds; undefined where the module has no use for it. */
export function bindCalls(wasm, check) {
  const heap = makeHeap(wasm.memory, wasm.web_allocate, wasm.web_release, (bytes) => fail(`out of memory: ${bytes} bytes of WebAssembly memory are not to be had`, RESULT.MEMORY));
  const expect = (result, mesh) => {
    if (result === RESULT.OK) return;
    if (result === RESULT.INDEX) given.failAtIndex(mesh.indices, mesh.vertices);
    if (result === RESULT.MEMORY) fail("out of memory: the mesh and what the call needs do not fit into WebAssembly memory", RESULT.MEMORY);
    fail(heap.text(wasm.web_result_text(result)), result);
  };

  /* positions, indices and options, checked; indices may be left out. */
  const readMesh = (positions, indices, options, known) => {
    const leftOut = options === undefined && indices !== null && typeof indices === "object" && !ArrayBuffer.isView(indices) && !Array.isArray(indices);
    const chosen = given.options(leftOut ? indices : options, `${MESH_OPTIONS} ${known}`);
    const used = leftOut || indices === null ? undefined : indices;
    const view = given.vectors(positions, "positions");
    const [weld, distance] = given.weld(chosen.weld);
    return { view, indices: used, options: chosen, corners: given.corners(used, view.count), vertices: view.count, weight: given.weight(chosen.weight), weld, distance,
             nonManifold: given.nonManifold(chosen.nonManifold), fallback: given.fallback(chosen.fallback), report: given.flag(chosen.report, "report") };
  };

  /* The same as the exports take it. */
  const hand = ({ view, indices, corners, weight, weld, distance, nonManifold, fallback }, lender) => [
    lender.input(view.array), view.count, view.stride, view.format, indices ? lender.input(indices) : 0, corners, indices ? indices.BYTES_PER_ELEMENT : 4,
    weight, weld, distance, nonManifold, fallback,
  ];

  /* Hands work the address of a report, 0 where none was asked for; gives read, which reads it. */
  const lendReport = (lender, wanted) => {
    const at = wanted ? lender.block(wasm.web_report_size()) : 0;
    const read = () => {
      const counts = lender.block(8 * COUNTS.length);
      wasm.web_report_counts(at, counts);
      const numbers = heap.doubles(counts, COUNTS.length);
      return Object.fromEntries(COUNTS.map((name, i) => [name, numbers[i]]));
    };
    return { at, read };
  };

  /* One normal for each of count elements. */
  const normals = (mesh, count, call, ...more) => {
    const out = given.output(mesh.options.out, 3 * count);
    return heap.lend((lender) => {
      const written = lender.output(out, 3 * count), report = lendReport(lender, mesh.report);
      expect(call(...hand(mesh, lender), written.at, count, report.at, ...more), mesh);
      const computed = written.fetch();
      return mesh.report ? { normals: computed, report: report.read() } : computed;
    });
  };

  const faceNormals = (positions, indices, options) => {
    const mesh = readMesh(positions, indices, options, "out");
    return normals(mesh, mesh.corners / 3, wasm.web_face_normals);
  };

  const vertexNormals = (positions, indices, options) => {
    const mesh = readMesh(positions, indices, options, "out");
    return normals(mesh, mesh.vertices, wasm.web_vertex_normals);
  };

  const cornerNormals = (positions, indices, options) => {
    const mesh = readMesh(positions, indices, options, "crease out");
    return normals(mesh, mesh.corners, wasm.web_corner_normals, given.crease(mesh.options.crease));
  };

  const split = (positions, indices, options) => {
    const mesh = readMesh(positions, indices, options, "crease");
    const crease = given.crease(mesh.options.crease), most = mesh.corners;
    return heap.lend((lender) => {
      const report = lendReport(lender, mesh.report);
      const corners = lender.block(4 * most), sources = lender.block(4 * most), normalsAt = lender.block(12 * most), count = lender.block(4);
      expect(wasm.web_split(...hand(mesh, lender), normalsAt, most, report.at, crease, corners, most, sources, count), mesh);
      const vertices = new Uint32Array(wasm.memory.buffer, count, 1)[0];
      const result = { indices: new Uint32Array(most), sourceVertices: new Uint32Array(vertices), normals: new Float32Array(3 * vertices) };
      lender.copyOut(corners, result.indices);
      lender.copyOut(sources, result.sourceVertices);
      lender.copyOut(normalsAt, result.normals);
      return mesh.report ? { ...result, report: report.read() } : result;
    });
  };

  const fetch = (lender, at, array) => (lender.copyOut(at, array), array);
  const countOr = (count) => (count === NO_MEMORY ? expect(RESULT.MEMORY) : count);

  /* A mesh whose old vertices keep their numbers, and with them whatever else is stored for them; what a crease or a seam needs twice follows behind. sources: for each vertex that follows, the
   * one it is a copy of. firsts: for each vertex its first corner, -1 without one. */
  const verticesOf = (lender, { vertices, corners }, { count, indicesAt, sourcesAt, firstsAt, values }) => ({
    count, indices: fetch(lender, indicesAt, new Uint32Array(corners)), sources: fetch(lender, sourcesAt, new Uint32Array(count - vertices)), values,
    firsts: firstsAt ? fetch(lender, firstsAt, new Int32Array(count)) : null,
  });

  /* For the package's own use: normals with creases. isWhole: every vertex is one of a face. firsts: whether wanted. */
  const creaseVertices = (positions, indices, options, firsts) => {
    const mesh = readMesh(positions, indices, options, "crease"), crease = given.crease(mesh.options.crease), most = mesh.corners;
    return heap.lend((lender) => {
      const report = lendReport(lender, mesh.report), partCount = lender.block(4);
      const [indicesAt, sourcesAt, normalsAt] = [4, 4, 12].map((size) => lender.block(size * most));
      expect(wasm.web_split(...hand(mesh, lender), normalsAt, most, report.at, crease, indicesAt, most, sourcesAt, partCount), mesh);
      const parts = new Uint32Array(wasm.memory.buffer, partCount, 1)[0], valuesAt = lender.block(12 * (mesh.vertices + parts));
      const count = countOr(wasm.web_keep_numbers(indicesAt, most, sourcesAt, parts, mesh.vertices, normalsAt, valuesAt, lender.block(4 * parts)) >>> 0), isWhole = count === parts;
      const firstsAt = firsts || !isWhole ? lender.block(4 * count) : 0;
      if (firstsAt) wasm.web_first_corners(indicesAt, most, firstsAt, count);
      const made = verticesOf(lender, mesh, { count, indicesAt, sourcesAt, firstsAt, values: fetch(lender, valuesAt, new Float32Array(3 * count)) });
      return { ...made, isWhole, report: mesh.report ? report.read() : undefined };
    });
  };

  /* Tangents of corners, at an address, as those of vertices. */
  const mergeTangents = (lender, mesh, handedIndices, tangentsAt) => {
    const { vertices, corners, indices } = mesh, size = TANGENT_SIZE, indexSize = indices ? indices.BYTES_PER_ELEMENT : 4;
    const indicesAt = lender.block(4 * corners), oldAt = lender.block(4 * size * vertices), firstsAt = lender.block(4 * (vertices + corners));
    const count = countOr(wasm.web_merge_corners(tangentsAt, size, handedIndices, indexSize, corners, vertices, indicesAt, oldAt, firstsAt) >>> 0), added = count - vertices;
    const addedAt = lender.block(4 * size * added), sourcesAt = lender.block(4 * added), values = new Float32Array(size * count);
    wasm.web_gather_corners(tangentsAt, size, handedIndices, indexSize, firstsAt + 4 * vertices, added, addedAt, sourcesAt);
    lender.copyOut(oldAt, values, size * vertices);
    lender.copyOut(addedAt, values.subarray(size * vertices));
    return verticesOf(lender, mesh, { count, indicesAt, sourcesAt, firstsAt, values });
  };

  /* One value for each vertex or for each corner: which of the two, by how many there are. */
  const elementOf = (view, mesh, what) => {
    if (view.count === mesh.vertices) return 0;
    if (view.count === mesh.corners) return 1;
    return fail(`${what}: ${view.count} values, but the mesh has ${mesh.vertices} vertices and ${mesh.corners} corners`);
  };

  const readTangents = (positions, normalVectors, texcoords, indices, options, known) => {
    const leftOut = options === undefined && indices !== null && typeof indices === "object" && !ArrayBuffer.isView(indices) && !Array.isArray(indices);
    const chosen = given.options(leftOut ? indices : options, `mode weight report ${known}`);
    const used = leftOut || indices === null ? undefined : indices;
    const view = given.vectors(positions, "positions"), mesh = { view, indices: used, vertices: view.count, corners: given.corners(used, view.count), options: chosen };
    mesh.normal = given.vectors(normalVectors, "normals");
    mesh.texcoord = given.vectors(texcoords, "texcoords", TEXCOORD_SIZE);
    mesh.ofNormals = elementOf(mesh.normal, mesh, "normals");
    mesh.ofTexcoords = elementOf(mesh.texcoord, mesh, "texcoords");
    mesh.mode = given.tangentMode(chosen.mode);
    mesh.weight = given.weight(chosen.weight);
    mesh.report = given.flag(chosen.report, "report");
    return mesh;
  };

  /* Writes them at an address. */
  const computeTangents = (lender, mesh, indicesAt, at, report) => {
    const { view, indices, normal, texcoord } = mesh;
    expect(wasm.web_corner_tangents(lender.input(view.array), view.count, view.stride, view.format, indicesAt, mesh.corners, indices ? indices.BYTES_PER_ELEMENT : 4,
                                    lender.input(normal.array), normal.count, normal.stride, normal.format, mesh.ofNormals,
                                    lender.input(texcoord.array), texcoord.count, texcoord.stride, texcoord.format, mesh.ofTexcoords, mesh.mode, mesh.weight, at, mesh.corners, report.at), mesh);
  };
  const countsOfTangents = ({ degenerateFaces: degenerate, nonFinite, cancelled }) => ({ degenerate, nonFinite, cancelled });

  const tangents = (positions, normalVectors, texcoords, indices, options) => {
    const mesh = readTangents(positions, normalVectors, texcoords, indices, options, "out"), out = given.output(mesh.options.out, TANGENT_SIZE * mesh.corners);
    return heap.lend((lender) => {
      const written = lender.output(out, TANGENT_SIZE * mesh.corners), report = lendReport(lender, mesh.report);
      computeTangents(lender, mesh, mesh.indices ? lender.input(mesh.indices) : 0, written.at, report);
      const computed = written.fetch();
      return mesh.report ? { tangents: computed, report: countsOfTangents(report.read()) } : computed;
    });
  };

  /* For the package's own use: tangents as those of vertices. */
  const tangentVertices = (positions, normalVectors, texcoords, indices, options) => {
    const mesh = readTangents(positions, normalVectors, texcoords, indices, options, "");
    return heap.lend((lender) => {
      const report = lendReport(lender, mesh.report), tangentsAt = lender.block(4 * TANGENT_SIZE * mesh.corners), indicesAt = mesh.indices ? lender.input(mesh.indices) : 0;
      computeTangents(lender, mesh, indicesAt, tangentsAt, report);
      return { ...mergeTangents(lender, mesh, indicesAt, tangentsAt), report: mesh.report ? countsOfTangents(report.read()) : undefined };
    });
  };

  const matrices = (models, what, options) => {
    const winding = given.winding(options.winding), count = models.length / 16;
    const out = given.output(options.out, 9 * count);
    return heap.lend((lender) => {
      const written = lender.output(out, 9 * count);
      const result = wasm.web_normal_matrices(lender.input(models), count, winding, written.at);
      /* A model that is not finite has a matrix of zeros, and the others are done. */
      if (result === RESULT.OK || result === RESULT.ARGUMENT) written.fetch();
      if (result === RESULT.ARGUMENT) {
        const wrong = models.findIndex((x, i) => i % 16 < 11 && i % 4 < 3 && !Number.isFinite(x));
        fail(`${what}: element ${wrong} is ${models[wrong]}, but the upper 3x3 of a model must be finite`);
      }
      expect(result);
      return out;
    });
  };

  const normalMatrix = (model, options) => matrices(given.floats(model, 16, "model"), "model", given.options(options, "winding out"));
  const normalMatrices = (models, options) => matrices(given.floats(models, 16, "models", true), "models", given.options(options, "winding out"));

  const matrixInfo = (model) => {
    const floats = given.floats(model, 16, "model");
    return heap.lend((lender) => {
      const at = lender.block(80), result = wasm.web_matrix_info(lender.input(floats), at);
      if (result === RESULT.ARGUMENT) fail("model: its upper 3x3 is not finite");
      expect(result);
      const [determinant, anisotropy, worst, x, y, z, kind, rank, mirrored, shortcut] = heap.doubles(at, 10);
      return { kind: KINDS[kind], rank, mirrored: mirrored !== 0, determinant, anisotropy, worstErrorDeg: worst * DEGREES,
               worstNormal: Float32Array.of(x, y, z), shortcut: SHORTCUTS[shortcut] };
    });
  };

  const transformNormals = (matrix, vectors, options) => {
    const floats = given.floats(matrix, 9, "normalMatrix"), view = given.vectors(vectors, "normals");
    const out = given.output(given.options(options, "out").out, 3 * view.count);
    return heap.lend((lender) => {
      const written = lender.output(out, 3 * view.count);
      expect(wasm.web_transform_normals(lender.input(floats), lender.input(view.array), view.count, view.stride, view.format, written.at));
      return written.fetch();
    });
  };

  const encodeNormals = (vectors, options) => {
    const view = given.vectors(vectors, "normals"), chosen = given.options(options, "encoding out report");
    const encoding = given.encoding(chosen.encoding), wanted = given.flag(chosen.report, "report"), out = given.output(chosen.out, view.count, "Uint32Array");
    return heap.lend((lender) => {
      const written = lender.output(out, view.count), report = lendReport(lender, wanted);
      expect(wasm.web_encode_normals(lender.input(view.array), view.count, view.stride, view.format, encoding, written.at, report.at));
      const codes = written.fetch();
      if (!wanted) return codes;
      const { nonFinite, cancelled } = report.read();
      return { codes, report: { nonFinite, cancelled } };
    });
  };

  const decodeNormals = (array, options) => {
    const codes = given.codes(array), chosen = given.options(options, "encoding out"), encoding = given.encoding(chosen.encoding), out = given.output(chosen.out, 3 * codes.length);
    return heap.lend((lender) => {
      const written = lender.output(out, 3 * codes.length);
      expect(wasm.web_decode_normals(lender.input(codes), codes.length, encoding, written.at));
      return written.fetch();
    });
  };

  const encodingErrorDeg = (encoding) => wasm.web_encoding_error_deg(given.encoding(encoding));

  /* For the package's own use: tangents in place, made perpendicular to normals; four and three floats each. */
  const orthogonaliseTangents = (array, normalArray) => heap.lend((lender) => {
    const written = lender.output(array, array.length, true);
    expect(wasm.web_orthogonalise_tangents(written.at, lender.input(normalArray), array.length / TANGENT_SIZE));
    return written.fetch();
  });

  const plan = makePlans({ wasm, heap, expect, readMesh, hand, lendReport });
  const calls = { version: heap.text(wasm.web_version()), faceNormals, vertexNormals, cornerNormals, split, tangents, plan, normalMatrix, normalMatrices, matrixInfo, transformNormals,
                  encodeNormals, decodeNormals, encodingErrorDeg };
  if (check) calls.check = check;
  /* Not among the calls that a user sees. */
  for (const [name, value] of Object.entries({ creaseVertices, tangentVertices, orthogonaliseTangents })) Object.defineProperty(calls, name, { value });
  return calls;
}

export { NormaError };
