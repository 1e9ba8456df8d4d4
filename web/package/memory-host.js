/* The tool (tool.wasm) on files in memory, in node and browsers: what it asks of WASI is answered from a Map of names and bytes. One folder, "/". */

const OK = 0, BADF = 8, EXIST = 20, INVAL = 28, NOENT = 44, NOSYS = 52, NOTDIR = 54, NOTEMPTY = 55;
const ROOT = 3, DIRECTORY = 3, REGULAR = 4, PIPE = 2;
const CREATE = 1, IS_FOLDER = 2, EXCLUSIVE = 4, TRUNCATE = 8, APPEND = 1;
const ALL_RIGHTS = (1n << 29n) - 1n;

class Exit extends Error {
  constructor(status) { super(); this.status = status; }
}

/* Bytes that grow. */
class MemoryFile {
  constructor(bytes = new Uint8Array(0)) { this.bytes = bytes; this.size = bytes.length; }
  get content() { return this.bytes.subarray(0, this.size); }
  resize(size) {
    if (size > this.bytes.length) {
      const larger = new Uint8Array(Math.max(size, 2 * this.bytes.length));
      larger.set(this.content);
      this.bytes = larger;
    }
    this.size = Math.max(this.size, size);
  }
  write(at, bytes) { this.resize(at + bytes.length); this.bytes.set(bytes, at); }
}

