/* How the stage is divided: into panels, each with a side (wrong, right, or the angle between them), a box in pixels of the page from the top left, and the part of it that is seen. */

/* Below three panels that are narrow lies a strip for what is read. */
const STRIP = 84, NARROW = 600;
/* Above each of them its name. */
export const NAME = 30;

const whole = (width, height) => ({ x: 0, y: 0, width, height });

/* Two pictures and, below them, what differs; beside that one, room for words. */
function beside(width, height) {
  const strip = width < NARROW ? STRIP : 0, upper = Math.round(0.56 * (height - strip)), half = Math.floor(width / 2), low = height - upper - strip;
  return [
    { side: "wrong", box: { x: 0, y: NAME, width: half, height: upper - NAME } },
    { side: "right", box: { x: half, y: NAME, width: width - half, height: upper - NAME } },
    { side: "angle", box: { x: 0, y: upper + NAME, width: half, height: low - NAME } },
  ];
}

/* kind: right, wrong, split, beside; split: where the line is, from 0 to 1. */
export function panelsOf(kind, width, height, split) {
  if (kind === "beside") return beside(width, height);
  const box = whole(width, height);
  if (kind !== "split") return [{ side: kind, box }];
  return [{ side: "wrong", box, from: 0, to: split * width }, { side: "right", box, from: split * width, to: width }];
}

/* The panel at a point of the stage, and where that is in it, from -1 to 1 each way. */
export function panelAt(panels, x, y) {
  const panel = panels.find(({ box, from = box.x, to = box.x + box.width }) => x >= from && x < to && y >= box.y && y < box.y + box.height);
  return panel && { panel, x: (2 * (x - panel.box.x)) / panel.box.width - 1, y: 1 - (2 * (y - panel.box.y)) / panel.box.height };
}
