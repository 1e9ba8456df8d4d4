/* The worker's side in browsers. */
import { load } from "./load-web.js";
import { serve } from "./serve.js";

serve(globalThis, load);
