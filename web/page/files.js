/* Files that somebody dropped or chose: single ones, several, folders, zips. Each as { path, read }; the models among them. */
import { listZip } from "./zip.js";

export const EXPECTED = "OBJ, PLY, STL, 3MF, GLB, VRM, a 3D Tile, or glTF with its .bin files; several files, a folder or a zip are fine";
const MODELS = ["gltf", "glb", "vrm", "obj", "ply", "stl", "3mf", "b3dm", "i3dm", "cmpt"];
const MOST_FILES = 5000;

const ending = (path) => (/\.([^./]+)$/.exec(path)?.[1] ?? "").toLowerCase();
const isHidden = (path) => path.split("/").some((part) => part.startsWith(".") || part === "__MACOSX");
const depth = (path) => path.split("/").length;
const folderOf = (path) => path.slice(0, path.lastIndexOf("/") + 1);

const bytesOf = async (file) => new Uint8Array(await file.arrayBuffer());
const plain = (file, path = file.webkitRelativePath || file.name) => ({ path, read: () => bytesOf(file) });

const fileOf = (entry) => new Promise((done, fail) => entry.file(done, fail));
const partOf = (reader) => new Promise((done, fail) => reader.readEntries(done, fail));

async function walk(entry, found) {
  if (entry.isFile) { found.push(plain(await fileOf(entry), entry.fullPath.replace(/^\//, ""))); return; }
  const reader = entry.createReader();
  for (let part = await partOf(reader); part.length && found.length < MOST_FILES; part = await partOf(reader)) for (const inner of part) await walk(inner, found);
}

/* What a drop brings. Entries must be asked for before anything is waited for. */
export async function filesOfDrop(transfer) {
  const entries = [...(transfer.items ?? [])].map((item) => item.webkitGetAsEntry?.()), found = [];
  if (!entries.some((entry) => entry?.isDirectory)) return [...transfer.files].map((file) => plain(file));
  for (const entry of entries) if (entry) await walk(entry, found);
  return found;
}
export const filesOfInput = (input) => [...input.files].map((file) => plain(file));

async function unpack(file) {
  return ending(file.path) === "zip" ? listZip(await file.read(), file.path) : [file];
}

/* All files, zips unpacked, and the paths of the models among them, the uppermost first. */
export async function gather(given) {
  const files = (await Promise.all(given.map(unpack))).flat().filter(({ path }) => !isHidden(path));
  const models = files.map(({ path }) => path).filter((path) => MODELS.includes(ending(path)));
  models.sort((a, b) => depth(a) - depth(b) || MODELS.indexOf(ending(a)) - MODELS.indexOf(ending(b)) || a.localeCompare(b));
  if (models.length) return { files, models };
  const named = given.length === 1 ? `${given[0].path}: this is no model that the page reads.` : `None of these ${given.length} files is a model that the page reads.`;
  throw new Error(`${named} Drop ${EXPECTED}.`);
}

/* What a model needs to be read: itself and, for a .gltf, what lies in its folder but other models. */
export async function bytesFor(files, model) {
  const inFolder = ({ path }) => path.startsWith(folderOf(model)) && !MODELS.includes(ending(path)) && !/^(zip|txt|md)$/.test(ending(path));
  const needed = files.filter((file) => file.path === model || (ending(model) === "gltf" && inFolder(file)));
  return { path: model, files: await Promise.all(needed.map(async ({ path, read }) => ({ path, bytes: await read() }))) };
}

/* What to do about a file that could not be opened. */
export const hintFor = (message) => (/buffer .* cannot be read/.test(message) ? `${message}. Drop the .gltf together with its .bin files, or the whole folder.` : message);

/* A link that hands out bytes. */
export function downloadLink({ path, bytes }) {
  const link = document.createElement("a"), name = path.split("/").pop();
  link.href = URL.createObjectURL(new Blob([bytes]));
  link.download = name;
  link.textContent = `Download ${name}`;
  link.className = "download";
  return link;
}

export function listFiles(id, files) {
  document.getElementById(id).replaceChildren(...files.map((file) => {
    const item = document.createElement("li");
    item.append(downloadLink(file));
    return item;
  }));
}
