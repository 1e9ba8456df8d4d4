/* load for node, Deno and Bun: files are read, other addresses fetched. */
import { readFile } from "node:fs/promises";
import { makeLoad } from "./load.js";
import { read as fetchBytes } from "./load-web.js";

/* Paths, also those of Windows (C:\\...), are files; http:, https:, data: and blob: are not. */
function read(address) {
  const text = String(address);
  if (text.startsWith("file:")) return readFile(new URL(text));
  return /^[a-z][a-z0-9+.-]+:/i.test(text) ? fetchBytes(address) : readFile(text);
}

export const load = makeLoad(read, { core: () => new URL("./norma.wasm", import.meta.url), check: () => new URL("./check.wasm", import.meta.url), draco: () => new URL("./draco.wasm", import.meta.url), tool: () => new URL("./tool.wasm", import.meta.url) });
