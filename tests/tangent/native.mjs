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
