/* The list of what norma check found: buttons, the worst first, each with a small picture of its place. One that is pressed shows its faces and takes the camera there; pressed once more, the model is as it was. */
import { count, counted } from "./readouts.js";

/* A list that nobody reads to its end would only make the page slow. */
const MOST_LISTED = 200;

const measured = ({ worst, unit }) => (!Number.isFinite(worst) ? "" : unit === "deg" && worst < 0.01 ? ", worst less than 0.01°" : `, worst ${String(Number(worst.toPrecision(4))).replace("-", "−")}${unit === "deg" ? "°" : unit ? ` ${unit}` : ""}`);

function summary(findings) {
  if (!findings.length) return "Nothing is wrong with this model's normals.";
  const of = (grade) => findings.filter((finding) => finding.grade === grade).length, notes = of("note");
  return `${counted(of("error"), "error")}, ${counted(of("warning"), "warning")}, ${counted(of("info"), "info", "info")}${notes ? `, ${counted(notes, "note")}` : ""}. Press one to see it.`;
}

function element(tag, text, name) {
  const made = document.createElement(tag);
  made.textContent = text;
  if (name) made.className = name;
  return made;
}

export const keyOf = ({ id, label }) => `${id}:${label ?? ""}`;

/* How many faces, normals or edges it counts stands in the message. thumb: its picture, or null for a finding that has no part of the model. */
function makeButton(finding, number, thumb) {
  const button = element("button", "", finding.grade);
  button.type = "button";
  button.id = `finding-${number}`;
  button.dataset.key = keyOf(finding);
  button.setAttribute("aria-pressed", "false");
  const words = element("span", "");
  words.append(element("b", finding.grade), ` ${finding.id} ${finding.name}${measured(finding)}`,
               element("small", finding.label ? `${finding.label}: ${finding.message}` : finding.message));
  button.append(words, ...(thumb ? [thumb] : []));
  return button;
}

/* Errors before warnings before the rest; of one grade those of most places, and informations, whose numbers count different things, as norma check reports them. */
const byWorst = (a, b) => b.severity - a.severity || (a.severity > 1 && b.places - a.places) || a.id.localeCompare(b.id) || b.places - a.places;

/* findings: null where the model was not checked, undefined while it is. chosen(finding or null) is called when that changes; thumbOf(finding) gives its picture. */
export function listFindings(findings, chosen, thumbOf) {
  const list = document.getElementById("findings"), section = document.getElementById("findings-section");
  section.hidden = findings === null;
  list.replaceChildren();
  document.getElementById("findings-facts").textContent = findings ? "" : "Checking …";
  if (!findings) return;
  const sorted = [...findings].sort(byWorst), shown = sorted.slice(0, MOST_LISTED);
  document.getElementById("findings-facts").textContent = summary(findings) + (sorted.length > shown.length ? ` The first ${shown.length} of ${count(sorted.length)} are listed.` : "");
  for (const [number, finding] of shown.entries()) {
    const button = makeButton(finding, number, thumbOf(finding)), item = document.createElement("li");
    button.addEventListener("click", () => {
      const press = button.getAttribute("aria-pressed") !== "true";
      for (const other of list.querySelectorAll("button")) other.setAttribute("aria-pressed", "false");
      button.setAttribute("aria-pressed", String(press));
      chosen(press ? finding : null);
    });
    item.append(button);
    list.append(item);
  }
}

/* Presses the finding of a key, keyOf(finding); where its label is another, the first of its rule. */
export function pressFinding(key) {
  const buttons = [...document.querySelectorAll("#findings button")], rule = key.split(":")[0];
  (buttons.find(({ dataset }) => dataset.key === key) ?? buttons.find(({ dataset }) => dataset.key.split(":")[0] === rule))?.click();
}

/* None of the list is pressed any more. */
export function releaseFindings() {
  for (const button of document.querySelectorAll("#findings button")) button.setAttribute("aria-pressed", "false");
}
