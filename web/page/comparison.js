/* What is compared in the picture: what the sides are, the words over them, the line between them, the legend. */
import { byId, modelMatrix, numberOf, value } from "./controls.js";
import { NAME } from "./panels.js";
import { degrees } from "./readouts.js";
import { page, stage } from "./state.js";

const differs = () => !(page.norma.matrixInfo(modelMatrix()).worstErrorDeg < 0.005);

/* What is compared: nothing while M changes no angle. */
export function comparison() {
  if (page.moving) return "moving";
  if (page.chosen) return null;
  if (page.intro.isShown() || differs()) return "matrix";
  return page.before ? "change" : null;
}

export function panelKind(compared) {
  if (!compared) return "right";
  if (page.intro.isShown()) return "split";
  return compared !== "matrix" && value("sides") === "beside" ? "split" : value("sides");
}

export const WORDS = {
  matrix: ["Wrong", "normals through <i>M</i>", "Right", "through the normal matrix"],
  moving: ["Wrong", "normals left as they were", "Right", "normals kept right"],
  change: ["Before", "as the file is", "After", "the changed copy"],
};

/* Words, divider and legend where the panels are. */
export function placeStage() {
  const compared = comparison(), kind = panelKind(compared), sides = page.panels.map(({ side }) => side), angle = page.panels.find(({ side }) => side === "angle"), colours = value("colours");
  const [left, leftText, right, rightText] = WORDS[compared ?? "matrix"];
  byId("divider").hidden = kind !== "split";
  byId("divider").style.left = `${numberOf("split")}%`;
  byId("side-wrong").hidden = !compared || !sides.includes("wrong");
  byId("side-right").hidden = !compared || !sides.includes("right");
  byId("side-angle").hidden = !angle;
  if (angle) byId("side-angle").style.top = `${angle.box.y - NAME + 6}px`;
  byId("side-wrong-name").textContent = left;
  byId("side-right-name").textContent = right;
  byId("side-wrong").classList.toggle("plain", compared === "change");
  byId("side-right").classList.toggle("plain", compared === "change");
  if (byId("side-wrong-text").innerHTML !== leftText) byId("side-wrong-text").innerHTML = leftText;
  byId("side-right-text").textContent = rightText;
  byId("split").disabled = kind !== "split";
  stage.classList.toggle("beside", Boolean(angle));
  showLegend(colours === "error" ? "error" : colours === "angle" || angle ? "angle" : null);
}

function showLegend(of) {
  byId("legend").hidden = of === null;
  if (of === "error") {
    byId("legend-top").textContent = `${page.look.errorTop < page.look.errorWorst ? "≥ " : ""}${degrees(page.look.errorTop)}`;
    byId("legend-worst").textContent = `worst ${degrees(page.look.errorWorst ?? 0)}`;
  } else if (of === "angle") {
    byId("legend-top").textContent = `${page.look.angleTop}°`;
    byId("legend-worst").textContent = "";
  }
}
