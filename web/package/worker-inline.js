/* The worker's side of norma-mesh/inline: its modules arrive as bytes. web/build.mjs makes one text of this file and what it imports. */
import { makeLoad } from "./load.js";
import { serve } from "./serve.js";

const none = () => { throw new Error("the module was not sent"); };
serve(globalThis, makeLoad(none, { core: none, check: none, draco: none, tool: none }));
