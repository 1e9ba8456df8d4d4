/* react-three-fiber: a hook that gives a geometry creases. Its test renderer serves here; a page puts the same elements into its <Canvas>.   node react.mjs */
import { Suspense, createElement, useMemo } from "react";
import ReactThreeTestRenderer from "@react-three/test-renderer";
import { LatheGeometry, Vector2 } from "three";
import { useCreasedGeometry } from "norma-mesh/react";

globalThis.IS_REACT_ACT_ENVIRONMENT = true;

function Cup({ crease }) {
  const plain = useMemo(() => new LatheGeometry([[0, 0], [2, 0], [2.5, 3]].map(([x, y]) => new Vector2(x, y)), 32), []);
  const geometry = useCreasedGeometry(plain, { crease });
  return createElement("mesh", { geometry }, createElement("meshStandardMaterial"));
}

/* The module is loaded once; until then the component is suspended. */
const scene = (crease) => createElement(Suspense, { fallback: null }, createElement(Cup, { crease }));
const renderer = await ReactThreeTestRenderer.create(scene(60));
const drawn = () => renderer.scene.children[0]?.instance.geometry;
await ReactThreeTestRenderer.act(async () => { for (let i = 0; i < 100 && !drawn(); i++) await new Promise((resolve) => setTimeout(resolve, 10)); });

console.log(`creased at 60 degrees: ${drawn().attributes.position.count} vertices`);
let disposed = 0;
drawn().addEventListener("dispose", () => disposed++);
await renderer.update(scene(180));
console.log(`at 180 degrees: ${drawn().attributes.position.count} vertices; the geometry before was disposed of ${disposed} time`);
await renderer.unmount();
