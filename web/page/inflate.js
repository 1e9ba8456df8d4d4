/* What is packed: the files of a zip, and the page's modules, which lie in it deflated and in base64. */
export async function inflate(bytes) {
  const reader = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw")).getReader(), parts = [];
  for (let part = await reader.read(); !part.done; part = await reader.read()) parts.push(part.value);
  return new Uint8Array(await new Blob(parts).arrayBuffer());
}

export const bytesOf = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
export const moduleOf = (text) => inflate(bytesOf(text));
