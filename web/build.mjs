/* Puts together what `make web` leaves.  node build.mjs package FOLDER: FOLDER/npm, from FOLDER/norma.wasm. */
import { copyFileSync, mkdirSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));

function buildPackage(folder) {
  const out = join(folder, "npm");
  mkdirSync(out, { recursive: true });
  for (const name of readdirSync(join(here, "package"))) copyFileSync(join(here, "package", name), join(out, name));
  copyFileSync(join(here, "..", "LICENSE"), join(out, "LICENSE"));
  const wasm = readFileSync(join(folder, "norma.wasm"));
  writeFileSync(join(out, "wasm.js"), `/* norma.wasm in base64. */\nexport default "${wasm.toString("base64")}";\n`);
  copyFileSync(join(folder, "norma.wasm"), join(out, "norma.wasm"));
}

const [what, folder] = process.argv.slice(2);
const works = { package: buildPackage };
if (!works[what] || !folder) {
  console.error(`usage: node build.mjs ${Object.keys(works).join("|")} FOLDER`);
  process.exit(2);
}
works[what](folder);
