/* All calls on a module's exports: those of norma-mesh/normals (calls.js), and what that does without. */
import * as given from "./arguments.js";
import { RESULT, fail } from "./arguments.js";
import { bindMeshCalls } from "./calls.js";
import { makePlans } from "./plans.js";

const KINDS = ["identity", "translation", "rotation", "uniform-scale", "non-uniform-scale", "shear", "singular"];
const SHORTCUTS = ["none", "rotation", "uniform-scale", "axis-scale"];
const DEGREES = 180 / Math.PI;
const TANGENT_SIZE = 4, NO_MEMORY = 0xffffffff;

/* check: (bytes, options) => a promise of what norma check finds; undefined where the module has no use for it. */
export function bindCalls(wasm, check) {
  const { calls, heap, expect, readMesh, hand, lendReport, readTangents, computeTangents, countsOfTangents } = bindMeshCalls(wasm);

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

  /* For the package's own use: tangents as those of vertices. */
  const tangentVertices = (positions, normalVectors, texcoords, indices, options) => {
    const mesh = readTangents(positions, normalVectors, texcoords, indices, options, "");
    return heap.lend((lender) => {
      const report = lendReport(lender, mesh.report), tangentsAt = lender.block(4 * TANGENT_SIZE * mesh.corners), indicesAt = mesh.indices ? lender.input(mesh.indices) : 0;
      computeTangents(lender, mesh, indicesAt, tangentsAt, report);
      return { ...mergeTangents(lender, mesh, indicesAt, tangentsAt), report: mesh.report ? countsOfTangents(report.read()) : undefined };
    });
  };

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
  Object.assign(calls, { plan, matrixInfo, transformNormals, encodeNormals, decodeNormals, encodingErrorDeg });
  if (check) calls.check = check;
  /* Not among the calls that a user sees. */
  for (const [name, value] of Object.entries({ creaseVertices, tangentVertices, orthogonaliseTangents })) Object.defineProperty(calls, name, { value });
  return calls;
}
