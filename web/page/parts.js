/* The parts of a model, each with a box to hide it; and the controls that depend on what the model has. */
import { byId } from "./controls.js";

/* A list that nobody reads to its end would only make the page slow. */
const MOST_LISTED = 300;

function makeBox(title, number, hidden, changed) {
  const item = document.createElement("li"), label = document.createElement("label"), box = document.createElement("input");
  box.type = "checkbox";
  box.checked = !hidden.has(number);
  box.addEventListener("change", () => {
    if (box.checked) hidden.delete(number); else hidden.add(number);
    changed();
  });
  label.append(box, ` ${title || `Part ${number + 1}`}`);
  item.append(label);
  return item;
}

/* scene.hidden: the numbers of the meshes that are not shown, changed here. */
export function listParts(scene, changed) {
  const meshes = scene.model?.meshes ?? [], { hidden } = scene;
  byId("parts-box").hidden = meshes.length < 2;
  byId("parts").replaceChildren(...meshes.slice(0, MOST_LISTED).map(({ title }, i) => makeBox(title, i, hidden, changed)));
  const all = (shown) => () => {
    hidden.clear();
    if (!shown) meshes.forEach((_, i) => hidden.add(i));
    for (const box of byId("parts").querySelectorAll("input")) box.checked = shown;
    changed();
  };
  byId("all-parts").onclick = all(true);
  byId("no-parts").onclick = all(false);
}

/* Shows a part again, which a finding is about. */
export function showPart({ hidden }, number) {
  hidden.delete(number);
  const box = byId("parts").querySelectorAll("input")[number];
  if (box) box.checked = true;
}

/* Controls of materials and tangents are there if the model has them. materials: as they were read, or null. */
export function showMaterialControls(model, materials = null) {
  const meshes = model?.meshes ?? [], has = (name) => meshes.some((mesh) => mesh[name]);
  byId("textures-row").hidden = !materials && !has("hasColours");
  byId("seams-row").hidden = !meshes.some(({ hasTexcoords }) => hasTexcoords[0]);
  byId("normal-maps-row").hidden = !materials?.some((material) => material?.normalMap);
  byId("up-row").hidden = !model;
  byId("colours").querySelector("[value=tangents]").disabled = !meshes.some(({ hasTangents, hasTexcoords }) => hasTangents || hasTexcoords.some(Boolean));
  byId("up").value = model?.up ?? "y";
  byId("up-facts").textContent = ["OBJ", "PLY", "STL", "3MF"].includes(model?.format) ? "guessed" : "";
}
