/* The cells of the acid scenes in the lesson: what is right beside what each mistake makes of it, in light that turns, with what a shader does instead. */
import { byId, numberOf } from "./controls.js";
import { notice } from "./readouts.js";
import { isCalm, page } from "./state.js";

/* Of a patch, in pixels; degrees a second. */
const SIZE = 168, SPEED = 40;
const nextFrame = () => new Promise((done) => requestAnimationFrame(done));
const made = (tag, more = {}) => Object.assign(document.createElement(tag), more);
const playing = { on: false, last: 0, drawing: false };
const inSight = new Set();

function play(on) {
  playing.on = on;
  byId("cells-play").textContent = on ? "Pause" : "Play";
  byId("cells-play").setAttribute("aria-pressed", String(!on));
}

async function drawCell({ canvas, patches }, turn) {
  const width = SIZE * patches.length, pixels = await page.graphics.drawPatches(patches, SIZE, (turn * Math.PI) / 180), image = new ImageData(width, SIZE);
  for (let y = 0; y < SIZE; y++) image.data.set(pixels.subarray(4 * width * (SIZE - 1 - y), 4 * width * (SIZE - y)), 4 * width * y);
  canvas.getContext("2d").putImageData(image, 0, 0);
  canvas.dataset.light = String(turn);
}

/* Those in sight, again when the light has turned. */
async function keepDrawing() {
  if (playing.drawing) return;
  playing.drawing = true;
  while (byId("cells").open) {
    const now = await nextFrame(), seconds = Math.min(0.1, (now - playing.last) / 1000);
    playing.last = now;
    if (playing.on && inSight.size) byId("cells-light").value = (numberOf("cells-light") + SPEED * seconds) % 360;
    const turn = numberOf("cells-light");
    for (const cell of inSight) if (cell.canvas.dataset.light !== String(turn)) await drawCell(cell, turn);
  }
  playing.drawing = false;
}

const watcher = new IntersectionObserver((entries) => {
  for (const { target, isIntersecting } of entries) if (isIntersecting) inSight.add(target.cell); else inSight.delete(target.cell);
});

/* Lines break behind brackets and commas before they break within a word. */
function codeOf(text) {
  const code = made("pre");
  code.append(...text.split(/(?<=[(,.])(?=\w)/).flatMap((part) => [part, made("wbr")]));
  return code;
}

function addCell({ tested, sentence, section, patches }) {
  const canvas = made("canvas", { width: SIZE * patches.length, height: SIZE }), names = made("p", { className: "names" }), article = made("article", { className: "cell" });
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", patches.map(({ id }) => id).join(", "));
  article.style.setProperty("--patch", `${100 / Math.max(3, patches.length)}%`);
  article.style.setProperty("--patches", patches.length);
  canvas.cell = { canvas, patches: patches.map(({ id, ...arrays }) => ({ surface: page.graphics.makeSurface(arrays), keepsLength: id === "not-normalized" })) };
  names.append(...patches.map(({ id }, i) => made("b", { className: i ? "wrong" : "right", textContent: id })));
  article.append(made("h3", { textContent: tested }), canvas, names, ...patches.slice(1).flatMap(({ id, words, mend, shader }) => {
    const said = made("p");
    said.append(made("b", { textContent: id }), `: ${words}. Instead: ${mend}.`);
    return shader ? [said, codeOf(shader)] : [said];
  }), made("p", { className: "quiet", textContent: `“${sentence}” (${section})` }));
  byId("cells-list").append(article);
  watcher.observe(canvas);
}

export function wireCells() {
  let asked = null;
  const fill = async () => { for (const cell of await page.remote.cells()) addCell(cell); };
  byId("cells").addEventListener("toggle", () => {
    if (!byId("cells").open) return;
    asked ??= fill();
    asked.then(keepDrawing).catch((error) => notice(error.message));
  });
  byId("cells-play").addEventListener("click", () => play(!playing.on));
  byId("cells-light").addEventListener("input", () => play(false));
  play(!isCalm());
}
