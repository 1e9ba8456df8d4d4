/* ?src= in the address: a model that lies beside the page on the same server, as if it had been dropped. */
const MOST_BESIDE = 5000;
const isGltf = (path) => /\.gltf$/i.test(path), isTileset = (path) => /\.json$/i.test(path);

async function bytesAt(address, path) {
  if (address.origin !== location.origin) fail(path, "because it lies on another server");
  const answer = await fetch(address).catch(() => fail(path, "the server does not answer"));
  if (!answer.ok) fail(path, `the server says ${answer.status}`);
  return new Uint8Array(await answer.arrayBuffer());
}

function fail(path, why) { throw new Error(`${path}: it could not be fetched, ${why}. Drop the file instead.`); }

/* Addresses with a scheme are a file's own data, or lie elsewhere. */
const isBeside = (uri) => typeof uri === "string" && uri && !/^([a-z][a-z0-9+.-]*:|\/\/)/i.test(uri);
const list = (value) => (Array.isArray(value) ? value : []);
const encoded = (path) => path.split("/").map(encodeURIComponent).join("/");

/* What a .gltf names beside itself. Of a broken one nothing: its reader says what is wrong. */
function namedIn(bytes) {
  try {
    const { buffers, images } = JSON.parse(new TextDecoder().decode(bytes));
    return [...list(buffers), ...list(images)].map((one) => one?.uri).filter(isBeside).slice(0, MOST_BESIDE).map(plain);
  } catch { return []; }
}

/* What the tiles of a tileset name as their contents (OGC 22-025r4; "url" before 1.0), without what a server would be asked. */
function contentsIn(bytes) {
  const named = [];
  try {
    const tiles = [JSON.parse(new TextDecoder().decode(bytes)).root];
    while (tiles.length && named.length < MOST_BESIDE) {
      const tile = tiles.pop() ?? {};
      named.push(...[tile.content, ...list(tile.contents)].map((one) => one?.uri ?? one?.url).filter(isBeside));
      tiles.push(...list(tile.children).reverse());
    }
  } catch { /* no JSON: no tiles */ }
  return named.map((uri) => plain(uri.replace(/[?#].*/s, "")));
}

const plain = (uri) => { try { return decodeURIComponent(uri); } catch { return uri; } };

/* The path that the address names; null: none. */
export const servedPath = () => new URLSearchParams(location.search).get("src");

/* Files as a drop gives them, the model first; their paths begin at its folder, so that no "./" of the address hides them. */
export async function filesServed(path) {
  const address = new URL(encoded(path), location.href);
  if (address.protocol === "file:") fail(path, "because pages that are opened as files may not read others; serve the folder (python3 -m http.server)");
  if (!isTileset(path)) return modelServed(address, path, path.slice(path.lastIndexOf("/") + 1));
  const tiles = await tilesServed(address, path, address.pathname.slice(0, address.pathname.lastIndexOf("/") + 1), new Set());
  if (!tiles.length) throw new Error(`${path}: this is no tileset with tiles that the page reads.`);
  return tiles;
}

/* name: the path in the drop. */
async function modelServed(address, path, name) {
  const bytes = await bytesAt(address, path), files = [{ path: name, read: async () => bytes }], folder = name.slice(0, name.lastIndexOf("/") + 1);
  if (!isGltf(path)) return files;
  const beside = await Promise.all(namedIn(bytes).map(async (uri) => {
    const found = await bytesAt(new URL(encoded(uri), address), uri).catch(() => null); // what is missing is told by the check
    return found && { path: folder + uri.replace(/^(\.\/)+/, ""), read: async () => found };
  }));
  return [...files, ...beside.filter(Boolean)];
}

/* The tiles of a tileset and of those that it names, each once. Only what is opened is fetched: a city has thousands. */
async function tilesServed(address, path, root, seen) {
  const files = [];
  for (const uri of contentsIn(await bytesAt(address, path))) {
    const at = new URL(encoded(uri), address), name = plain(at.pathname.startsWith(root) ? at.pathname.slice(root.length) : at.pathname.slice(1));
    if (seen.has(at.href) || seen.size === MOST_BESIDE) continue;
    seen.add(at.href);
    if (isTileset(uri)) files.push(...(await tilesServed(at, uri, root, seen)));
    else if (isGltf(uri)) files.push(...(await modelServed(at, uri, name)));
    else files.push({ path: name, read: () => bytesAt(at, uri) });
  }
  return files;
}
