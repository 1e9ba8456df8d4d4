// fix-closed.mjs BEFORE AFTER: for each mesh in folder AFTER the edges that do not cancel, by exact positions, compared with the file of the same name in folder BEFORE.
// An edge cancels where as many faces run along it one way as the other: a fix must not leave more edges that do not. Reads OBJ and STL by itself. Prints what grew;
// the last line counts the files that were compared.
import { readFileSync, readdirSync, existsSync } from "node:fs";
import { join } from "node:path";

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
    return faces;
}

function facesOfStl(bytes) {
    const faces = [], count = bytes.length >= 84 ? bytes.readUInt32LE(80) : -1;
    if (bytes.length >= 84 + 50 * count && count >= 0 && bytes.length < 84 + 50 * count + 50) {
        for (let f = 0; f < count; f++)
            faces.push([0, 1, 2].map((k) => [0, 1, 2].map((axis) => bytes.readFloatLE(84 + 50 * f + 12 + 12 * k + 4 * axis) + 0).join(" ")));
        return faces;
    }
    let face = [];
    for (const match of bytes.toString("latin1").matchAll(/vertex\s+(\S+)\s+(\S+)\s+(\S+)/gi)) {
        face.push(match.slice(1, 4).map((x) => Math.fround(Number(x)) + 0).join(" "));
        if (face.length === 3) { faces.push(face); face = []; }
    }
    return faces;
}

function looseEdges(path) {
    const bytes = readFileSync(path), sums = new Map();
    for (const corners of /\.stl$/i.test(path) ? facesOfStl(bytes) : facesOfObj(bytes)) {
        const face = corners.filter((point, i) => point !== corners[(i + 1) % corners.length]);
        if (face.length < 3 || new Set(face).size < 2) continue;
        face.forEach((a, i) => {
            const b = face[(i + 1) % face.length], key = a < b ? `${a}|${b}` : `${b}|${a}`;
            sums.set(key, (sums.get(key) ?? 0) + (a < b ? 1 : -1));
        });
    }
    return [...sums.values()].filter((sum) => sum !== 0).length;
}

const [before, after] = process.argv.slice(2);
let compared = 0;
for (const name of existsSync(after) ? readdirSync(after) : []) {
    if (!/\.(obj|stl)$/i.test(name) || !existsSync(join(before, name))) continue;
    const was = looseEdges(join(before, name)), is = looseEdges(join(after, name));
    compared++;
    if (is > was) console.log(`${name}: ${was} edges did not cancel, ${is} do not after the fix`);
}
console.log(`${compared} compared`);
