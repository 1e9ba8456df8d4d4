/* norma-mesh/react: creases for react-three-fiber, and for whoever else uses three.js within React. */
import { useEffect, useMemo } from "react";
import { fail } from "./arguments.js";
import { load, toCreased } from "./three.js";

let state = null; // of the module: { promise, isLoaded, error }

/* Suspends until the module is loaded. Where that fails, the error goes to the nearest boundary, and the next component that asks tries again. */
function waitForModule() {
  state ??= { isLoaded: false, error: null };
  const now = state;
  now.promise ??= load().then(() => { now.isLoaded = true; }, (error) => { now.error = error; });
  if (now.error) {
    state = null;
    throw now.error;
  }
  if (!now.isLoaded) throw now.promise;
}

/* A geometry with creases, computed again only where the geometry or an option is another one, and released where it is no longer used. */
export function useCreasedGeometry(geometry, options = {}) {
  const { weight, weld, nonManifold, fallback, crease, ...others } = options;
  if (Object.keys(others).length) fail(`options: ${Object.keys(others)[0]} is not an option of this call; it takes weight, weld, nonManifold, fallback, crease`);
  waitForModule();
  const creased = useMemo(() => toCreased(geometry, { weight, weld, nonManifold, fallback, crease }), [geometry, weight, weld, nonManifold, fallback, crease]);
  useEffect(() => () => creased.dispose(), [creased]);
  return creased;
}
