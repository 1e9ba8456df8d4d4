#!/usr/bin/env node
/* npx norma-mesh: the tool norma, compiled to WebAssembly, under node's WASI. It runs in a thread of its own, so that signals are heard. WASI has neither rights nor owners of files; node is asked for them. */
import { accessSync, closeSync, fchmodSync, fchownSync, lstatSync, openSync, readFileSync, rmSync, statSync, writeSync } from "node:fs";
import { setFlagsFromString } from "node:v8";
import { Worker, isMainThread, parentPort } from "node:worker_threads";

import { allLibraries, makeDecoders } from "./decoders.js";

const fileOf = (name) => new URL(name, import.meta.url);
const compile = async (name) => WebAssembly.compile(readFileSync(fileOf(name)));

/* That WASI is an experiment of node's is no news to who checks a mesh. */
async function importWasi() {
  const { emitWarning } = process;
  process.emitWarning = () => {};
  try { return (await import("node:wasi")).WASI; } finally { process.emitWarning = emitWarning; }
}

/* WASI's numbers of errors, which are not the system's. */
const ERRORS = { EACCES: 2, EBADF: 8, EINVAL: 28, EIO: 29, ELOOP: 32, ENAMETOOLONG: 37, ENOENT: 44, ENOTDIR: 54, EPERM: 63, EROFS: 69 };
const EAGAIN = 6, EPIPE = 64;
const numberOf = ({ code }) => ERRORS[code] ?? ERRORS.EIO;
const attempt = (work) => { try { work(); return 0; } catch (error) { return numberOf(error); } };

/* A file that is being written (src/io/file/file_write.c). */
const TEMPORARY = new RegExp(`/\\.norma-${process.pid}-[0-9]+\\.tmp$`);

/* Calls that WASI lacks, and WASI's path_open, which remembers where descriptors lead to. */
function makeHost(wasi, memory) {
  const paths = new Map();
  const bytesAt = (at, size) => new Uint8Array(memory().buffer, at >>> 0, size);
  const textAt = (at) => { const bytes = new Uint8Array(memory().buffer, at >>> 0); return Buffer.from(bytes.subarray(0, bytes.indexOf(0))); };
  /* A name is bytes, in whichever encoding. */
  const pathAt = (at) => { const text = textAt(at); return text[0] === 0x2f ? text : Buffer.concat([Buffer.from(`${process.cwd()}/`), text]); };
  const withDescriptor = (descriptor, work) => attempt(() => {
    const file = openSync(paths.get(descriptor), "r");
    try { work(file); } finally { closeSync(file); }
  });
  const { path_open: open } = wasi;
  const opened = (folder, flags, path, size, ...rest) => {
    const result = open(folder, flags, path, size, ...rest);
    const name = Buffer.concat([paths.get(folder) ?? Buffer.alloc(0), Buffer.from("/"), bytesAt(path, size)]);
    if (result !== 0) return result;
    paths.set(new DataView(memory().buffer).getUint32(rest.at(-1), true), name);
    if (TEMPORARY.test(name)) parentPort.postMessage(name);
    return result;
  };
  const norma = {
    host_status: (descriptor, path, follows, found) => attempt(() => {
      const name = path ? pathAt(path) : paths.get(descriptor), { mode, uid, gid } = (follows ? statSync : lstatSync)(name);
      new Uint32Array(memory().buffer, found, 3).set([mode, uid, gid]);
    }),
    host_access: (path, mode) => attempt(() => accessSync(pathAt(path), mode)),
    host_chmod: (descriptor, mode) => withDescriptor(descriptor, (file) => fchmodSync(file, mode)),
    host_chown: (descriptor, owner, group) => withDescriptor(descriptor, (file) => fchownSync(file, owner, group)),
    host_path: (descriptor, out, room) => attempt(() => {
      const name = paths.get(descriptor);
      if (!name) throw Object.assign(new Error(), { code: "EBADF" });
      if (name.length >= room) throw Object.assign(new Error(), { code: "ENAMETOOLONG" });
      bytesAt(out, room).fill(0).set(name);
    }),
    host_user: () => process.geteuid?.() ?? 0,
    host_process: () => process.pid,
  };
  /* node makes pipes return at once when they are full: wait until they are read. It hears no SIGPIPE; whoever reads no more ends the tool all the same. */
  const still = new Int32Array(new SharedArrayBuffer(4));
  const written = (descriptor, ...rest) => {
    let result;
    while ((result = wasi.fd_write(descriptor, ...rest)) === EAGAIN) Atomics.wait(still, 0, 0, 5);
    if (result === EPIPE && descriptor === 1) process.exit(128 + 13);
    return result;
  };
  return { norma, wasi_snapshot_preview1: { ...wasi, path_open: opened, fd_write: written } };
}

async function run(words) {
  const libraries = allLibraries(() => compile("draco.wasm"));
  const decoders = makeDecoders(libraries);
  const [WASI, module] = await Promise.all([importWasi(), compile("tool.wasm"), decoders.loadAll()]);
  const wasi = new WASI({ version: "preview1", args: ["norma", ...words], env: { ...process.env, PWD: process.cwd() }, preopens: { "/": "/" }, returnOnExit: true });
  let instance = null;
  const { norma, ...host } = makeHost(wasi.wasiImport, () => instance.exports.memory);
  instance = await WebAssembly.instantiate(module, { ...host, norma: { ...norma, ...decoders.imports.norma } });
  decoders.serve(instance.exports);
  return wasi.start(instance);
}

/* What is being written is taken away when a signal ends the process, and the old file stays. */
function start(words) {
  const worker = new Worker(new URL(import.meta.url), { argv: words }), written = new Set();
  worker.on("message", (name) => written.add(Buffer.from(name)));
  worker.on("error", ({ message }) => { console.error(`norma: ended by a fault: ${message}`); process.exit(3); });
  worker.on("exit", (status) => { process.exitCode = status; });
  /* The thread may wait for its input; only a signal ends it then. */
  for (const name of ["SIGINT", "SIGTERM", "SIGHUP"]) process.once(name, () => {
    for (const file of written) rmSync(file, { force: true });
    writeSync(2, "norma: interrupted\n");
    process.kill(process.pid, name);
  });
}

/* node 20 crashes (a segmentation fault, or "unreachable code") when a program of its WASI lets memory grow while the collector marks in steps: files of some 30 MB and more. */
setFlagsFromString("--no-incremental-marking");
if (isMainThread) start(process.argv.slice(2));
else process.exit(await run(process.argv.slice(2)));
