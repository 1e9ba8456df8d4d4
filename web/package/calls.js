/* The calls on a module's exports that norma-mesh/normals has as well. Every argument is checked before the heap is touched. */
import * as given from "./arguments.js";
import { RESULT, fail } from "./arguments.js";
import { makeHeap } from "./heap.js";

const COUNTS = ["degenerateFaces", "nonFinite", "unreferenced", "cancelled", "nonManifoldEdges", "windingConflicts"];
const MESH_OPTIONS = "weight weld nonManifold fallback report";
const TEXCOORD_SIZE = 2, TANGENT_SIZE = 4;

/* { calls, and what more of them are made with }. refuse: throws where options ask for what the module was made without. */
export function bindMeshCalls(wasm, refuse = () => {}) {
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
    refuse(chosen);
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

  /* One value for each vertex or for each corner: which of the two, by how many there are. */
  const elementOf = (view, mesh, what) => {
    if (view.count === mesh.vertices) return 0;
    if (view.count === mesh.corners) return 1;
    return fail(`${what}: ${view.count} values, but the mesh has ${mesh.vertices} vertices and ${mesh.corners} corners`);
  };

  const readTangents = (positions, normalVectors, texcoords, indices, options, known) => {
    const leftOut = options === undefined && indices !== null && typeof indices === "object" && !ArrayBuffer.isView(indices) && !Array.isArray(indices);
    const chosen = given.options(leftOut ? indices : options, `mode weight report ${known}`);
    refuse(chosen);
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

  const calls = { version: heap.text(wasm.web_version()), faceNormals, vertexNormals, cornerNormals, split, tangents, normalMatrix, normalMatrices };
  return { calls, heap, expect, readMesh, hand, lendReport, readTangents, computeTangents, countsOfTangents };
}
