/* load for browsers and whatever else has fetch: the modules lie beside this file. Bundlers know this way to name a file and copy it. */
import { makeLoad } from "./load.js";

export async function read(address) {
  const response = await fetch(address);
  if (!response.ok) throw new Error(`${response.status} ${response.statusText}`.trim());
  return response.arrayBuffer();
}

export const load = makeLoad(read, { core: () => new URL("./norma.wasm", import.meta.url), check: () => new URL("./check.wasm", import.meta.url), draco: () => new URL("./draco.wasm", import.meta.url), tool: () => new URL("./tool.wasm", import.meta.url) });
