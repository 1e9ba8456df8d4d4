/* node marks.mjs TOOL FOLDER FILE...: what norma check finds is seen in the page of norma view. Of each file every error and warning is pressed; then at least 0.2 % of the picture must have the colour of
   its severity, counted in a screenshot. A table and a TAP line for each finding. Files that cannot be viewed are errors; those without errors and warnings are named. */
import { execFileSync } from "node:child_process";
import { mkdirSync } from "node:fs";
import { basename, join } from "node:path";
import { pathToFileURL } from "node:url";
import { findChrome, launch } from "./chrome.mjs";
import { countPixels, readPng } from "./png.mjs";
import { attempt, finish } from "./tap.mjs";
import { pause } from "./wait.mjs";

const LEAST = 0.2, SIZE = [900, 640], STAGE = [0, 0, 540, 640], WAIT = 240;
const [tool, folder, ...files] = process.argv.slice(2);
mkdirSync(folder, { recursive: true });
const browser = await launch(findChrome(), { width: SIZE[0], height: SIZE[1] });

/* Red and orange, which nothing else in the picture is. */
const IS_MARKED = { error: ([r, g, b]) => r > g + 60 && r > b + 60 && g < 110, warning: ([r, g, b]) => r > b + 60 && r > g + 25 };

async function press(page, { id, grade }, picture) {
  const settled = () => page.until("document.body.dataset.busy === ''", WAIT);
  const drawn = await page.evaluate("Number(document.body.dataset.drawn)");
  await page.evaluate(`document.getElementById("${id}").click()`);
  await page.until(`Number(document.body.dataset.drawn) > ${drawn}`, WAIT);
  for (let times = 0; times < 3; times++) {
    await pause(60);
    await settled();
  }
  return (100 * countPixels(readPng(await page.screenshot(picture)), STAGE, IS_MARKED[grade])) / (STAGE[2] * STAGE[3]);
}

const TEXTS = `JSON.stringify([...document.querySelectorAll("#findings button")].map((button) => ({ id: button.id, grade: button.className, rule: button.textContent.replace(/^[a-z]+ /, "").split(",")[0], label: button.querySelector("small").textContent.slice(0, 60) })))`;

for (const file of files) {
  const out = join(folder, "view.html");
  let page = null;
  try {
    execFileSync(tool, ["view", file, "-o", out, "--quiet"], { stdio: ["ignore", "ignore", "pipe"] });
    page = await browser.open(pathToFileURL(out).href, { size: SIZE });
    await page.until("document.body?.dataset.drawn > 0 && document.body.dataset.busy === ''", WAIT);
    /* Of clay, nothing but marks is red or orange. */
    await page.evaluate("if (document.getElementById('textures').checked) document.getElementById('textures').click()");
    const findings = JSON.parse(await page.evaluate(TEXTS)).filter(({ grade }) => grade in IS_MARKED);
    if (!findings.length) console.log(`# ${file}: no error, no warning`);
    for (const finding of findings) await attempt(`${basename(file)} ${finding.grade} ${finding.rule} is seen`, async () => {
      const part = await press(page, finding, join(folder, `${basename(file)}-${finding.id}.png`));
      console.log(`# ${part.toFixed(2).padStart(6)} %  ${finding.grade.padEnd(7)} ${finding.rule}  ${basename(file)}: ${finding.label}`);
      /* What could not be read has no place on a surface, and the page says so. */
      if (/^N0/.test(finding.rule) && /not about a place/.test(await page.evaluate("document.getElementById('finding-seen').textContent"))) return;
      if (part < LEAST) throw new Error(`${part.toFixed(2)} % of the picture is marked, expected ${LEAST} %: ${finding.label}`);
    });
  } catch (error) {
    await attempt(`${basename(file)} is viewed`, async () => { throw error; });
  }
  await page?.close();
}
await browser.close();
finish();
