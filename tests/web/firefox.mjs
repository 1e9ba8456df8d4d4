/* Firefox by WebDriver BiDi, with the calls of chrome.mjs. It needs a display (Xvfb serves): without one it has no WebGL. A process for each setting of the system: light or dark, still or not. */
import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pause, waitFor } from "./wait.mjs";
import { openWebSocket } from "./websocket.mjs";

const PLACES = ["/usr/bin/firefox-esr", "/usr/bin/firefox"];
const KEYS = { Tab: "\uE004", ArrowLeft: "\uE012", ArrowUp: "\uE013", ArrowRight: "\uE014", ArrowDown: "\uE015" };

export const findFirefox = () => process.env.NORMA_FIREFOX ?? PLACES.find((path) => existsSync(path));

const preferences = ({ dark, calm }) => Object.entries({
  "webgl.force-enabled": true, "remote.active-protocols": 1, "layout.css.prefers-color-scheme.content-override": dark ? 0 : 1, "ui.prefersReducedMotion": calm ? 1 : 0,
  "dom.w3c_touch_events.enabled": 1, "browser.shell.checkDefaultBrowser": false, "browser.startup.page": 0, "browser.aboutwelcome.enabled": false, "datareporting.policy.dataSubmissionEnabled": false,
  "app.update.disabledForTesting": true, "browser.safebrowsing.update.enabled": false, "network.captive-portal-service.enabled": false, "network.connectivity-service.enabled": false,
}).map(([name, value]) => `user_pref("${name}", ${value});`).join("\n");

/* A value as BiDi sends it, as JavaScript's own. */
function valueOf({ type, value }) {
  if (type === "array") return value.map(valueOf);
  if (type === "object") return Object.fromEntries(value.map(([name, part]) => [name, valueOf(part)]));
  if (type === "number" && typeof value === "string") return Number(value);
  return type === "undefined" || type === "null" ? null : value;
}

async function start(path, settings) {
  const profile = mkdtempSync(join(tmpdir(), "norma-firefox-"));
  writeFileSync(join(profile, "user.js"), preferences(settings));
  const child = spawn(path, ["--no-remote", "--new-instance", "--profile", profile, "--remote-debugging-port", "0", "about:blank"], { stdio: ["ignore", "ignore", "pipe"] });
  const ended = new Promise((done) => child.once("exit", done));
  const address = await new Promise((done, fail) => {
    let said = "";
    child.stderr.on("data", (data) => {
      said += data;
      const found = /WebDriver BiDi listening on (ws:\S+)/.exec(said);
      if (found) done(found[1]);
    });
    ended.then(() => fail(new Error(`Firefox ended: ${said.slice(-2000)}`)));
  });
  const waiting = new Map(), listeners = [];
  let next = 1;
  const socket = await openWebSocket(`${address}/session`, (text) => {
    const message = JSON.parse(text), wait = waiting.get(message.id);
    waiting.delete(message.id);
    if (!wait) for (const listener of listeners) listener(message);
    else if (message.type === "error") wait.fail(new Error(`${wait.method}: ${message.message}`));
    else wait.done(message.result);
  }, () => { for (const wait of waiting.values()) wait.fail(new Error("Firefox ended")); });
  const send = (method, params = {}) => new Promise((done, fail) => {
    const id = next++;
    waiting.set(id, { method, done, fail });
    socket.send(JSON.stringify({ id, method, params }));
  });
  await send("session.new", { capabilities: {} });
  await send("session.subscribe", { events: ["log.entryAdded", "network.beforeRequestSent"] });
  const close = async () => {
    await Promise.race([send("browser.close").catch(() => undefined), pause(4000)]);
    await Promise.race([ended, pause(4000)]);
    if (child.exitCode === null) child.kill("SIGKILL");
    rmSync(profile, { recursive: true, force: true, maxRetries: 9 });
  };
  return { send, listeners, close };
}

