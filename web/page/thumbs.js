/* A small picture of each finding's place, made when its button comes into sight and nothing else is going on. */
import { makeCamera } from "./camera.js";
import { posesOf, seek } from "./seek.js";

const WIDTH = 192, HEIGHT = 144, PAUSE = 60;
/* Cameras that are tried for one. */
const MOST_TRIED = 4;
const pause = () => new Promise((done) => setTimeout(done, PAUSE));

export function viewOf(pose, aspect, reach) {
  const other = makeCamera();
  other.reset(pose);
  other.aspect = aspect;
  return { worldToView: other.worldToView(), viewToClip: other.viewToClip(reach) };
}

/* what(finding) gives { scene, items, place, whole, up, paper, look, pins } for a finding of the model that is shown, or null; isIdle(): whether there is time for it. */
export function makeThumbs(graphics, remote, what, isIdle) {
  let waiting = [], working = false;
  /* Another model may be shown by then, and what belongs to this one be gone. */
  const untilIdle = async (canvas) => {
    while (!isIdle()) await pause();
    if (!canvas.isConnected) throw new Error("nobody sees this picture any more");
  };
  const make = async ({ finding, canvas }) => {
    const seen = await what(finding), aspect = WIDTH / HEIGHT;
    if (!seen || !canvas.isConnected) return;
    const { scene, items, place, whole, up, paper, look, pins } = seen, surface = scene.surfaces[finding.mesh];
    if (!whole) {
      const marks = await remote.markOf(scene.model.number, finding.mesh, finding.index);
      await untilIdle(canvas);
      await graphics.fillMarks(surface, "trial", marks);
    }
    const best = place ? await seek(posesOf(place, up).slice(0, MOST_TRIED), async (poses, through) => {
      await untilIdle(canvas);      /* somebody may have pressed one meanwhile, and waits for its picture */
      return graphics.countMarked(items, poses.map((pose) => viewOf(pose, aspect, 2.2)), aspect, through, "trial");
    }) : { pose: whole, faint: false, pinned: false };
    await untilIdle(canvas);
    const view = viewOf(best.pose, aspect, 2.2), pixels = await graphics.drawSmall(items, view, WIDTH, HEIGHT, [...paper, 1], { ...look, through: best.faint }, () => { if (best.pinned) pins(view); });
    for (const one of scene.surfaces) if (one.trial) { graphics.gl.deleteBuffer(one.trial); one.trial = null; }
    if (!canvas.isConnected) return;
    canvas.width = WIDTH;
    canvas.height = HEIGHT;
    const image = new ImageData(WIDTH, HEIGHT);
    for (let y = 0; y < HEIGHT; y++) image.data.set(pixels.subarray(4 * WIDTH * (HEIGHT - 1 - y), 4 * WIDTH * (HEIGHT - y)), 4 * WIDTH * y);
    canvas.getContext("2d").putImageData(image, 0, 0);
    canvas.dataset.made = "1";
  };
  const work = async () => {
    working = true;
    for (; waiting.length; await pause()) {
      const next = waiting.shift();
      await untilIdle(next.canvas).then(() => make(next)).catch(() => undefined);      /* the button says it in words */
    }
    working = false;
  };
  const watcher = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      if (!isIntersecting) continue;
      watcher.unobserve(target);
      waiting.push({ finding: target.finding, canvas: target });
    }
    if (!working) work();
  });
  /* An empty picture, which is drawn once it is in sight. */
  const add = (finding) => {
    const canvas = document.createElement("canvas");
    canvas.className = "thumb";
    canvas.setAttribute("aria-hidden", "true");
    canvas.width = canvas.height = 1;
    canvas.finding = finding;
    watcher.observe(canvas);
    return canvas;
  };
  return { add };
}
