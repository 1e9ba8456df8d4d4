/* What is compared in the picture: what the sides are, the words over them, the line between them, the legend. */
import { byId, modelMatrix, numberOf, value } from "./controls.js";
import { NAME } from "./panels.js";
import { degrees, short } from "./readouts.js";
import { page, stage } from "./state.js";

const differs = () => !(page.norma.matrixInfo(modelMatrix()).worstErrorDeg < 0.005);

/* What is compared: nothing while M changes no angle. */
export function comparison() {
  if (page.moving) return "moving";
  if (page.chosen) return null;
  if (page.intro.isShown() || differs()) return "matrix";
  return !page.before ? null : page.scene.compared ? "files" : "change";
}

/* Whether two models stand on the two sides. */
export const isOfTwo = (compared) => compared === "change" || compared === "files";

export function panelKind(compared) {
  if (!compared) return "right";
  if (page.intro.isShown()) return "split";
  return compared !== "matrix" && value("sides") === "beside" ? "split" : value("sides");
}

const WORDS = {
  matrix: ["Wrong", "normals through <i>M</i>", "Right", "through the normal matrix"],
  moving: ["Wrong", "normals left as they were", "Right", "normals kept right"],
  change: ["Before", "as the file is", "After", "the changed copy"],
};

/* Left and right, each a name and what it is, in HTML. */
export function wordsOf(compared) {
  const escaped = (text) => Object.assign(document.createElement("i"), { textContent: text }).innerHTML;
  return compared === "files" ? ["Base", escaped(page.before.model.name), "Other", escaped(page.scene.model.name)] : WORDS[compared ?? "matrix"];
}

/* Words, divider and legend where the panels are. */
export function placeStage() {
  const compared = comparison(), kind = panelKind(compared), sides = page.panels.map(({ side }) => side), angle = page.panels.find(({ side }) => side === "angle"), colours = value("colours");
  const [left, leftText, right, rightText] = wordsOf(compared);
  byId("divider").hidden = kind !== "split";
  byId("divider").style.left = `${numberOf("split")}%`;
  stage.style.setProperty("--split", `${numberOf("split")}%`);
  byId("side-wrong").hidden = !compared || !sides.includes("wrong");
  byId("side-right").hidden = !compared || !sides.includes("right");
  byId("side-angle").hidden = !angle;
  if (angle) byId("side-angle").style.top = `${angle.box.y - NAME + 6}px`;
  byId("side-wrong-name").textContent = left;
  byId("side-right-name").textContent = right;
  byId("side-wrong").classList.toggle("plain", isOfTwo(compared));
  byId("side-right").classList.toggle("plain", isOfTwo(compared));
  if (byId("side-wrong-text").innerHTML !== leftText) byId("side-wrong-text").innerHTML = leftText;
  if (byId("side-right-text").innerHTML !== rightText) byId("side-right-text").innerHTML = rightText;
  byId("split").disabled = kind !== "split";
  stage.classList.toggle("beside", Boolean(angle));
  showLegend(["error", "deviation", "distance"].includes(colours) ? "error" : colours === "angle" || angle ? "angle" : null, colours);
}

function showLegend(of, colours) {
  byId("legend").hidden = of === null;
  if (of === "error") {
    const shown = colours === "distance" ? short : degrees;
    byId("legend-least").textContent = colours === "distance" ? "0" : "0°";
    byId("legend-top").textContent = `${page.look.errorTop < page.look.errorWorst ? "≥ " : ""}${shown(page.look.errorTop)}`;
    byId("legend-worst").textContent = `worst ${shown(page.look.errorWorst ?? 0)}`;
  } else if (of === "angle") {
    byId("legend-least").textContent = "0°";
    byId("legend-top").textContent = `${page.look.angleTop}°`;
    byId("legend-worst").textContent = "";
  }
}
