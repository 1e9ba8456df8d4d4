/* Plans: what depends on a mesh's indices alone, done once. A plan holds memory of the module until it is freed. */
import * as given from "./arguments.js";
import { fail } from "./arguments.js";

const PER_VERTEX = 0;

export function makePlans({ wasm, heap, expect, readMesh, hand, lendReport }) {
  /* A plan's own room in the heap, for callers who want nothing copied: made when it is first asked for. */
  const makeRoom = (length) => {
    let at = 0;
    return {
      array: () => new Float32Array(wasm.memory.buffer, (at ||= heap.allocate(4 * length)), length),
      free: () => { if (at) wasm.web_release(at); at = 0; },
    };
  };

  const create = (mesh, per, crease) => heap.lend((lender) => {
    const result = lender.block(4);
    const address = wasm.web_plan_create(...hand(mesh, lender), per, crease, result) >>> 0;
    expect(new Int32Array(wasm.memory.buffer, result, 1)[0], mesh);
    return address;
  });

  return (positions, indices, options) => {
    const mesh = readMesh(positions, indices, options, "per crease");
    if (mesh.report) fail("report: is an option of a plan's update, not of the plan");
    const per = given.element(mesh.options.per), { vertices } = mesh;
    const crease = given.crease(mesh.options.crease, per === PER_VERTEX ? 180 : 60);
    const count = per === PER_VERTEX ? vertices : mesh.corners;
    let address = create(mesh, per, crease);
    const rooms = { positions: makeRoom(3 * vertices), normals: makeRoom(3 * count) };
    const alive = () => address || fail("plan: it has been freed");

    const update = (now, chosen) => {
      alive();
      const { moved: list, out: array, report: asked } = given.options(chosen, "moved out report");
      const view = given.vectors(now, "positions"), wanted = given.flag(asked, "report");
      if (view.count !== vertices) fail(`positions: ${view.count} vectors, but the plan has ${vertices}`);
      const moved = given.moved(list, vertices);
      if (moved && !array) fail("out: is needed with moved; it holds the normals of the last update");
      const out = given.output(array, 3 * count);
      return heap.lend((lender) => {
        const written = lender.output(out, 3 * count, moved !== null), report = lendReport(lender, wanted);
        expect(wasm.web_plan_update(address, lender.input(view.array), vertices, view.stride, view.format, moved ? lender.input(moved) : 0, moved ? moved.length : 0, written.at, count, report.at), mesh);
        const normals = written.fetch();
        return wanted ? { normals, report: report.read() } : normals;
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
}
