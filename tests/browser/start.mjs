// A headless Chromium for tests of pages, spoken to over a pipe: needs node and Chromium and nothing else. What goes wrong on a page is
// gathered: errors on its console, exceptions, and every request that leaves the machine.
//
//     const browser = await start({ width: 1280, height: 800 });
//     const page = await browser.open(pathToFileURL("out/quick-compare/report.html").href, { dark: true, width: 400, height: 800, reducedMotion: true });
//     await page.evaluate(() => document.title);        // runs in the page
//     await page.key("ArrowRight");                     // as from a keyboard
//     await page.screenshot("page.png");
//     await page.close();                               // then page.faults is final: it should be empty
//     browser.end();
//
// A browser that ends by itself ends the process with exit code ENDED: a page is not to blame, and `check` tries again.
import { spawn, spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";

const NAMES = [process.env.CHROMIUM, "chromium", "chromium-browser", "google-chrome"].filter(Boolean);
const KEYS = { " ": [32, "Space"], Enter: [13, "Enter"], Tab: [9, "Tab"], ArrowLeft: [37, "ArrowLeft"], ArrowRight: [39, "ArrowRight"] };
const ENDED = 75; // EX_TEMPFAIL of sysexits.h
const PATIENCE = 60_000; // [ms] for an answer of the browser, which may share a busy machine

// The command of a Chromium on this machine; null: there is none.
export function chromium() {
  return NAMES.find((name) => spawnSync(name, ["--version"]).status === 0) || null;
}

// The text of axe-core, which looks for what keeps people out; null where npm has not installed it (AXE names its folder).
export function axe() {
  const folders = [process.env.AXE, import.meta.dirname].filter(Boolean);
  for (const folder of folders) {
    try {
      return readFileSync(createRequire(join(folder, "x.js")).resolve("axe-core/axe.min.js"), "utf8");
    } catch {
      // not there
    }
  }
  return null;
}

export async function start({ width = 1280, height = 800 } = {}) {
  const home = mkdtempSync(join(tmpdir(), "diptych-browser-"));
  const flags = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run", "--disable-extensions"];
  flags.push("--disable-background-networking", "--disable-dev-shm-usage", "--remote-debugging-pipe", `--user-data-dir=${home}`, `--window-size=${width},${height}`);
  const child = spawn(chromium(), flags, { stdio: ["ignore", "ignore", "pipe", "pipe", "pipe"] });
  const ending = watch(child);
  const waiting = new Map();
  const listeners = new Set();
  let [last, rest] = [0, ""];
  child.stdio[4].setEncoding("utf8");
  child.stdio[4].on("data", (chunk) => {
    const messages = (rest + chunk).split("\0");
    rest = messages.pop();
    for (const message of messages.map((text) => JSON.parse(text))) {
      if (message.id) waiting.get(message.id)?.(message);
      else listeners.forEach((listener) => listener(message));
    }
  });
  const send = (method, params = {}, sessionId) =>
    new Promise((resolve, reject) => {
      const id = ++last;
      const late = setTimeout(() => reject(new Error(`no answer to ${method}`)), PATIENCE);
      waiting.set(id, (message) => {
        clearTimeout(late);
        waiting.delete(id);
        if (message.error) reject(new Error(`${method}: ${message.error.message}`));
        else resolve(message.result);
      });
      child.stdio[3].write(`${JSON.stringify({ id, method, params, sessionId })}\0`);
    });
  const end = () => {
    ending.wanted = true;
    child.kill();
    child.once("exit", () => remove(home, 20));
  };
  return { open: (url, options = {}) => open({ send, listeners }, url, { width, height, ...options }), end };
}

// Ends this process when the browser ends unasked, with the last that it said; its pipes may break before its end is known.
function watch(child) {
  const ending = { wanted: false };
  let said = "";
  child.stderr.setEncoding("utf8");
  child.stderr.on("data", (chunk) => (said = (said + chunk).slice(-2000)));
  const ended = (how) => {
    if (ending.wanted) return;
    console.error(`the browser ended (${how}); the last it said:\n${said}`);
    process.exit(ENDED);
  };
  const broken = (why) => setTimeout(ended, 1000, why.message);
  for (const pipe of [child.stderr, child.stdio[3], child.stdio[4]]) pipe.on("error", broken);
  child.once("exit", (code, signal) => ended(signal || `exit code ${code}`));
  return ending;
}

// Helpers of the browser end a little later than itself, and may still write into the folder that is removed.
function remove(folder, tries) {
  try {
    rmSync(folder, { recursive: true, force: true });
  } catch (why) {
    if (tries === 0) throw why;
    setTimeout(() => remove(folder, tries - 1), 100);
  }
}

async function open({ send, listeners }, url, { width, height, dark = false, reducedMotion = false, print = false, script = true }) {
  const { targetId } = await send("Target.createTarget", { url: "about:blank" });
  const { sessionId } = await send("Target.attachToTarget", { targetId, flatten: true });
  const tell = (method, params) => send(method, params, sessionId);
  const faults = [];
  let loaded = () => {};
  const listener = ({ method, params, sessionId: of }) => {
    if (of !== sessionId) return;
    if (method === "Runtime.exceptionThrown") faults.push(`exception: ${params.exceptionDetails.exception?.description || params.exceptionDetails.text}`);
    if (method === "Runtime.consoleAPICalled" && params.type === "error") faults.push(`console: ${params.args.map((arg) => arg.value).join(" ")}`);
    if (method === "Log.entryAdded" && params.entry.level === "error") faults.push(`log: ${params.entry.text} ${params.entry.url || ""}`);
    if (method === "Network.requestWillBeSent" && isOutside(params.request.url, url)) faults.push(`request: ${params.request.url}`);
    if (method === "Page.loadEventFired") loaded();
  };
  listeners.add(listener);
  for (const domain of ["Page", "Runtime", "Log", "Network"]) await tell(`${domain}.enable`);
  await tell("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: 1, mobile: false });
  const features = [["prefers-color-scheme", dark ? "dark" : "light"], ["prefers-reduced-motion", reducedMotion ? "reduce" : "no-preference"]];
  await tell("Emulation.setEmulatedMedia", { media: print ? "print" : "screen", features: features.map(([name, value]) => ({ name, value })) });
  await tell("Emulation.setScriptExecutionDisabled", { value: !script });
  const done = new Promise((resolve) => (loaded = resolve));
  await tell("Page.navigate", { url });
  await done;
  const evaluate = async (work, ...given) => {
    const expression = typeof work === "function" ? `(${work})(...${JSON.stringify(given)})` : work;
    const { result, exceptionDetails } = await tell("Runtime.evaluate", { expression, awaitPromise: true, returnByValue: true });
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description || exceptionDetails.text);
    return result.value;
  };
  const key = async (name) => {
    const [code, physical] = KEYS[name];
    const one = { key: name, code: physical, windowsVirtualKeyCode: code, nativeVirtualKeyCode: code };
    const text = { " ": " ", Enter: "\r" }[name];
    await tell("Input.dispatchKeyEvent", { type: text ? "keyDown" : "rawKeyDown", ...(text ? { text } : {}), ...one });
    await tell("Input.dispatchKeyEvent", { type: "keyUp", ...one });
  };
  const screenshot = async (path, whole = false) => {
    const { data } = await tell("Page.captureScreenshot", { format: "png", captureBeyondViewport: whole });
    writeFileSync(path, Buffer.from(data, "base64"));
  };
  const close = async () => {
    await send("Target.closeTarget", { targetId });
    listeners.delete(listener);
    return faults;
  };
  return { evaluate, key, screenshot, close, faults };
}

// Files and data are at hand; of servers only the one that the page came from is.
function isOutside(request, page) {
  if (/^(file|data|blob|about):/.test(request)) return false;
  return new URL(request).origin !== new URL(page).origin;
}

// Serious faults that axe-core finds on a page, a line each; null without axe-core.
export async function barriers(page) {
  const text = axe();
  if (text === null) return null;
  await page.evaluate(text);
  return page.evaluate(async () => {
    const { violations } = await window.axe.run(document, { resultTypes: ["violations"] });
    const serious = violations.filter(({ impact }) => impact === "serious" || impact === "critical");
    return serious.map(({ id, nodes }) => `${id}: ${nodes.slice(0, 3).map(({ target, failureSummary }) => `${target} ${failureSummary}`).join(" | ")}`);
  });
}

// Collects what is not as it should be, and ends the process with a word about it.
export function checks() {
  const failed = [];
  let passed = 0;
  return {
    check: (good, words) => (good ? (passed += 1) : failed.push(words)),
    end: () => {
      failed.forEach((words) => console.error(`failed: ${words}`));
      console.log(`${passed} checks passed, ${failed.length} failed`);
      process.exitCode = failed.length ? 1 : 0;
    },
    exists: existsSync,
  };
}