/* files: a Map of names and Uint8Arrays, which are not changed. The answer: the status, what was printed, and the files that are there afterwards. */
export function makeMemoryHost(words, files, memory) {
  const stored = new Map([...files].map(([name, bytes]) => [name, new MemoryFile(bytes.slice())])), encoder = new TextEncoder(), decoder = new TextDecoder();
  const printed = [1, 2].map(() => new MemoryFile()), open = new Map([[0, { file: new MemoryFile(), at: 0 }], [1, { file: printed[0], at: 0 }], [2, { file: printed[1], at: 0 }], [ROOT, { isFolder: true }]]);
  const numbers = new Map(); // of files, instead of inodes
  const view = () => new DataView(memory().buffer), bytesAt = (at, size) => new Uint8Array(memory().buffer, at >>> 0, size >>> 0);
  const nameAt = (at, size) => decoder.decode(bytesAt(at, size).slice()).replace(/^(\.?\/)+/, "").replace(/(\/\.?)+$/, "").replace(/^\.$/, "");
  const folders = new Set();
  const isFolder = (name) => name === "" || folders.has(name) || [...stored.keys()].some((other) => other.startsWith(`${name}/`));
  const setU64 = (at, number) => view().setBigUint64(at >>> 0, BigInt(number), true);
  const setU32 = (at, number) => view().setUint32(at >>> 0, number, true);

  const lists = (texts) => {
    const all = texts.map((text) => encoder.encode(`${text}\0`));
    return {
      sizes: (count, size) => { setU32(count, all.length); setU32(size, all.reduce((sum, { length }) => sum + length, 0)); return OK; },
      get: (pointers, buffer) => {
        all.forEach((bytes, i) => { setU32(pointers + 4 * i, buffer); bytesAt(buffer, bytes.length).set(bytes); buffer += bytes.length; });
        return OK;
      },
    };
  };
  const args = lists(["norma", ...words]), environment = lists(["PWD=/"]);

  const eachVector = (vectors, count, work) => {
    let sum = 0;
    for (let i = 0; i < count; i++) {
      const size = view().getUint32(vectors + 8 * i + 4, true), done = work(bytesAt(view().getUint32(vectors + 8 * i, true), size));
      sum += done;
      if (done < size) break;
    }
    return sum;
  };
  const readAt = (file, at) => (out) => {
    const part = file.content.subarray(at, at + out.length);
    out.set(part);
    at += part.length;
    return part.length;
  };
  const describe = (at, kind, file) => {
    bytesAt(at, 64).fill(0);
    if (file && !numbers.has(file)) numbers.set(file, numbers.size + 2);
    setU64(at + 8, file ? numbers.get(file) : 1);
    view().setUint8(at + 16, kind);
    setU64(at + 24, 1);
    setU64(at + 32, file?.size ?? 0);
    return OK;
  };
  const withFile = (descriptor, work) => { const entry = open.get(descriptor); return entry?.file ? work(entry) : BADF; };

  const wasi = {
    args_get: args.get, args_sizes_get: args.sizes, environ_get: environment.get, environ_sizes_get: environment.sizes,
    clock_time_get: (clock, precision, at) => { setU64(at, Math.round(Date.now() * 1e6)); return OK; },
    proc_exit: (status) => { throw new Exit(status); },
    fd_prestat_get: (descriptor, at) => { if (descriptor !== ROOT) return BADF; setU32(at, 0); setU32(at + 4, 1); return OK; },
    fd_prestat_dir_name: (descriptor, at) => { bytesAt(at, 1)[0] = 0x2f; return OK; },
    fd_fdstat_get: (descriptor, at) => {
      const entry = open.get(descriptor);
      if (!entry) return BADF;
      bytesAt(at, 24).fill(0);
      view().setUint8(at, entry.isFolder ? DIRECTORY : descriptor < ROOT ? PIPE : REGULAR);
      for (const rights of [8, 16]) setU64(at + rights, ALL_RIGHTS);
      return OK;
    },
    fd_fdstat_set_flags: () => OK,
    fd_filestat_get: (descriptor, at) => { const entry = open.get(descriptor); return entry ? describe(at, entry.isFolder ? DIRECTORY : descriptor < ROOT ? PIPE : REGULAR, entry.file) : BADF; },
    fd_close: (descriptor) => (open.delete(descriptor) ? OK : BADF),
    fd_sync: () => OK,
    fd_read: (descriptor, vectors, count, read) => withFile(descriptor, (entry) => {
      const got = eachVector(vectors, count, readAt(entry.file, entry.at));
      entry.at += got;
      setU32(read, got);
      return OK;
    }),
    fd_pread: (descriptor, vectors, count, at, read) => withFile(descriptor, ({ file }) => { setU32(read, eachVector(vectors, count, readAt(file, Number(at)))); return OK; }),
    fd_write: (descriptor, vectors, count, written) => withFile(descriptor, (entry) => {
      setU32(written, eachVector(vectors, count, (bytes) => { entry.file.write(entry.appends ? entry.file.size : entry.at, bytes); entry.at += bytes.length; return bytes.length; }));
      return OK;
    }),
    fd_seek: (descriptor, offset, whence, at) => withFile(descriptor, (entry) => {
      const place = Number(offset) + [0, entry.at, entry.file.size][whence];
      if (descriptor < ROOT || place < 0) return INVAL;
      entry.at = place;
      setU64(at, place);
      return OK;
    }),
    fd_readdir: () => NOSYS, // names are given, never looked for
    path_open: (folder, follows, path, size, how, base, inheriting, flags, at) => {
      const name = nameAt(path, size);
      let file = stored.get(name);
      if (!file && isFolder(name)) file = null;
      else if (how & IS_FOLDER) return file ? NOTDIR : NOENT;
      else if (!file && !(how & CREATE)) return NOENT;
      else if (file && how & CREATE && how & EXCLUSIVE) return EXIST;
      else if (!file || how & TRUNCATE) stored.set(name, (file = new MemoryFile()));
      let descriptor = ROOT + 1;
      while (open.has(descriptor)) descriptor++;
      open.set(descriptor, file ? { file, at: 0, appends: Boolean(flags & APPEND) } : { isFolder: true });
      setU32(at, descriptor);
      return OK;
    },
    path_filestat_get: (folder, follows, path, size, at) => {
      const name = nameAt(path, size), file = stored.get(name);
      return file ? describe(at, REGULAR, file) : isFolder(name) ? describe(at, DIRECTORY) : NOENT;
    },
    path_readlink: (folder, path, size) => { const name = nameAt(path, size); return stored.has(name) || isFolder(name) ? INVAL : NOENT; },
    path_create_directory: (folder, path, size) => {
      const name = nameAt(path, size);
      if (stored.has(name) || isFolder(name)) return EXIST;
      folders.add(name);
      return OK;
    },
    path_remove_directory: (folder, path, size) => {
      const name = nameAt(path, size);
      if ([...stored.keys(), ...folders].some((other) => other.startsWith(`${name}/`))) return NOTEMPTY;
      return folders.delete(name) ? OK : NOENT;
    },
    path_link: (folder, follows, path, size, to, other, otherSize) => {
      const file = stored.get(nameAt(path, size)), name = nameAt(other, otherSize);
      if (!file || stored.has(name)) return file ? EXIST : NOENT;
      stored.set(name, file);
      return OK;
    },
    path_rename: (folder, path, size, to, other, otherSize) => {
      const name = nameAt(path, size), file = stored.get(name);
      if (!file) return NOENT;
      stored.delete(name);
      stored.set(nameAt(other, otherSize), file);
      return OK;
    },
    path_unlink_file: (folder, path, size) => (stored.delete(nameAt(path, size)) ? OK : NOENT),
  };
  /* What else the tool asks of its host (web/package/tool/no_posix.c): everything may be read and written. */
  const norma = {
    host_status: (descriptor, path, follows, found) => { new Uint32Array(memory().buffer, found >>> 0, 3).set([0o644, 0, 0]); return OK; },
    host_access: () => OK, host_chmod: () => OK, host_chown: () => OK, host_path: () => NOSYS, host_user: () => 0, host_process: () => 1,
  };
  return {
    imports: { wasi_snapshot_preview1: wasi, norma },
    finish: (status) => ({ status, stdout: decoder.decode(printed[0].content), stderr: decoder.decode(printed[1].content), files: new Map([...stored].map(([name, file]) => [name, file.content.slice()])) }),
  };
}

/* Starts the tool; 0 without a call of exit. */
export function startTool(exports) {
  try {
    exports._start();
    return 0;
  } catch (error) {
    if (error instanceof Exit) return error.status;
    throw error;
  }
}
