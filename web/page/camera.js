/* The camera: it orbits a point. Angles in degrees, as in `norma render --camera AZIMUTH,ELEVATION`. */
import { dot } from "./matrix.js";

const FRONT = { azimuth: 38, elevation: 18, distance: 3.4, centre: [0, 0, 0] };
const FIELD_OF_VIEW = (38 * Math.PI) / 180;
/* Of the picture's sides what a model may fill; and how close the camera begins to a ball of radius 1. */
const FILLED = 0.9, CLOSEST = 2.3;

export function makeCamera() {
  const camera = { ...FRONT, centre: [0, 0, 0], aspect: 1, home: FRONT };

  /* Right, up and back (to the eye), unit, in the world. */
  const axes = ({ azimuth, elevation } = camera) => {
    const [a, e] = [azimuth, elevation].map((degrees) => (degrees * Math.PI) / 180);
    return { right: [Math.cos(a), 0, -Math.sin(a)], up: [-Math.sin(a) * Math.sin(e), Math.cos(e), -Math.cos(a) * Math.sin(e)], back: [Math.sin(a) * Math.cos(e), Math.sin(e), Math.cos(a) * Math.cos(e)] };
  };
  const eye = () => axes().back.map((x, i) => camera.centre[i] + camera.distance * x);

  const worldToView = () => {
    const { right, up, back } = axes(), at = eye();
    return [right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0, -dot(right, at), -dot(up, at), -dot(back, at), 1];
  };

  /* Half of the angle of view belongs to the shorter side. */
  const tangents = () => {
    const t = Math.tan(FIELD_OF_VIEW / 2);
    return camera.aspect >= 1 ? [t * camera.aspect, t] : [t, t / camera.aspect];
  };

  /* reach: everything lies within this distance of the origin. */
  const viewToClip = (reach) => {
    const [x, y] = tangents(), away = Math.hypot(...eye());
    const near = Math.max(away - reach, camera.distance * 0.02), far = away + reach + near;
    return [1 / x, 0, 0, 0, 0, 1 / y, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0];
  };

  /* Through a point of the picture, from -1 to 1 each way. */
  const ray = (x, y) => {
    const { right, up, back } = axes(), [tx, ty] = tangents();
    return { from: eye(), along: [0, 1, 2].map((i) => right[i] * x * tx + up[i] * y * ty - back[i]) };
  };

  const orbit = (azimuth, elevation) => {
    camera.azimuth = (camera.azimuth + azimuth) % 360;
    camera.elevation = Math.max(-90, Math.min(90, camera.elevation + elevation));
  };
  /* By parts of the picture's height. */
  const pan = (x, y) => {
    const { right, up } = axes(), size = 2 * camera.distance * tangents()[1];
    for (let i = 0; i < 3; i++) camera.centre[i] -= (right[i] * x + up[i] * y) * size;
  };
  const zoom = (factor) => { camera.distance = Math.max(0.002, Math.min(100, camera.distance * factor)); };
  /* Takes hold of what lies at a point, from the picture's middle by parts of its height; what it returns puts that there and zooms, counted from the beginning. */
  const grasp = (x, y) => {
    const { right, up } = axes(), { centre: [...begin], distance } = camera, height = () => 2 * camera.distance * tangents()[1], size = height();
    return (toX, toY, factor) => {
      camera.distance = distance;
      zoom(factor);
      for (let i = 0; i < 3; i++) camera.centre[i] = begin[i] + right[i] * (x * size - toX * height()) + up[i] * (y * size - toY * height());
    };
  };
  /* To where it stood first, but for what start says. */
  const reset = (start) => Object.assign(camera, camera.home, { centre: [...camera.home.centre] }, start);
  /* What it comes back to from now on. */
  const settle = (start) => { camera.home = { ...FRONT, ...start }; reset(); };

  /* The pose in which the points fill the picture, seen from there. Turned about, what is long may then reach beyond it: so never closer than closest. Through the planes at the picture's borders: each
   * point wants |x| <= t (eye's z - z), so the outermost of x + t z and of x - t z say how far off the eye is, and where. */
  const framing = (points, { azimuth, elevation } = FRONT, closest = CLOSEST) => {
    const { right, up, back } = axes({ azimuth, elevation }), at = [0, 0];
    let distance = closest;
    [right, up].forEach((axis, i) => {
      const t = FILLED * tangents()[i];
      let high = -Infinity, low = Infinity;
      for (const one of points) {
        const x = dot(axis, one), z = t * dot(back, one);
        high = Math.max(high, x + z);
        low = Math.min(low, x - z);
      }
      at[i] = (high + low) / 2;
      distance = Math.max(distance, (high - low) / (2 * t));
    });
    return { azimuth, elevation, distance, centre: right.map((x, i) => x * at[0] + up[i] * at[1]) };
  };

  return Object.assign(camera, { axes, eye, worldToView, viewToClip, ray, orbit, pan, zoom, grasp, reset, settle, framing });
}

/* Mouse, touch and keyboard. taken(event, phase) may claim a drag for itself ("down", "move", "up"); changed() is called after every change. */
export function steer(canvas, camera, { changed, hover, taken }) {
  const pointers = new Map();
  let claimed = null, held = null, gap = 0;

  const twoFingers = () => [...pointers.values()].slice(0, 2);
  const spread = () => { const [a, b] = twoFingers(); return Math.max(1, Math.hypot(a.x - b.x, a.y - b.y)); };
  const between = () => {
    const [a, b] = twoFingers(), { left, top, width, height } = canvas.parentElement.getBoundingClientRect();
    return [((a.x + b.x) / 2 - left - width / 2) / (height || 1), (top + height / 2 - (a.y + b.y) / 2) / (height || 1)];
  };

  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (pointers.size === 2) {
      gap = spread();
      held = camera.grasp(...between());
    }
    if (pointers.size === 1 && event.button === 0 && !event.shiftKey && taken(event, "down")) claimed = event.pointerId;
  });
  canvas.addEventListener("pointermove", (event) => {
    hover(event);
    const was = pointers.get(event.pointerId);
    if (!was) return;
    if (claimed === event.pointerId) { taken(event, "move"); return; }
    const x = event.clientX - was.x, y = event.clientY - was.y, height = canvas.clientHeight || 1;
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (held) held(...between(), gap / spread());
    else if (event.shiftKey || event.buttons & 6) camera.pan(x / height, -y / height);
    else camera.orbit(-x * 0.4, y * 0.4);
    changed();
  });
  const end = (event) => {
    if (claimed === event.pointerId) { taken(event, "up"); claimed = null; }
    pointers.delete(event.pointerId);
    if (pointers.size < 2) held = null;
  };
  canvas.addEventListener("pointerup", end);
  canvas.addEventListener("pointercancel", end);
  canvas.addEventListener("pointerleave", () => hover(null));
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    camera.zoom(Math.exp(Math.max(-1, Math.min(1, event.deltaY * (event.deltaMode ? 0.05 : 0.0015)))));
    changed();
  }, { passive: false });

  const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const step = steps[event.key];
    if (step && event.shiftKey) camera.pan(step[0] * 0.05, step[1] * 0.05);
    else if (step) camera.orbit(step[0] * 5, step[1] * 5);
    else if (event.key === "+" || event.key === "=") camera.zoom(0.9);
    else if (event.key === "-" || event.key === "_") camera.zoom(1 / 0.9);
    else if (event.key === "0" || event.key === "Home") camera.reset();
    else return;
    event.preventDefault();
    changed();
  });
}
