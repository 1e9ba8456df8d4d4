/* ?src= in the address: a model that lies beside the page on the same server, as if it had been dropped. */
const MOST_BESIDE = 5000;
const isGltf = (path) => /\.gltf$/i.test(path);

async function bytesAt(address, path) {
  if (address.origin !== location.origin) fail(path, "because it lies on another server");
  const answer = await fetch(address).catch(() => fail(path, "the server does not answer"));
  if (!answer.ok) fail(path, `the server says ${answer.status}`);
  return new Uint8Array(await answer.arrayBuffer());
}

function fail(path, why) { throw new Error(`${path}: it could not be fetched, ${why}. Drop the file instead.`); }

/* What a .gltf names beside itself; addresses with a scheme are its own data, or lie elsewhere. Of a broken one nothing: its reader says what is wrong. */
function namedIn(bytes) {
  try {
    const { buffers, images } = JSON.parse(new TextDecoder().decode(bytes)), list = (value) => (Array.isArray(value) ? value : []);
    return [...list(buffers), ...list(images)].map((one) => one?.uri).filter((uri) => typeof uri === "string" && uri && !/^([a-z][a-z0-9+.-]*:|\/\/)/i.test(uri)).slice(0, MOST_BESIDE).map(plain);
  } catch { return []; }
}

const plain = (uri) => { try { return decodeURIComponent(uri); } catch { return uri; } };

/* The path that the address names; null: none. */
export const servedPath = () => new URLSearchParams(location.search).get("src");

/* Files as a drop gives them, the model first; their paths begin at its folder, so that no "./" of the address hides them. */
export async function filesServed(path) {
  const address = new URL(path.split("/").map(encodeURIComponent).join("/"), location.href);
  if (address.protocol === "file:") fail(path, "because pages that are opened as files may not read others; serve the folder (python3 -m http.server)");
  const bytes = await bytesAt(address, path), files = [{ path: path.slice(path.lastIndexOf("/") + 1), read: async () => bytes }];
  if (!isGltf(path)) return files;
  const beside = await Promise.all(namedIn(bytes).map(async (uri) => {
    const found = await bytesAt(new URL(uri.split("/").map(encodeURIComponent).join("/"), address), uri).catch(() => null); // what is missing is told by the check
    return found && { path: uri.replace(/^(\.\/)+/, ""), read: async () => found };
  }));
  return [...files, ...beside.filter(Boolean)];
}
