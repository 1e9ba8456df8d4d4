// baked.mjs MODULES FOLDER: writes the models of baked.sh. A coarse ball whose halves share one chart,
// mirrored, with a normal map that was baked for the tangents of three.js's addon; the same ball cut
// so finely that it has the baked normals itself; and the coarse one with sums per vertex for tangents.
//   bare.gltf        without tangents
//   reference.gltf   with the addon's, to draw beside
//   fine.gltf        no map: the surface that was baked
//   other.gltf       with tangents for which the map was not baked
import { writeFileSync } from "node:fs";
import { deflateSync } from "node:zlib";
import { pathToFileURL } from "node:url";

const [modules, folder] = process.argv.slice(2);
const { generateTangents } = await import(pathToFileURL(`${modules}/three/examples/jsm/libs/mikktspace.module.js`));
const AROUND = 8, DOWN = 10, FINE = 12, TEXELS = 1024;

const unit = (a) => { const l = Math.hypot(...a); return a.map((x) => x / l); };
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const mix = (w, a, b, c) => a.map((_, k) => w[0] * a[k] + w[1] * b[k] + w[2] * c[k]);

// side 1: x > 0; side -1: the other half, the same texture coordinates. v ends short of the poles.
const angle = (v) => Math.PI * (0.06 + 0.88 * v);
const direction = (u, v, side) => [side * Math.sin(angle(v)) * Math.sin(Math.PI * u), Math.cos(angle(v)), Math.sin(angle(v)) * Math.cos(Math.PI * u)];

// The baked surface: bumps that run on across the seam, as their slope there is zero in u.
function bumpy(u, v, side) {
  const n = direction(u, v, side), along = [side * Math.cos(Math.PI * u), 0, -Math.sin(Math.PI * u)], down = cross(along, n).map((x) => side * x);
  const in_u = -0.5 * Math.sin(5 * Math.PI * u) * Math.cos(14 * v), in_v = -0.5 * Math.cos(5 * Math.PI * u) * Math.sin(14 * v);
  return unit(n.map((x, k) => x - in_u * along[k] - in_v * down[k]));
}

// Both halves, triangle by triangle, wound outwards: per corner the coordinates and the side.
function coarseCorners() {
  const corners = [];
  for (const side of [1, -1])
    for (let j = 0; j < DOWN; j++)
      for (let i = 0; i < AROUND; i++) {
        const at = (a, b) => ({ u: (i + a) / AROUND, v: (j + b) / DOWN, side });
        const quad = side > 0 ? [at(0, 0), at(0, 1), at(1, 1), at(1, 0)] : [at(1, 0), at(1, 1), at(0, 1), at(0, 0)];
        corners.push(quad[0], quad[1], quad[2], quad[0], quad[2], quad[3]);
      }
  return corners.map((c) => ({ ...c, position: direction(c.u, c.v, c.side), normal: direction(c.u, c.v, c.side) }));
}

function fineCorners(coarse) {
  const corners = [];
  for (let t = 0; t < coarse.length; t += 3) {
    const at = (a, b) => {
      const w = [1 - (a + b) / FINE, a / FINE, b / FINE];
      const blend = (name) => w[0] * coarse[t][name] + w[1] * coarse[t + 1][name] + w[2] * coarse[t + 2][name];
      const u = blend("u"), v = blend("v");
      return { u, v, position: mix(w, ...[0, 1, 2].map((k) => coarse[t + k].position)), normal: bumpy(u, v, coarse[t].side) };
    };
    for (let a = 0; a < FINE; a++)
      for (let b = 0; a + b < FINE; b++) {
        corners.push(at(a, b), at(a + 1, b), at(a, b + 1));
        if (a + b + 1 < FINE) corners.push(at(a + 1, b), at(a + 1, b + 1), at(a, b + 1));
      }
  }
  return corners;
}

const floats = (corners, of) => Float32Array.from(corners.flatMap(of));

// glTF's coordinates run downwards, so the addon's sign is turned.
function referenceTangents(corners) {
  const t = generateTangents(floats(corners, (c) => c.position), floats(corners, (c) => c.normal), floats(corners, (c) => [c.u, c.v]));
  return corners.map((_, i) => [t[4 * i], t[4 * i + 1], t[4 * i + 2], -t[4 * i + 3]]);
}

// Along u on each half, but with the sign of the right half on both.
const otherTangents = (corners) => corners.map((c) => [...unit([c.side * Math.cos(Math.PI * c.u), 0, -Math.sin(Math.PI * c.u)]), -1]);

