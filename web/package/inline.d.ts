/** norma-mesh with its modules as text: nothing has to be served beside a script. */
export * from "./index.js";
