/* Deflate of npm's fflate; web/build.mjs puts it in. */
export { Inflate, deflateSync } from "fflate/esm/browser.js";
