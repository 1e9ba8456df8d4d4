// native.mjs: the library's tangents, through build/tests/tangents_of.
import { spawn } from "node:child_process";

export class Native {
  constructor(program, mode, threads = 1) {
    this.child = spawn(program, [mode, String(threads)], { stdio: ["pipe", "pipe", "inherit"] });
    this.chunks = [];
    this.have = 0;
    this.waiting = null;
    this.child.stdout.on("data", (chunk) => {
      this.chunks.push(chunk);
      this.have += chunk.length;
      this.serve();
    });
    this.child.on("exit", () => this.waiting?.reject(new Error("tangents_of ended")));
  }

  serve() {
    if (!this.waiting || this.have < this.waiting.size) return;
    const all = Buffer.concat(this.chunks);
    const { size, resolve } = this.waiting;
    this.waiting = null;
    this.chunks = [all.subarray(size)];
    this.have -= size;
    resolve(all.subarray(0, size));
  }

  // Corners of triangles: their tangents and reasons.
  async tangents(positions, normals, texcoords) {
    const count = positions.length / 3;
    for (const part of [Uint32Array.of(count), positions, normals, texcoords])
      this.child.stdin.write(Buffer.from(part.buffer, part.byteOffset, part.byteLength));
    const bytes = await new Promise((resolve, reject) => {
      this.waiting = { size: 17 * count, resolve, reject };
      this.serve();
    });
    const copy = new Uint8Array(bytes);
    return { tangents: new Float32Array(copy.buffer, 0, 4 * count), reasons: copy.subarray(16 * count) };
  }

  close() {
    this.child.stdin.end();
  }
}

// The meshes of files, as the program writes them: each with its corners and the library's answer.
export async function* meshesOf(program, mode, path) {
  const child = spawn(program, [mode, "1", path], { stdio: ["ignore", "pipe", "inherit"] });
  const chunks = [];
  for await (const chunk of child.stdout) chunks.push(chunk);
  const status = await new Promise((resolve) => (child.exitCode === null ? child.on("exit", resolve) : resolve(child.exitCode)));
  if (status !== 0) throw new Error(`${path}: status ${status}`);
  const bytes = Uint8Array.from(Buffer.concat(chunks));
  let at = 0;
  const floats = (count) => {
    const part = new Float32Array(bytes.slice(at, at + 4 * count).buffer);
    at += 4 * count;
    return part;
  };
  while (at < bytes.length) {
    const count = new DataView(bytes.buffer).getUint32(at, true);
    at += 4;
    const m = { positions: floats(3 * count), normals: floats(3 * count), texcoords: floats(2 * count), tangents: floats(4 * count) };
    m.reasons = bytes.slice(at, (at += count));
    yield m;
  }
}
