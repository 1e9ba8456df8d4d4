// fix-closed.mjs BEFORE AFTER | --list PAIRS: for each mesh in folder AFTER the edges that do not cancel, by exact positions, compared with the file of the same name in folder
// BEFORE; or for each line "BEFORE tab AFTER" of a file. An edge cancels where as many faces run along it one way as the other: a fix must not leave more edges that do not.
// Reads OBJ, PLY, STL and glTF by itself (what is compressed is left out). Prints what grew; the last line counts the files that were compared.
import { readFileSync, readdirSync, existsSync } from "node:fs";
import { dirname, join } from "node:path";

function facesOfObj(bytes) {
    const positions = [], faces = [];
    for (const line of bytes.toString("latin1").replace(/\\\r?\n/g, " ").split(/\r\n|\r|\n/)) {
        const words = line.trim().split(/\s+/);
        if (words[0] === "v") positions.push(words.slice(1, 4).map(Number).map((x) => x + 0).join(" "));
        else if (words[0] === "f")
            faces.push(words.slice(1).filter((word) => !word.startsWith("#")).map((word) => {
                const number = parseInt(word, 10);
                return positions[number < 0 ? positions.length + number : number - 1];
            }));
    }
    return [faces];
}

function facesOfStl(bytes) {
    const faces = [], count = bytes.length >= 84 ? bytes.readUInt32LE(80) : -1;
    if (bytes.length >= 84 + 50 * count && count >= 0 && bytes.length < 84 + 50 * count + 50) {
        for (let f = 0; f < count; f++)
            faces.push([0, 1, 2].map((k) => [0, 1, 2].map((axis) => bytes.readFloatLE(84 + 50 * f + 12 + 12 * k + 4 * axis) + 0).join(" ")));
        return [faces];
    }
    let face = [];
    for (const match of bytes.toString("latin1").matchAll(/vertex\s+(\S+)\s+(\S+)\s+(\S+)/gi)) {
        face.push(match.slice(1, 4).map((x) => Math.fround(Number(x)) + 0).join(" "));
        if (face.length === 3) { faces.push(face); face = []; }
    }
    return [faces];
}

const plyTypes = { char: "Int8", uchar: "Uint8", short: "Int16", ushort: "Uint16", int: "Int32", uint: "Uint32", float: "Float32", double: "Float64" };
const plyAliases = { int8: "char", uint8: "uchar", int16: "short", uint16: "ushort", int32: "int", uint32: "uint", float32: "float", float64: "double" };

// One number after another, of a text or of binary rows.
function plyReader(bytes, at, format) {
    if (format === "ascii") {
        const words = bytes.subarray(at).toString("latin1").trim().split(/\s+/);
        let next = 0;
        return () => Number(words[next++]);
    }
    const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length), little = format === "binary_little_endian";
    return (type) => {
        const name = plyTypes[plyAliases[type] ?? type], size = Number(name.match(/\d+/)[0]) / 8, value = view[`get${name}`](at, little);
        at += size;
        return value;
    };
}

function facesOfPly(bytes) {
    const end = bytes.indexOf("end_header"), header = bytes.subarray(0, end).toString("latin1").split(/\r\n|\r|\n/).map((line) => line.trim().split(/\s+/));
    const eol = bytes[end + 10] === 13 && bytes[end + 11] === 10 ? 2 : 1, format = header.find((words) => words[0] === "format")[1], elements = [];
    for (const words of header) {
        if (words[0] === "element") elements.push({ name: words[1], count: Number(words[2]), properties: [] });
        else if (words[0] === "property") elements.at(-1).properties.push(words[1] === "list" ? { list: words[2], type: words[3], name: words[4] } : { type: words[1], name: words[2] });
    }
    const next = plyReader(bytes, end + 10 + eol, format), positions = [], faces = [];
    const strip = (list) => {
        for (let i = 0, from = 0; i < list.length; i++) {
            if (list[i] < 0) { from = i + 1; continue; }
            if (i - from >= 2) faces.push((i - from) % 2 ? [list[i - 1], list[i - 2], list[i]] : [list[i - 2], list[i - 1], list[i]]);
        }
    };
    for (const element of elements)
        for (let i = 0; i < element.count; i++) {
            const row = {};
            for (const p of element.properties)
                row[p.name] = p.list ? Array.from({ length: next(p.list) }, () => next(p.type)) : next(p.type);
            const corners = row.vertex_indices ?? row.vertex_index;
            if (element.name === "vertex") positions.push([row.x, row.y, row.z].map((x) => x + 0).join(" "));
            else if (element.name === "face") faces.push(corners);
            else if (element.name === "tristrips") strip(corners);
        }
    return [faces.map((face) => face.map((corner) => positions[corner]))];
}

const gltfTypes = { 5120: Int8Array, 5121: Uint8Array, 5122: Int16Array, 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array };
const widths = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };

function openGltf(bytes, path) {
    const glb = bytes.toString("latin1", 0, 4) === "glTF", length = glb ? bytes.readUInt32LE(12) : 0;
    const json = JSON.parse(glb ? bytes.toString("utf8", 20, 20 + length) : bytes.toString("utf8"));
    const buffers = (json.buffers ?? []).map((buffer, i) => {
        if (buffer.uri === undefined) return i === 0 && glb ? bytes.subarray(20 + length + 8) : null;
        if (buffer.uri.startsWith("data:")) return Buffer.from(buffer.uri.slice(buffer.uri.indexOf(",") + 1), "base64");
        return readFileSync(join(dirname(path), decodeURIComponent(buffer.uri)));
    });
    return { json, buffers };
}

