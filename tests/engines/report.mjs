/* Writes docs/engines.md, its pictures and verdicts.json from what run.sh left in a folder.   node report.mjs FOLDER [ENGINE...]
 * Engines that are not named keep their last verdicts. findings.json has, by hand, what the engines' sources say about each cell. */
import { existsSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { findChrome, launch } from "../web/chrome.mjs";

const here = dirname(fileURLToPath(import.meta.url)), root = join(here, "../..");
const [folder, ...names] = process.argv.slice(2);
const read = (path) => JSON.parse(readFileSync(path, "utf8"));
const text = (path) => existsSync(path) ? readFileSync(path, "utf8").trim() : "";
const verdicts = existsSync(join(here, "verdicts.json")) ? read(join(here, "verdicts.json")) : {};
const findings = read(join(here, "findings.json"));
const pictures = join(root, "docs/figures/engines");
mkdirSync(pictures, { recursive: true });

for (const name of names) {
  const said = text(join(folder, `${name}.said`)), date = new Date().toISOString().slice(0, 10), judged = text(join(folder, `${name}.json`));
  const finished = text(join(folder, `${name}.status`)) === "0"; /* a harness that ran out of time leaves half a picture, and no name */
  if (!judged || !finished) {
    const why = finished ? text(join(folder, `${name}.judge`)).replace(/^norma: \S+: /, "") : said || text(join(folder, `${name}.err`));
    verdicts[name] = { engine: findings[name]?.engine ?? name, date, error: why.split("\n").slice(0, 2).join(" ").replace(/http:\S+/g, "").slice(0, 240) };
    continue;
  }
  const { cells, summary } = JSON.parse(judged);
  verdicts[name] = { engine: said.split("\n").at(-1), date, summary, cells: Object.fromEntries(cells.map(({ id, verdict, mistake }) => [id, mistake ? `${verdict}: ${mistake}` : verdict])) };
}

/* The screenshot at 800 by 600: a JPEG of some 60 kB, which tests/cli/acid-engines.sh has judged again. */
const drawn = names.filter((name) => verdicts[name].cells);
if (drawn.length) {
  const chrome = await launch(findChrome(), { width: 800, height: 600 });
  for (const name of drawn) {
    const tab = await chrome.open("about:blank", { size: [800, 600] });
    const url = `data:image/png;base64,${readFileSync(join(folder, `${name}.png`)).toString("base64")}`;
    await tab.evaluate(`new Promise((done) => { document.body.style.margin = 0; const image = new Image(800, 600); image.onload = done; image.src = ${JSON.stringify(url)}; document.body.append(image); }).then(() => 0)`);
    let bytes;
    for (let quality = 92; quality >= 80 && !(bytes?.length <= 66000); quality -= 4) bytes = await tab.screenshot(undefined, { format: "jpeg", quality });
    writeFileSync(join(pictures, `${name}.jpg`), bytes);
    await tab.close();
  }
  await chrome.close();
}
const sorted = Object.fromEntries(Object.keys(verdicts).sort().map((name) => [name, verdicts[name]]));
writeFileSync(join(here, "verdicts.json"), `${JSON.stringify(sorted, null, 2)}\n`);

const shown = Object.entries(sorted).filter(([, { cells }]) => cells), ids = Object.keys(shown[0][1].cells);
const others = shown.filter(([name]) => name !== "norma").length, count = others === 12 ? "twelve" : others;
const short = { pass: "ok", fail: "**fail**", missing: "**missing**", unclear: "unclear", skipped: "skipped" };
const lines = [
  "# Engines", "",
  `How ${count} engines, and \`norma render\`, draw \`norma-acid.glb\` (see [acid.md](acid.md)), each with its own glTF loader and its default`,
  "material, headless and in software. `make engines` installs them, draws the scene, has `norma acid --judge` read the pictures, and writes",
  "this page; `tests/engines` has a harness of at most 60 lines for each. For each cell that does not pass, the text below names the file or",
  "function in the engine's source that causes it. Packages from npm were read as installed, in the version that the table names.", "",
  "| Engine | Date | pass | fail | missing | unclear | skipped |", "|---|---|---|---|---|---|---|",
  ...shown.map(([name, { engine, date, summary: s }]) => `| [${engine}](#${name}) | ${date} | ${s.pass} | ${s.fail} | ${s.missing} | ${s.unclear} | ${s.skipped} |`), "",
  "## Cells", "",
  `| Cell | ${shown.map(([name]) => name).join(" | ")} |`, `|---|${shown.map(() => "---|").join("")}`,
  ...ids.map((id) => `| \`${id}\` | ${shown.map(([, { cells }]) => short[cells[id].split(":")[0]]).join(" | ")} |`), ""];
for (const [name, { engine, cells }] of shown) {
  const notes = findings[name] ?? {};
  lines.push(`## ${name}`, "", `${engine}. ${notes.note ?? ""}`.trim(), "", `![The acid scene drawn by ${engine}](figures/engines/${name}.jpg)`, "");
  for (const id of ids.filter((id) => !/^(pass|skipped)/.test(cells[id])))
    lines.push(`- \`${id}\`: ${cells[id].replace(/: (.*)/, ", `$1`")}. ${notes.cells?.[id] ?? "Not yet found in the source."}`);
  if (lines.at(-1) !== "") lines.push("");
}
const silent = Object.entries(sorted).filter(([, { error }]) => error);
if (silent.length)
  lines.push("## Without a verdict", "", "| Engine | Date | What happened |", "|---|---|---|",
    ...silent.map(([name, { engine, date, error }]) => `| ${engine} | ${date} | ${error.replaceAll("|", "\\|")} |`), "");
writeFileSync(join(root, "docs/engines.md"), lines.join("\n"));
