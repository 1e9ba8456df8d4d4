// run.mjs MODULE FOLDER ARGUMENT...: runs a WebAssembly program under node's WASI, with FOLDER as its root. An argument /lists/NAME is a file of the folder that
// NORMA_LISTS names.
import { readFile } from "node:fs/promises";
import { WASI } from "node:wasi";

const [file, folder, ...rest] = process.argv.slice(2);
const preopens = { "/": folder };
if (process.env.NORMA_LISTS)
    preopens["/lists"] = process.env.NORMA_LISTS;
const wasi = new WASI({ version: "preview1", args: [file, ...rest], preopens, returnOnExit: true });
const { instance } = await WebAssembly.instantiate(await readFile(file), wasi.getImportObject());
// At once: what was written is written, and node 20 crashes when it takes down a program that has run for minutes.
process.reallyExit(wasi.start(instance));
