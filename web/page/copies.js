/* Changed copies of the file: fixed, or with its normals computed; beside the file as it is. */
import { problemsIn, rulesThatFell, triedBy, whatStays, wordsOf } from "./changes.js";
import { byId, isChecked, numberOf, value } from "./controls.js";
import { listFiles } from "./files.js";
import { showModel } from "./opening.js";
import { fly, isOfWhole, placeIn, sweep } from "./pressed.js";
import { counted } from "./readouts.js";
import { itemsOf } from "./scene.js";
import { posesOf, seek } from "./seek.js";
import { REACH, camera, canvas, dirty, page, userMatrix } from "./state.js";
import { viewOf } from "./thumbs.js";

const countGrade = (findings, grade) => (findings ?? []).filter((finding) => finding.grade === grade).length;
const sum = (findings) => `${counted(countGrade(findings, "error"), "error")} and ${counted(countGrade(findings, "warning"), "warning")}`;
const listWords = (id, words) => byId(id).replaceChildren(...words.map((text) => Object.assign(document.createElement("li"), { textContent: text })));

const fileShown = () => page.before ?? page.scene;

/* Asks for a changed copy, shows it beside the file as it is, and offers it; unless another file is shown meanwhile. */
async function change(facts, links, ask, words, then = () => undefined) {
  const first = fileShown();
  byId(facts).textContent = "Working …";
  listFiles(links, []);
  try {
    const wasChosen = page.chosen, result = await ask();
    if (first !== fileShown()) { if (result.model) page.remote.free(result.model.number); return; }
    byId(facts).textContent = words(result);
    if (result.changed) {
      const changes = await page.remote.changes(first.model.number, result.model.number).catch(() => null); /* then nothing is tinted */
      if (first !== fileShown()) { page.remote.free(result.model.number); return; }
      if (value("colours") === "findings") byId("colours").value = "lit";
      showModel(result.model, { changed: true, files: first.files });
      listFiles(links, result.files);
      await uploadTint(first, changes);
      if (first !== fileShown()) return;
      then(result, changes, first);
      await goToChange(wasChosen, changes);
      sweep();
    } else then(result, null, first);
  } catch (error) {
    if (first === fileShown()) byId(facts).textContent = error.message;
  }
}

/* What was changed, in colour on both sides. */
async function uploadTint(first, changes) {
  byId("tint-row").hidden = !changes?.some(({ counts }) => Object.values(counts).some(Boolean));
  for (const [shown, name] of [[page.before, "before"], [page.scene, "after"]])
    for (const [i, one] of (changes ?? []).entries()) {
      if (first !== fileShown()) return;
      await page.graphics.fillMarks(shown.surfaces[i], "tint", one.marks[name]);
    }
  dirty.draw = true;
}

/* The camera goes to the place that was pressed, or else to the worst that is no longer found. */
async function goToChange(wasChosen, changes) {
  const [old, shown] = [page.before, page.scene], fell = new Set(rulesThatFell(old.model.findings, shown.model.findings).map(({ id }) => id)), gone = (old.model.findings ?? []).filter(({ id }) => fell.has(id)).sort((a, b) => b.severity - a.severity);
  const finding = gone.find(({ id, mesh }) => id === wasChosen?.id && mesh === wasChosen.mesh) ?? gone[0];
  if (!finding || !changes) return;
  const place = placeIn(finding, await page.remote.place(old.model.number, finding.index, 0), old);
  if (!place || isOfWhole(old, finding, place) || old !== page.before || shown !== page.scene) return;
  const items = itemsOf(page.norma, old, userMatrix(), "right"), aspect = canvas.clientWidth / Math.max(1, canvas.clientHeight);
  const best = await seek(posesOf(place, camera.axes().up), (poses, through) => page.graphics.countMarked(items, poses.map((pose) => viewOf(pose, aspect, REACH)), aspect, through, "tint"));
  /* Further away than one that is pressed: what was changed is seen among what was not. */
  const distance = 2.2 * best.pose.distance, isFar = distance > 3.4;
  if (old === page.before && shown === page.scene) await fly({ ...best.pose, centre: isFar ? [0, 0, 0] : [...best.pose.centre], distance: isFar ? 3.4 : distance });
}

function whyNothing(findings, unsafe) {
  if (findings && !problemsIn(findings).length) return "There is nothing to fix: no error and no warning.";
  return triedBy(findings).length && !unsafe ? "Nothing can be fixed without changing how it looks: tick the box to try that." : "Nothing here can be fixed by a program.";
}

export function fix() {
  const unsafe = isChecked("fix-unsafe");
  return change("fix-facts", "fixed-files", () => page.remote.fix(page.source.path, page.source.name, { unsafe }), ({ changed, model }) => (changed
    ? `Before: ${sum(fileShown().model.findings)}. After: ${sum(model.findings)}. The line in the picture divides before from after.` : whyNothing(fileShown().model.findings, unsafe)),
  ({ model, notes }, changes, first) => {
    const counts = (changes ?? []).reduce((all, one) => Object.fromEntries(Object.entries(one.counts).map(([name, x]) => [name, x + (all[name] ?? 0)])), {}), after = model?.findings ?? first.model.findings, stays = whatStays(after, notes, unsafe);
    listWords("fixed-list", model ? wordsOf(counts, rulesThatFell(first.model.findings, after)) : []);
    listWords("stays", stays);
    byId("stays-box").hidden = !stays.length;
  });
}

/* Per vertex in PLY and per facet in STL there are no creases. */
export const computeCopy = () => change("computed-facts", "computed-files",
  () => page.remote.computeFile(page.source.path, page.source.name, { weight: value("weight"), weld: value("weld"), crease: ["PLY", "STL"].includes(page.scene.model.format) ? null : numberOf("crease") }),
  ({ changed, verticesBefore, verticesAfter, notes }) => (changed ? `Computed${verticesAfter > verticesBefore ? `; ${counted(verticesAfter - verticesBefore, "vertex was", "vertices were")} added at creases` : ""}. The line in the picture divides before from after.` : "The file has these normals already.") + (notes.length ? ` ${notes.join(". ")}.` : ""));
