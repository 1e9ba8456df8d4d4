/* The stage as a PNG to keep: what is drawn, on the page's paper, with the words above its halves. */

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

/* ---- a turntable: once round the model in so many seconds, as WebM */
const SECONDS = 8, RATE = 25;

/* turnTo(part): draws the model turned by this part of a whole turn. progress(part): how far it is; 1 at the end. A promise, kept when the film has been handed to the browser. */
export async function saveTurntable(canvas, shown, turnTo, progress) {
  const copy = copyOf(canvas), kind = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"].find((one) => globalThis.MediaRecorder?.isTypeSupported(one));
  if (!kind || !copy.captureStream) throw new Error("This browser records no WebM; save single pictures instead.");
  const recorder = new MediaRecorder(copy.captureStream(RATE), { mimeType: kind, videoBitsPerSecond: 8e6 }), parts = [];
  const ended = new Promise((done, fail) => {
    recorder.ondataavailable = ({ data }) => parts.push(data);
    recorder.onstop = done;
    recorder.onerror = ({ error }) => fail(error);
  });
  const begin = performance.now(), partNow = () => (performance.now() - begin) / (1000 * SECONDS);
  recorder.start();
  try {
    for (let part = 0; part < 1; part = partNow()) {
      turnTo(part);
      compose(copy, canvas, ...shown());
      progress(part);
      await new Promise((next) => setTimeout(next, 1000 / RATE));
    }
  } finally {
    recorder.stop();
    recorder.stream.getTracks().forEach((track) => track.stop());
  }
  await ended;
  progress(1);
  download(new Blob(parts, { type: kind }), "norma.webm");
}
