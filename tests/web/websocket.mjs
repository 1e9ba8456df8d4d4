/* A WebSocket's client (RFC 6455) for text messages, as node has none of its own before version 22. */
import { createHash, randomBytes } from "node:crypto";
import { connect } from "node:net";

const TEXT = 1, CLOSE = 8, PING = 9, PONG = 10;

/* What a client sends is masked. */
function frameOf(kind, payload) {
  const mask = randomBytes(4), size = payload.length, head = size < 126 ? Buffer.alloc(2) : size < 65536 ? Buffer.alloc(4) : Buffer.alloc(10);
  head[0] = 0x80 | kind;
  head[1] = 0x80 | (size < 126 ? size : size < 65536 ? 126 : 127);
  if (head.length === 4) head.writeUInt16BE(size, 2);
  if (head.length === 10) head.writeBigUInt64BE(BigInt(size), 2);
  return Buffer.concat([head, mask, payload.map((byte, i) => byte ^ mask[i % 4])]);
}

/* The first frame of the bytes: { kind, isLast, payload, size }; null: it has not come whole. */
function readFrame(bytes) {
  if (bytes.length < 2) return null;
  const short = bytes[1] & 127, head = short < 126 ? 2 : short === 126 ? 4 : 10;
  if (bytes.length < head) return null;
  const length = short < 126 ? short : short === 126 ? bytes.readUInt16BE(2) : Number(bytes.readBigUInt64BE(2));
  if (bytes.length < head + length) return null;
  return { kind: bytes[0] & 15, isLast: bytes[0] >= 128, payload: bytes.subarray(head, head + length), size: head + length };
}

/* received(text) is called for each message, ended() once. Gives { send, close }. */
export function openWebSocket(address, received, ended) {
  const { hostname, port, pathname } = new URL(address), key = randomBytes(16).toString("base64");
  const accepted = createHash("sha1").update(`${key}258EAFA5-E914-47DA-95CA-C5AB0DC85B11`).digest("base64");
  const socket = connect({ host: hostname, port: Number(port) });
  socket.on("close", ended);
  return new Promise((done, fail) => {
    let chunks = [], parts = [], isOpen = false;
    const take = (frame) => {
      if (frame.kind === PING) socket.write(frameOf(PONG, frame.payload));
      if (frame.kind === CLOSE) socket.end();
      if (frame.kind > TEXT) return;
      parts.push(frame.payload);
      if (!frame.isLast) return;
      received(Buffer.concat(parts).toString());
      parts = [];
    };
    const shake = (bytes) => {
      const end = bytes.indexOf("\r\n\r\n");
      if (end < 0) return bytes;
      const head = bytes.toString("latin1", 0, end);
      if (!/^HTTP\/1\.1 101/.test(head) || !head.includes(accepted)) { fail(new Error(`${address}: ${head.split("\r\n")[0]}`)); socket.destroy(); return Buffer.alloc(0); }
      isOpen = true;
      done({ send: (text) => socket.write(frameOf(TEXT, Buffer.from(text))), close: () => socket.end(frameOf(CLOSE, Buffer.alloc(0))) });
      return bytes.subarray(end + 4);
    };
    socket.on("error", fail);
    socket.on("connect", () => socket.write(`GET ${pathname} HTTP/1.1\r\nHost: ${hostname}:${port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: ${key}\r\nSec-WebSocket-Version: 13\r\n\r\n`));
    socket.on("data", (data) => {
      chunks.push(data);
      let rest = chunks.length > 1 ? Buffer.concat(chunks) : data;
      if (!isOpen) rest = shake(rest);
      for (let frame = isOpen && readFrame(rest); frame; frame = readFrame(rest)) {
        take(frame);
        rest = rest.subarray(frame.size);
      }
      chunks = rest.length ? [rest] : [];
    });
  });
}
