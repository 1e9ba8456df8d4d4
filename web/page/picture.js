/* The stage as a PNG to keep: what is drawn, on the page's paper, with the words above its halves; and a film of it. */
import { BufferTarget, CanvasSource, getFirstEncodableVideoCodec, Output, WebMOutputFormat } from "mediabunny";

const paperOf = () => getComputedStyle(document.documentElement).getPropertyValue("--paper").trim() || "#fff";
const inkOf = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function write(context, text, x, y, size, colour, align) {
  context.font = `${size}px system-ui, sans-serif`;
  context.textAlign = align;
  context.fillStyle = colour;
  context.fillText(text, x, y);
}

/* Writes into copy what the canvas has just drawn; words: of the left and the right side; angle: the worst one, in words. */
function compose(copy, canvas, panels, { title, words, compared, angle }) {
  const context = copy.getContext("2d"), size = Math.max(14, Math.round(canvas.height / 36)), plain = (text) => text.replace(/<[^>]*>/g, "");
  context.fillStyle = paperOf();
  context.fillRect(0, 0, copy.width, copy.height);
  context.drawImage(canvas, 0, 0);
  const line = panels.find(({ from }) => from > 0)?.from, scale = canvas.width / canvas.clientWidth;
  context.fillStyle = inkOf("--ink");
  if (line !== undefined) context.fillRect(scale * (line - 1), 0, 2 * scale, copy.height);
  const sides = panels.map(({ side }) => side);
  if (compared && sides.includes("wrong")) write(context, `${words[0]}: ${plain(words[1])}`, size, 1.6 * size, size, inkOf("--wrong"), "left");
  if (compared && sides.includes("right")) write(context, `${words[2]}: ${plain(words[3])}`, copy.width - size, 1.6 * size, size, inkOf("--right"), "right");
  write(context, compared ? `worst angle ${angle}` : title, copy.width - size, copy.height - size, size, inkOf("--faint"), "right");
}

function copyOf({ width, height }) { return Object.assign(document.createElement("canvas"), { width, height }); }

function download(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

/* shown(): the panels as they stand, and the words about them. */
export function savePicture(canvas, shown) {
  const copy = copyOf(canvas);
  compose(copy, canvas, ...shown());
  copy.toBlob((blob) => download(blob, "norma.png"));
}

/* ---- a turntable: once round the model in so many seconds, as WebM. Frames carry their own times, so that the film is whole however slowly it is drawn and encoded. */
const SECONDS = 8, RATE = 25, FRAMES = SECONDS * RATE;

/* turnTo(part): draws the model turned by this part of a whole turn. progress(part): how far it is; 1 at the end. A promise, kept when the film has been handed to the browser. */
export async function saveTurntable(canvas, shown, turnTo, progress) {
  progress(0);
  const copy = copyOf({ width: canvas.width & ~1, height: canvas.height & ~1 }), codec = await getFirstEncodableVideoCodec(["vp9", "vp8"], copy);
  if (!codec) throw new Error("This browser encodes no WebM here; save single pictures instead.");
  const film = new Output({ format: new WebMOutputFormat(), target: new BufferTarget() }), frames = new CanvasSource(copy, { codec, bitrate: 8e6 });
  film.addVideoTrack(frames, { frameRate: RATE });
  await film.start();
  try {
    for (let frame = 0; frame < FRAMES; ++frame) {
      turnTo(frame / FRAMES);
      compose(copy, canvas, ...shown());
      await frames.add(frame / RATE, 1 / RATE);
      progress(frame / FRAMES);
      await new Promise((next) => setTimeout(next));
    }
    await film.finalize();
  } catch (error) {
    await film.cancel();
    throw error;
  }
  progress(1);
  download(new Blob([film.target.buffer], { type: "video/webm" }), "norma.webm");
}
