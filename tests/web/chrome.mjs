/* Headless Chromium over its debugging pipe: no dependency. Everything that a page says or asks for is kept. */
import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pause, waitFor } from "./wait.mjs";

const PLACES = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome", "/usr/bin/google-chrome-stable"];

export function findChrome() { return process.env.NORMA_CHROME ?? PLACES.find((path) => existsSync(path)); }

export async function launch(path, { width = 1280, height = 800, flags = [] } = {}) {
  const profile = mkdtempSync(join(tmpdir(), "norma-chrome-"));
  const child = spawn(path, ["--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--remote-debugging-pipe", `--user-data-dir=${profile}`,
    "--no-first-run", "--no-default-browser-check", "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage",
    `--window-size=${width},${height}`, ...flags, "about:blank"], { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
  const ended = new Promise((done) => child.once("exit", done));
  const waiting = new Map(), listeners = [];
  let next = 1, rest = Buffer.alloc(0);

  child.stdio[4].on("data", (data) => {
    rest = Buffer.concat([rest, data]);
    for (let end = rest.indexOf(0); end >= 0; end = rest.indexOf(0)) {
      const message = JSON.parse(rest.subarray(0, end).toString());
      rest = rest.subarray(end + 1);
      const wait = waiting.get(message.id);
      waiting.delete(message.id);
      if (wait) message.error ? wait.fail(new Error(`${wait.method}: ${message.error.message}`)) : wait.done(message.result);
      else for (const listener of listeners) listener(message);
    }
  });
  child.once("exit", () => { for (const wait of waiting.values()) wait.fail(new Error("Chromium ended")); });
  const send = (method, params = {}, sessionId = undefined) => new Promise((done, fail) => {
    const id = next++;
    waiting.set(id, { method, done, fail });
    child.stdio[3].write(`${JSON.stringify({ id, method, params, sessionId })}\0`);
  });

  const open = async (url, { dark = false, calm = false, before = "", mobile = false, size = [width, height] } = {}) => {
    const { targetId } = await send("Target.createTarget", { url: "about:blank" });
    const { sessionId } = await send("Target.attachToTarget", { targetId, flatten: true });
    const ask = (method, params) => send(method, params, sessionId);
    const said = [], requests = [];
    listeners.push((message) => {
      if (message.sessionId !== sessionId) return;
      const { method, params } = message;
      if (method === "Runtime.exceptionThrown") said.push(`exception: ${params.exceptionDetails.exception?.description ?? params.exceptionDetails.text}`);
      if (method === "Runtime.consoleAPICalled") said.push(`console.${params.type}: ${params.args.map((arg) => arg.value ?? arg.description).join(" ")}`);
      if (method === "Log.entryAdded") said.push(`${params.entry.level}: ${params.entry.text}`);
      if (method === "Network.requestWillBeSent") requests.push(params.request.url);
    });
    for (const domain of ["Page", "Runtime", "Log", "Network", "DOM"]) await ask(`${domain}.enable`);
    await ask("Emulation.setDeviceMetricsOverride", { width: size[0], height: size[1], deviceScaleFactor: 1, mobile });
    if (mobile) await ask("Emulation.setTouchEmulationEnabled", { enabled: true, maxTouchPoints: 2 });
    const shade = (isDark) => ask("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value: isDark ? "dark" : "light" }, { name: "prefers-reduced-motion", value: calm ? "reduce" : "no-preference" }] });
    await shade(dark);
    if (before) await ask("Page.addScriptToEvaluateOnNewDocument", { source: before });
    await ask("Page.navigate", { url });

    const evaluate = async (expression) => {
      const { result, exceptionDetails } = await ask("Runtime.evaluate", { expression, awaitPromise: true, returnByValue: true });
      if (exceptionDetails) throw new Error(`${expression}: ${exceptionDetails.exception?.description ?? exceptionDetails.text}`);
      return result.value;
    };
    const until = waitFor(evaluate);
    const screenshot = async (file, form = { format: "png" }) => {
      const { data } = await ask("Page.captureScreenshot", form);
      const bytes = Buffer.from(data, "base64");
      if (file) writeFileSync(file, bytes);
      return bytes;
    };
    const mouse = (type, x, y, more = {}) => ask("Input.dispatchMouseEvent", { type, x, y, button: "none", ...more });
    /* fingers: [x, y] of each that is down; those that are not named any more were lifted. */
    const touch = (type, ...fingers) => ask("Input.dispatchTouchEvent", { type, touchPoints: fingers.map(([x, y], id) => ({ x, y, id })) });
    const press = async (key, modifiers = 0) => {
      const text = key.length === 1 ? key : undefined;
      await ask("Input.dispatchKeyEvent", { type: text ? "keyDown" : "rawKeyDown", key, text, modifiers, code: key === " " ? "Space" : key, windowsVirtualKeyCode: { Tab: 9, ArrowLeft: 37, ArrowUp: 38, ArrowRight: 39, ArrowDown: 40, " ": 32 }[key] ?? 0 });
      await ask("Input.dispatchKeyEvent", { type: "keyUp", key, modifiers });
    };
    const setFiles = async (id, files) => {
      const { root } = await ask("DOM.getDocument", {}), { nodeId } = await ask("DOM.querySelector", { nodeId: root.nodeId, selector: `#${id}` });
      await ask("DOM.setFileInputFiles", { nodeId, files });
    };
    /* The tasks of the pages' main threads while work goes on: milliseconds each took, and those of them that the processor spent on it. */
    const tasks = async (work) => {
      const events = [];
      const ended = new Promise((done) => listeners.push(({ method, params }) => {
        if (method === "Tracing.dataCollected") events.push(...params.value);
        if (method === "Tracing.tracingComplete") done();
      }));
      await send("Tracing.start", { transferMode: "ReportEvents", traceConfig: { includedCategories: ["toplevel", "disabled-by-default-devtools.timeline"] } });
      await work();
      await send("Tracing.end");
      await ended;
      const main = new Set(events.filter(({ name, args }) => name === "thread_name" && args.name === "CrRendererMain").map(({ pid, tid }) => `${pid} ${tid}`));
      return events.filter(({ name, pid, tid }) => /RunTask$/.test(name) && main.has(`${pid} ${tid}`)).filter(({ dur, tdur }) => dur >= 0 && tdur >= 0).map(({ dur, tdur }) => ({ wall: dur / 1000, processor: tdur / 1000 }));
    };
    const close = () => send("Target.closeTarget", { targetId });
    return { evaluate, until, screenshot, mouse, touch, press, setFiles, tasks, shade, close, said, requests };
  };

  const close = async () => {
    await Promise.race([send("Browser.close").catch(() => undefined), pause(2000)]);
    await Promise.race([ended, pause(3000)]);
    if (child.exitCode === null) child.kill("SIGKILL");
    rmSync(profile, { recursive: true, force: true, maxRetries: 30, retryDelay: 200 });
  };
  return { open, close };
}
