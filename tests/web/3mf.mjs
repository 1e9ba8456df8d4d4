/* node 3mf.mjs PACKAGE TOOL FILE: a 3MF fixed from its bytes has the tool's members; what unpacks to something else than the zip says is refused as the tool does it, and soon. node's zlib packs and judges. */
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { constants, crc32 as zlibSum, deflateRawSync, inflateRawSync } from "node:zlib";
import { attempt, finish } from "./tap.mjs";

const [folder, tool, turned] = process.argv.slice(2), { load } = await import(pathToFileURL(`${folder}/node.js`)), norma = await load(), scratch = mkdtempSync(join(tmpdir(), "norma-3mf-"));
const sumOf = zlibSum ?? ((bytes) => ~bytes.reduce((sum, byte) => { for (let bit = 0, x = sum ^ byte; bit <= 8; bit++) { if (bit === 8) return x; x = (x >>> 1) ^ (x & 1 ? 0xedb88320 : 0); } }, -1));

/* Of the local headers, one behind the other: name, method, packed bytes, what they unpack to. */
function membersOf(bytes) {
  const members = [];
  for (let at = 0; bytes.readUInt32LE(at) === 0x04034b50;) {
    const method = bytes.readUInt16LE(at + 8), packed = bytes.readUInt32LE(at + 18), name = bytes.readUInt16LE(at + 26), from = at + 30 + name + bytes.readUInt16LE(at + 28), content = bytes.subarray(from, from + packed);
    members.push({ name: bytes.toString("latin1", at + 30, at + 30 + name), method, packed: content, content: method ? inflateRawSync(content) : content, sum: bytes.readUInt32LE(at + 14) });
    at = from + packed;
  }
  return members;
}

/* members: { name, method, packed, size, sum }. */
function zipOf(members) {
  const locals = [], entries = [];
  let at = 0;
  for (const { name, method, packed, size, sum } of members) {
    const head = Buffer.alloc(26), place = Buffer.alloc(16);
    [[20, 0], [method, 4], [name.length, 22]].forEach(([value, to]) => head.writeUInt16LE(value, to));
    [[sum >>> 0, 10], [packed.length, 14], [size, 18]].forEach(([value, to]) => head.writeUInt32LE(value, to));
    place.writeUInt32LE(at, 12);
    locals.push(Buffer.from("PK\x03\x04"), head, Buffer.from(name), packed);
    entries.push(Buffer.from("PK\x01\x02\x14\0"), head, place.subarray(2), Buffer.from(name));
    at += 30 + name.length + packed.length;
  }
  const directory = Buffer.concat(entries), end = Buffer.alloc(22);
  end.write("PK\x05\x06", "latin1");
  [[members.length, 8], [members.length, 10]].forEach(([value, to]) => end.writeUInt16LE(value, to));
  [[directory.length, 12], [at, 16]].forEach(([value, to]) => end.writeUInt32LE(value, to));
  return Buffer.concat([...locals, directory, end]);
}
const RELS = Buffer.from('<R><Relationship Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel" Target="/m"/></R>');
const packageOf = (model) => zipOf([{ name: "_rels/.rels", method: 0, packed: RELS, size: RELS.length, sum: sumOf(RELS) }, { name: "m", method: 8, ...model }]);

const made = packageOf((() => {
  const [, { content }] = membersOf(readFileSync(turned)).sort((a, b) => a.name.endsWith(".model") - b.name.endsWith(".model")).slice(-2);
  return { packed: deflateRawSync(content), size: content.length, sum: sumOf(content) };
})());

for (const [name, bytes] of [["turned.3mf", readFileSync(turned)], ["packed.3mf", made]])
  await attempt(`${name}: fix writes what the tool writes, and all else keeps its packed bytes`, async () => {
    const from = join(scratch, name), to = join(scratch, `fixed-${name}`);
    writeFileSync(from, bytes);
    const { status } = spawnSync(tool, ["check", from, "--fix-unsafe", "--no-config", "-o", to]), { bytes: fixed } = await norma.fix(bytes, { name, unsafe: true });
    const before = membersOf(bytes), want = membersOf(readFileSync(to)), got = membersOf(Buffer.from(fixed)), say = (list) => JSON.stringify(list.map((member) => [member.name, member.content.toString("latin1")]));
    if (status !== 0 || want.length !== got.length || say(want) !== say(got) || say(got) === say(before)) throw new Error(`${status} ${say(got).slice(0, 2000)}`);
    for (const [i, member] of got.entries()) {
      if (sumOf(member.content) >>> 0 !== member.sum) throw new Error(`${member.name}: its checksum`);
      if (!/m(odel)?$/.test(member.name) && !member.packed.equals(before[i].packed)) throw new Error(`${member.name} was packed anew`);
    }
    const { summary } = await norma.check(fixed, { name });
    if (summary.errors) throw new Error("errors are left");
  });

await attempt("a mirrored and stretched item: no command is offered for what no fix removes", async () => {
  const text = '<model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources><object id="1" type="model"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="0" y="1" z="0"/><vertex x="0" y="0" z="1"/></vertices><triangles>'
    + '<triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3"/><triangle v1="1" v2="2" v3="3"/><triangle v1="2" v2="0" v3="3"/></triangles></mesh></object></resources><build><item objectid="1" transform="-2 0 0 0 1 0 0 0 1 0 0 0"/></build></model>';
  const content = Buffer.from(text), { files: [{ findings }] } = await norma.check(packageOf({ packed: deflateRawSync(content), size: content.length, sum: sumOf(content) }), { name: "item.3mf" });
  const stretched = findings.find(({ rule }) => rule === "N601");
  if (!stretched || stretched.fix || stretched.command || !/; no fix: .*3MF/.test(stretched.message)) throw new Error(JSON.stringify(findings));
});

const model = membersOf(made)[1].content, packed = deflateRawSync(model), part = deflateRawSync(Buffer.alloc(3e8), { finishFlush: constants.Z_FULL_FLUSH }), far = Buffer.concat([...Array(10).fill(part), deflateRawSync(Buffer.alloc(0))]), sum = sumOf(model);
const broken = {
  "shorter than the zip says": { packed, size: model.length + 1, sum }, "longer than the zip says": { packed, size: model.length - 1, sum }, "with another checksum": { packed, size: model.length, sum: sum ^ 1 },
  "cut": { packed: packed.subarray(0, packed.length - 9), size: model.length, sum }, "no stream": { packed: Buffer.from([7, 7, 7]), size: model.length, sum }, "empty": { packed: Buffer.alloc(0), size: model.length, sum },
  "three gigabytes that call themselves a megabyte": { packed: far, size: 1e6, sum }, "three gigabytes": { packed: far, size: 3e9, sum },
};
for (const [what, member] of Object.entries(broken))
  await attempt(`a model that is ${what} is refused as the tool does it`, async () => {
    const bytes = packageOf(member), file = join(scratch, "broken.3mf"), began = performance.now();
    writeFileSync(file, bytes);
    const { files: [{ status, findings }] } = await norma.check(bytes, { name: "broken.3mf" }), took = performance.now() - began;
    const want = JSON.parse(spawnSync(tool, ["check", "--no-config", "--format", "json", file], { encoding: "utf8" }).stdout).files[0];
    if (status !== "unreadable" || findings[0].message !== want.findings[0].message) throw new Error(`${findings[0]?.message}, not ${want.findings[0].message}`);
    if (took > 2000) throw new Error(`it took ${took} ms`);
  });
finish();