// Texel by texel over the right half: what in the interpolated frame is the baked normal.
function bake(corners, tangents) {
  const texels = Buffer.alloc(TEXELS * TEXELS * 3, 128);
  for (let t = 0; t < corners.length / 2; t += 3) {
    const [a, b, c] = corners.slice(t, t + 3), area = (b.u - a.u) * (c.v - a.v) - (c.u - a.u) * (b.v - a.v);
    const from = (name) => Math.max(0, Math.floor(Math.min(a[name], b[name], c[name]) * TEXELS) - 1);
    const to = (name) => Math.min(TEXELS - 1, Math.ceil(Math.max(a[name], b[name], c[name]) * TEXELS) + 1);
    for (let y = from("v"); y <= to("v"); y++)
      for (let x = from("u"); x <= to("u"); x++) {
        const u = (x + 0.5) / TEXELS, v = (y + 0.5) / TEXELS;
        const second = ((u - a.u) * (c.v - a.v) - (c.u - a.u) * (v - a.v)) / area, third = ((b.u - a.u) * (v - a.v) - (u - a.u) * (b.v - a.v)) / area;
        const w = [1 - second - third, second, third];
        if (Math.min(...w) < -1e-9) continue;
        const frame = [0, 1, 2].map((k) => ({ n: corners[t + k].normal, t: tangents[t + k] }));
        const n = unit(mix(w, ...frame.map((f) => f.n))), along = mix(w, ...frame.map((f) => f.t.slice(0, 3)));
        const against = mix(w, ...frame.map((f) => cross(f.n, f.t).map((z) => z * f.t[3])));
        // Solved, not projected: along and against are not quite perpendicular.
        const wanted = bumpy(u, v, 1), det = dot(along, cross(against, n));
        const bent = unit([dot(wanted, cross(against, n)) / det, dot(wanted, cross(n, along)) / det, dot(wanted, cross(along, against)) / det]);
        bent.forEach((z, k) => { texels[(y * TEXELS + x) * 3 + k] = Math.round((0.5 + 0.5 * z) * 255); });
      }
  }
  return texels;
}

function crc32(bytes) {
  let crc = -1;
  for (const byte of bytes) {
    crc ^= byte;
    for (let k = 0; k < 8; k++) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc >>> 0;
}

function png(texels) {
  const chunk = (name, body) => {
    const named = Buffer.concat([Buffer.from(name), body]), out = Buffer.alloc(8 + named.length);
    out.writeUInt32BE(body.length, 0); named.copy(out, 4); out.writeUInt32BE(crc32(named), 4 + named.length);
    return out;
  };
  const head = Buffer.alloc(13);
  head.writeUInt32BE(TEXELS, 0); head.writeUInt32BE(TEXELS, 4); head.set([8, 2, 0, 0, 0], 8);
  const rows = Buffer.alloc(TEXELS * (1 + TEXELS * 3));
  for (let y = 0; y < TEXELS; y++) texels.copy(rows, y * (1 + TEXELS * 3) + 1, y * TEXELS * 3, (y + 1) * TEXELS * 3);
  return Buffer.concat([Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]), chunk("IHDR", head), chunk("IDAT", deflateSync(rows)), chunk("IEND", Buffer.alloc(0))]);
}

function writeGltf(name, corners, { tangents, map }) {
  const streams = { POSITION: floats(corners, (c) => c.position), NORMAL: floats(corners, (c) => c.normal), TEXCOORD_0: floats(corners, (c) => [c.u, c.v]) };
  if (tangents) streams.TANGENT = Float32Array.from(tangents.flat());
  const kinds = { POSITION: "VEC3", NORMAL: "VEC3", TEXCOORD_0: "VEC2", TANGENT: "VEC4" }, names = Object.keys(streams);
  const bytes = Buffer.concat(names.map((n) => Buffer.from(streams[n].buffer)));
  let offset = 0;
  const asset = {
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: Object.fromEntries(names.map((n, i) => [n, i])), material: 0 }] }],
    materials: [map ? { normalTexture: { index: 0 } } : {}],
    accessors: names.map((n, i) => ({ bufferView: i, componentType: 5126, count: corners.length, type: kinds[n], ...(n === "POSITION" ? { min: [-1, -1, -1], max: [1, 1, 1] } : {}) })),
    bufferViews: names.map((n) => { const view = { buffer: 0, byteOffset: offset, byteLength: streams[n].byteLength }; offset += view.byteLength; return view; }),
    buffers: [{ byteLength: bytes.length, uri: `data:application/octet-stream;base64,${bytes.toString("base64")}` }],
    ...(map ? { images: [{ uri: "bumps.png" }], textures: [{ source: 0, sampler: 0 }], samplers: [{ wrapS: 33071, wrapT: 33071 }] } : {}),
  };
  writeFileSync(`${folder}/${name}.gltf`, JSON.stringify(asset));
}

const coarse = coarseCorners(), tangents = referenceTangents(coarse);
writeFileSync(`${folder}/bumps.png`, png(bake(coarse, tangents)));
writeGltf("bare", coarse, { map: true });
writeGltf("reference", coarse, { map: true, tangents });
writeGltf("other", coarse, { map: true, tangents: otherTangents(coarse) });
writeGltf("fine", fineCorners(coarse), {});
