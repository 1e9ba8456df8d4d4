/* Materials of a glTF with their images, as three.js's GLTFLoader makes them; its meshes are left out, as Norma reads those. */
import { LoadingManager } from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

const ENDING = /\.(gltf|glb|vrm|b3dm|i3dm|cmpt)$/i;
const GLB = 0x46546c67, JSON_CHUNK = 0x4e4f534a;
const OF_MESHES = ["scene", "scenes", "nodes", "meshes", "skins", "animations", "cameras", "accessors"];
/* Extensions of meshes alone, which the loader would look for in vain. */
const OF_GEOMETRY = /draco|mesh_gpu|quantization|meshopt|lights|KHR_node|VRM/i;

/* The GLB in a file, which in a tile of 3D Tiles begins after its header. */
function glbIn(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  for (let at = 0; at + 20 <= bytes.length && at < 1 << 20; at++) if (view.getUint32(at, true) === GLB && view.getUint32(at + 16, true) === JSON_CHUNK) return bytes.subarray(at);
  return null;
}

/* What a glTF says of itself, and the GLB that it is, or null. */
function readJson(bytes) {
  const glb = glbIn(bytes), length = glb && new DataView(glb.buffer, glb.byteOffset).getUint32(12, true);
  return { glb, length, json: JSON.parse(new TextDecoder().decode(glb ? glb.subarray(20, 20 + length) : bytes)) };
}
export const hasAnimations = (files, path) => { const main = files.find((file) => file.path === path); return Boolean(main && ENDING.test(path) && readJson(main.bytes).json.animations?.length); };

/* What lacks its image is as grey as clay, times its factor: white shows no shape, and metal is a mirror of the sky. */
const CLAY = 0.5;
const greyed = ([r, g, b, a = 1] = [1, 1, 1]) => [CLAY * r, CLAY * g, CLAY * b, a];

/* Textures that are KTX2 alone: nothing here decodes those, and what refers to them goes without. Gives their number. */
function leaveOutKtx2(json) {
  const left = new Set((json.textures ?? []).flatMap(({ source, extensions }, i) => (source === undefined && extensions?.KHR_texture_basisu ? [i] : [])));
  const clear = (part) => {
    if (!part || typeof part !== "object") return;
    for (const [key, value] of Object.entries(part)) {
      if (!/texture$/i.test(key) || !left.has(value?.index)) { clear(value); continue; }
      delete part[key];
      if (key === "baseColorTexture") part.baseColorFactor = greyed(part.baseColorFactor);
      if (key === "metallicRoughnessTexture") part.metallicFactor = 0;
    }
  };
  if (left.size) clear(json.materials);
  if (left.size && json.extensionsRequired) json.extensionsRequired = json.extensionsRequired.filter((name) => name !== "KHR_texture_basisu");
  return left.size;
}

/* The same file as this page loads it: { data for the loader, number of materials, of KTX2 textures that were left out }. bare: without its meshes. */
function forLoader(bytes, bare) {
  const { glb, length, json } = readJson(bytes), count = json.materials?.length ?? 0, ktx2 = leaveOutKtx2(json);
  if (!bare && !ktx2) return { data: (glb ?? bytes).slice().buffer, count: 0, ktx2 };
  if (bare) {
    for (const name of OF_MESHES) delete json[name];
    for (const name of ["extensionsUsed", "extensionsRequired"]) if (json[name]) json[name] = json[name].filter((extension) => !OF_GEOMETRY.test(extension));
    if (json.extensions) for (const name of Object.keys(json.extensions)) if (OF_GEOMETRY.test(name)) delete json.extensions[name];
  }
  const short = new TextEncoder().encode(JSON.stringify(json)), materials = bare ? count : 0;
  if (!glb) return { data: short.buffer, count: materials, ktx2 };
  const padded = Math.ceil(short.length / 4) * 4, rest = glb.subarray(20 + length), made = new Uint8Array(20 + padded + rest.length), view = new DataView(made.buffer);
  [GLB, 2, made.length, padded, JSON_CHUNK].forEach((word, i) => view.setUint32(4 * i, word, true));
  made.fill(0x20, 20, 20 + padded);
  made.set(short, 20);
  made.set(rest, 20 + padded);
  return { data: made.buffer, count: materials, ktx2 };
}

const folderOf = (path) => path.slice(0, path.lastIndexOf("/") + 1);
const normal = (path) => path.split("/").reduce((parts, part) => (part === ".." ? parts.slice(0, -1) : part === "." ? parts : [...parts, part]), []).join("/");

/* files: [{ path, bytes }]; path: of the one that is shown; bare: without its meshes. Gives { gltf as GLTFLoader makes it, its materials where it is bare, missing: images, ktx2: textures that are left out }; null: it is no glTF. */
export async function loadGltf(files, path, bare) {
  const main = files.find((file) => file.path === path), urls = new Map();
  if (!main || !ENDING.test(path)) return null;
  const { data, count, ktx2 } = forLoader(main.bytes, bare);
  if (bare && !count) return null;
  const manager = new LoadingManager(), missing = new Set(), folder = folderOf(path);
  manager.setURLModifier((url) => {
    if (/^(blob|data):/.test(url)) return url;
    const wanted = normal(decodeURIComponent(url)), file = files.find((one) => one.path === wanted) ?? files.find((one) => one.path.split("/").pop() === wanted.split("/").pop());
    if (!file) { missing.add(wanted); return "data:,"; }
    if (!urls.has(file)) urls.set(file, URL.createObjectURL(new Blob([file.bytes])));
    return urls.get(file);
  });
  manager.onError = (url) => missing.add(url);
  const loader = new GLTFLoader(manager), materials = [];
  let parser = null;
  const lacks = async (texture) => texture !== undefined && !(await parser.getDependency("texture", texture.index).catch(() => null));
  const extendMaterialParams = async (index, made) => {
    const { baseColorTexture, metallicRoughnessTexture } = parser.json.materials[index].pbrMetallicRoughness ?? {};
    if (await lacks(baseColorTexture)) made.color.multiplyScalar(CLAY);
    if (await lacks(metallicRoughnessTexture)) made.metalness = 0;
  };
  loader.register((made) => { parser = made; return { name: "norma", extendMaterialParams }; });
  const quiet = console.warn, quietError = console.error;
  console.warn = console.error = () => undefined;      /* the page says itself what is missing */
  try {
    const gltf = await loader.parseAsync(data, folder);
    for (let i = 0; i < count; i++) materials.push(await parser.getDependency("material", i).catch(() => null));
    return { gltf, materials, missing, ktx2 };
  } finally {
    console.warn = quiet;
    console.error = quietError;
    for (const url of urls.values()) URL.revokeObjectURL(url);
  }
}

/* Gives { list: of each material its three.js material or null, unread: images that are missing or cannot be read, ktx2: textures that are not decoded }; null: it has none. */
export async function readMaterials(files, path) {
  const read = await loadGltf(files, path, true);
  return read && { list: read.materials, unread: read.missing.size, ktx2: read.ktx2 };
}

/* As GLTFLoader dresses a primitive with these attributes. */
export function dress(material, { tangents, colours }) {
  const made = material.clone();
  made.vertexColors = colours;
  if (!tangents) for (const scale of [made.normalScale, made.clearcoatNormalScale]) if (scale) scale.y *= -1;
  made.toneMapped = !made.isMeshBasicMaterial;
  return made;
}

export function freeMaterials(list) {
  for (const material of list) {
    if (!material) continue;
    for (const part of Object.values(material)) if (part?.isTexture) { part.source?.data?.close?.(); part.dispose(); }
    material.dispose();
  }
}