// Rows of numbers, as stored: a common factor makes no positions equal. null: compressed.
function gltfRows({ json, buffers }, number) {
    const accessor = json.accessors[number], Type = gltfTypes[accessor.componentType], width = widths[accessor.type], size = Type.BYTES_PER_ELEMENT;
    const read = (viewNumber, offset, count, Kind, per) => {
        const view = json.bufferViews[viewNumber];
        if (view.extensions?.EXT_meshopt_compression || !buffers[view.buffer]) return null;
        const stride = (Kind === Type && view.byteStride) || per * Kind.BYTES_PER_ELEMENT, from = (view.byteOffset ?? 0) + (offset ?? 0);
        return Array.from({ length: count }, (_, i) => {
            const at = from + i * stride, row = buffers[view.buffer].subarray(at, at + per * Kind.BYTES_PER_ELEMENT);
            return Array.from(new Kind(row.buffer.slice(row.byteOffset, row.byteOffset + row.length)));
        });
    };
    const rows = accessor.bufferView === undefined ? Array.from({ length: accessor.count }, () => Array(width).fill(0)) : read(accessor.bufferView, accessor.byteOffset, accessor.count, Type, width);
    if (rows && accessor.sparse) {
        const { count, indices, values } = accessor.sparse;
        const at = read(indices.bufferView, indices.byteOffset, count, gltfTypes[indices.componentType], 1), to = read(values.bufferView, values.byteOffset, count, Type, width);
        if (!at || !to || size === 0) return null;
        at.forEach(([row], i) => { rows[row] = to[i]; });
    }
    return rows;
}

function trianglesOf(corners, mode) {
    const faces = [];
    if (mode === 4) for (let i = 0; i + 2 < corners.length; i += 3) faces.push(corners.slice(i, i + 3));
    if (mode === 5) for (let i = 0; i + 2 < corners.length; i++) faces.push(i % 2 ? [corners[i], corners[i + 2], corners[i + 1]] : corners.slice(i, i + 3));
    if (mode === 6) for (let i = 1; i + 1 < corners.length; i++) faces.push([corners[0], corners[i], corners[i + 1]]);
    return faces;
}

// The faces of each mesh, all its primitives together, once for each node that draws it: a mesh of several nodes that is baked becomes one for each.
function facesOfGltf(bytes, path) {
    const gltf = openGltf(bytes, path), { json } = gltf;
    const drawn = (json.nodes ?? []).filter((node) => node.mesh !== undefined).map((node) => node.mesh);
    const meshes = (json.meshes ?? []).map((mesh) => mesh.primitives.flatMap((primitive) => {
        if (primitive.extensions?.KHR_draco_mesh_compression || primitive.attributes?.POSITION === undefined || (primitive.mode ?? 4) < 4) return [];
        const rows = gltfRows(gltf, primitive.attributes.POSITION), indices = primitive.indices === undefined ? rows?.map((_, i) => [i]) : gltfRows(gltf, primitive.indices);
        if (!rows || !indices) return [];
        const positions = rows.map((row) => row.map((x) => x + 0).join(" "));
        return trianglesOf(indices.map(([corner]) => corner), primitive.mode ?? 4).map((face) => face.map((corner) => positions[corner]));
    }));
    return drawn.length ? drawn.map((mesh) => meshes[mesh] ?? []) : meshes;
}

function looseEdgesOf(faces) {
    const sums = new Map();
    for (const corners of faces) {
        const face = corners.filter((point, i) => point !== corners[(i + 1) % corners.length]);
        if (face.length < 3 || new Set(face).size < 2) continue;
        face.forEach((a, i) => {
            const b = face[(i + 1) % face.length], key = a < b ? `${a}|${b}` : `${b}|${a}`;
            sums.set(key, (sums.get(key) ?? 0) + (a < b ? 1 : -1));
        });
    }
    return [...sums.values()].filter((sum) => sum !== 0).length;
}

const known = new Map();
function looseEdges(path) {
    if (known.has(path)) return known.get(path);
    const bytes = readFileSync(path), end = path.toLowerCase().match(/\.(obj|ply|stl|gltf|glb)$/)?.[1];
    const read = { obj: facesOfObj, ply: facesOfPly, stl: facesOfStl, gltf: facesOfGltf, glb: facesOfGltf }[end];
    const count = read(bytes, path).reduce((sum, faces) => sum + looseEdgesOf(faces), 0);
    if (known.size > 50) known.clear();
    known.set(path, count);
    return count;
}

function pairs([first, second]) {
    if (first === "--list") return readFileSync(second, "utf8").split("\n").filter((line) => line).map((line) => line.split("\t"));
    return (existsSync(second) ? readdirSync(second) : []).filter((name) => /\.(obj|ply|stl|gltf|glb)$/i.test(name) && existsSync(join(first, name)))
        .map((name) => [join(first, name), join(second, name)]);
}

let compared = 0, unread = 0;
for (const [before, after] of pairs(process.argv.slice(2))) {
    let was, is;
    try { was = looseEdges(before); } catch { unread++; continue; } // damaged files are no judge's
    try { is = looseEdges(after); } catch (error) { console.log(`${after}: cannot be read after the fix: ${error.message}`); continue; }
    compared++;
    if (is > was) console.log(`${after}: ${was} edges did not cancel, ${is} do not after the fix`);
}
console.log(`${compared} compared${unread ? `, ${unread} not read` : ""}`);
