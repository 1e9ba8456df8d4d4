/* The stage as a PNG to keep: what is drawn, on the page's paper, with the words above its halves. */

const paperOf = () => getComputedStyle(document.documentElement).getPropertyValue("--paper").trim() || "#fff";
const inkOf = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function write(context, text, x, y, size, colour, align) {
  context.font = `${size}px system-ui, sans-serif`;
  context.textAlign = align;
  context.fillStyle = colour;
  context.fillText(text, x, y);
}

/* canvas: just drawn; words: of the left and the right side; angle: the worst one, in words. */
export function savePicture(canvas, panels, { title, words, compared, angle }) {
  const copy = document.createElement("canvas"), context = copy.getContext("2d"), size = Math.max(14, Math.round(canvas.height / 36)), plain = (text) => text.replace(/<[^>]*>/g, "");
  copy.width = canvas.width;
  copy.height = canvas.height;
  context.fillStyle = paperOf();
  context.fillRect(0, 0, copy.width, copy.height);
  context.drawImage(canvas, 0, 0);
  const sides = panels.map(({ side }) => side);
  if (compared && sides.includes("wrong")) write(context, `${words[0]}: ${plain(words[1])}`, size, 1.6 * size, size, inkOf("--wrong"), "left");
  if (compared && sides.includes("right")) write(context, `${words[2]}: ${plain(words[3])}`, copy.width - size, 1.6 * size, size, inkOf("--right"), "right");
  write(context, compared ? `worst angle ${angle}` : title, copy.width - size, copy.height - size, size, inkOf("--faint"), "right");
  copy.toBlob((blob) => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = "norma.png";
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
  });
}
