/* norma-mesh with its modules as text: one file for bundlers and pages that cannot serve a .wasm beside their script. The text of check.wasm is loaded when a file is first checked, that of draco.wasm with the first Draco stream, that of tool.wasm when a file is first computed, fixed or listed. */
import { fail } from "./arguments.js";
import { decode } from "./heap.js";
import { makeLoad } from "./load.js";
import { read } from "./load-web.js";
import { connect } from "./remote.js";
import core from "./norma-text.js";

export { NormaError } from "./arguments.js";

const later = { check: async () => decode((await import("./check-text.js")).default), draco: async () => decode((await import("./draco-text.js")).default), tool: async () => decode((await import("./tool-text.js")).default) };

export const load = makeLoad(read, { core: () => decode(core), ...later });

/* The worker is made from text too: a content security policy has to allow worker-src blob:. */
export const loadWorker = async (source, options) => {
  if (typeof Worker === "undefined") fail("loadWorker: there is no Worker here; import it from norma-mesh instead of norma-mesh/inline");
  const { default: workerText } = await import("./worker-text.js");
  const address = URL.createObjectURL(new Blob([workerText], { type: "text/javascript" }));
  return connect(new Worker(address), source ?? decode(core), { ...later, ...options });
};
