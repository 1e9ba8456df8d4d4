/* norma-mesh/skin: positions, normals and tangents of vertices that several joints move. A module of its own, so that who has no skins loads nothing of it. */
import { fail, kindOf, numberOf, RESULT, spell } from "./arguments.js";
import { decode, makeHeap } from "./heap.js";
import text from "./skin-text.js";

const JOINTS = { Uint8Array: 1, Uint16Array: 2, Uint32Array: 4 };
const PARTS = { "skin->joints": "joints", "skin->weights": "weights", "skin->matrices": "matrices" };

const floats = (array, what, length) => {
  if (kindOf(array) !== "Float32Array") fail(`${what}: ${spell(array)} is not a Float32Array`);
  if (length !== undefined && array.length !== length) fail(`${what}: ${array.length} numbers, expected ${length}`);
  return array;
};

/* The counts of a skin, its arrays looked at. */
function measure(skin) {
  const { matrices, joints, weights, influences = 4, blend = "linear" } = skin ?? fail("skin: nothing was given");
  floats(matrices, "matrices");
  floats(weights, "weights");
  if (matrices.length % 16) fail(`matrices: ${matrices.length} numbers, expected sixteen for each joint`);
  if (!JOINTS[kindOf(joints)]) fail(`joints: ${spell(joints)} is not a Uint8Array, Uint16Array or Uint32Array`);
  if (!Number.isInteger(influences) || influences < 1 || influences > 64) fail(`influences: ${spell(influences)} is not a whole number from 1 to 64`);
  if (joints.length % influences) fail(`joints: ${joints.length} numbers, expected ${influences} for each vertex`);
  if (weights.length !== joints.length) fail(`weights: ${weights.length} numbers, expected one for each of ${joints.length} joints`);
  return { matrices, joints, weights, influences, vertices: joints.length / influences, blend: numberOf(["linear", "dual-quaternion"], blend, "blend") };
}

export async function loadSkin() {
  const { exports } = (await WebAssembly.instantiate(decode(text), {})).instance;
  const heap = makeHeap(exports.memory, exports.web_reserve, exports.web_release, (bytes) => fail(`${bytes} bytes: out of memory`, RESULT.MEMORY));

  function explain(result) {
    const name = PARTS[heap.text(exports.skin_fault_argument())], index = exports.skin_fault_index() >>> 0;
    fail(name ? `${name}[${index}]: expected ${heap.text(exports.skin_fault_expected()).replace("skin->joint_count", "that of matrices")}` : "skin: the call failed", result);
  }

  function move(skin, array, width, { out, normals, positions }) {
    const { matrices, joints, weights, influences, vertices, blend } = measure(skin);
    floats(array, positions ? "positions" : normals ? "tangents" : "normals", width * vertices);
    if (normals) floats(normals, "skinnedNormals", 3 * vertices);
    if (out !== undefined) floats(out, "out", width * vertices);
    return heap.lend(({ input, output }) => {
      const to = output(out ?? new Float32Array(width * vertices), width * vertices);
      exports.skin_set(input(matrices), matrices.length / 16, input(joints), JOINTS[kindOf(joints)], input(weights), influences, vertices, blend);
      const result = exports.skin_move(input(array), normals ? input(normals) : 0, positions ? 1 : 0, to.at);
      return result ? explain(result) : to.fetch();
    });
  }

  return {
    positions: (skin, positions, { out } = {}) => move(skin, positions, 3, { out, positions: true }),
    normals: (skin, normals, { out } = {}) => move(skin, normals, 3, { out }),
    tangents: (skin, tangents, skinnedNormals, { out } = {}) => move(skin, tangents, 4, { out, normals: floats(skinnedNormals, "skinnedNormals") }),
  };
}

export { NormaError } from "./arguments.js";