export async function launchFirefox(path, { width = 1280, height = 800 } = {}) {
  const started = new Map();
  const processFor = (settings) => {
    const key = JSON.stringify(settings);
    if (!started.has(key)) started.set(key, start(path, settings));
    return started.get(key);
  };

  const open = async (url, { dark = false, calm = false, before = "", size = [width, height] } = {}) => {
    const { send, listeners } = await processFor({ dark, calm }), said = [], requests = [];
    /* A window for each: what lies behind another tab is not drawn. */
    const { context } = await send("browsingContext.create", { type: "window" });
    listeners.push(({ method, params }) => {
      if (method === "log.entryAdded" && params.source.context === context) said.push(params.type === "console" ? `console.${params.method}: ${params.text}` : `${params.level}: ${params.text}`);
      if (method === "network.beforeRequestSent" && params.context === context) requests.push(params.request.url);
    });
    await send("browsingContext.setViewport", { context, viewport: { width: size[0], height: size[1] }, devicePixelRatio: 1 });
    if (before) await send("script.addPreloadScript", { functionDeclaration: `() => { ${before} }`, contexts: [context] });
    await send("browsingContext.navigate", { context, url, wait: "interactive" });

    const evaluate = async (expression) => {
      const { result, exceptionDetails } = await send("script.evaluate", { expression, target: { context }, awaitPromise: true });
      if (exceptionDetails) throw new Error(`${expression.slice(0, 2000)}: ${exceptionDetails.text}`);
      return valueOf(result);
    };
    const until = waitFor(evaluate);
    const screenshot = async (file) => {
      const { data } = await send("browsingContext.captureScreenshot", { context, origin: "viewport" }), bytes = Buffer.from(data, "base64");
      if (file) writeFileSync(file, bytes);
      return bytes;
    };
    const act = (actions) => send("input.performActions", { context, actions });
    const mouse = (type, x, y, { deltaX = 0, deltaY = 0 } = {}) => {
      const at = { x: Math.round(x), y: Math.round(y) };
      if (type === "mouseWheel") return act([{ type: "wheel", id: "wheel", actions: [{ type: "scroll", ...at, deltaX, deltaY }] }]);
      const actions = [{ type: "pointerMove", ...at }];
      if (type !== "mouseMoved") actions.push({ type: type === "mousePressed" ? "pointerDown" : "pointerUp", button: 0 });
      return act([{ type: "pointer", id: "mouse", parameters: { pointerType: "mouse" }, actions }]);
    };
    let fingersDown = 0;
    const touch = (type, ...fingers) => {
      const kinds = { touchStart: ["pointerDown"], touchMove: [], touchEnd: ["pointerUp"] }[type], count = Math.max(fingers.length, fingersDown);
      fingersDown = type === "touchEnd" ? 0 : fingers.length;
      return act(Array.from({ length: count }, (_, i) => ({ type: "pointer", id: `finger-${i}`, parameters: { pointerType: "touch" },
        actions: [...(fingers[i] ? [{ type: "pointerMove", x: Math.round(fingers[i][0]), y: Math.round(fingers[i][1]) }] : []), ...kinds.map((kind) => ({ type: kind, button: 0 }))] })));
    };
    const press = (key) => act([{ type: "key", id: "keys", actions: ["keyDown", "keyUp"].map((type) => ({ type, value: KEYS[key] ?? key })) }]);
    const setFiles = async (id, files) => {
      const { nodes } = await send("browsingContext.locateNodes", { context, locator: { type: "css", value: `#${id}` } });
      await send("input.setFiles", { context, element: { sharedId: nodes[0].sharedId }, files });
    };
    const close = () => send("browsingContext.close", { context });
    return { evaluate, until, screenshot, mouse, touch, press, setFiles, close, said, requests };
  };

  const close = async () => { for (const made of started.values()) await (await made).close(); };
  return { open, close };
}
