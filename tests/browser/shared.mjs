// Pages beside the lab itself: a file with recorded runs, and a run while it goes on.
//
//     node tests/browser/shared.mjs PROGRAM [FOLDER for pictures]
import { spawn, spawnSync } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { barriers, checks, start } from "./start.mjs";

const [program, pictures] = process.argv.slice(2);
if (pictures) mkdirSync(pictures, { recursive: true });
const { check, end } = checks();
const work = mkdtempSync(join(tmpdir(), "diptych-pages-"));
const browser = await start();

// In the page: waits until a number that the page keeps for tests has grown beyond a limit.
const grows = async (name, limit) => {
  const value = () => Number(document.documentElement.dataset[name] ?? -1);
  for (let tries = 0; tries < 400 && !(value() > limit); tries++) await new Promise((resolve) => setTimeout(resolve, 50));
  return value() > limit;
};
const colours = () =>
  [...document.querySelectorAll("canvas")].map((canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const found = new Set();
    for (let k = 0; k < data.length; k += 4) found.add((data[k] << 16) | (data[k + 1] << 8) | data[k + 2]);
    return found.size;
  });

async function looked(page, name) {
  check((await page.evaluate(colours)).every((count) => count > 3), `${name}: an empty canvas`);
  ((await barriers(page)) || []).forEach((words) => check(false, `${name}: ${words}`));
  if (pictures) await page.screenshot(join(pictures, `${name}.png`), true);
}

// Moves the slider of a knob to a place; answers with what all knobs show then.
const turn = async (id, place) => {
  const slider = document.getElementById(id);
  const before = document.documentElement.dataset.serial;
  slider.value = place;
  slider.dispatchEvent(new Event("input"));
  while (document.documentElement.dataset.serial === before) await new Promise((resolve) => setTimeout(resolve, 20));
  return Object.fromEntries([...document.querySelectorAll(".knob")].map((knob) => [knob.querySelector("input, select").id, knob.querySelector("output").textContent]));
};

async function recorded() {
  const file = join(work, "cradle.html");
  const made = spawnSync(program, ["lab", "--export", file, "--scene", "cradle"]);
  check(made.status === 0, `--export: ${made.stderr}`);
  const page = await browser.open(pathToFileURL(file).href, { width: 1280, height: 800 });
  check(await page.evaluate(grows, "time", 5e-5), "the recorded run does not move");
  await looked(page, "recorded");
  const first = await page.evaluate(turn, "knob-e", 0);
  const second = await page.evaluate(turn, "knob-k", 0);
  check(first["knob-e"] === "0.5" && second["knob-k"] === "300 N/m", `sliders do not reach their ends: ${JSON.stringify([first, second])}`);
  check(second["knob-e"] === "1", `two settings differ from the case at once: ${JSON.stringify(second)}`);
  check(await page.evaluate(grows, "time", 2e-4), "the recorded run of a slider does not move");
  await page.evaluate(turn, "knob-number", 0);
  check(await page.evaluate(grows, "time", 5e-5), "a run with fewer spheres does not move");
  check((await page.close()).length === 0, `recorded: ${page.faults.join("; ")}`);
}

async function live() {
  const options = ["--model", "hard", "--out", join(work, "run"), "--live", "--set", "run.duration=2 s"];
  const run = spawn(program, ["run", "cases/quick.toml", ...options], { stdio: ["ignore", "ignore", "pipe"] });
  process.once("exit", () => run.kill());
  const gone = new Promise((resolve) => run.once("exit", resolve));
  const url = await new Promise((resolve) => {
    run.stderr.on("data", (text) => {
      const address = /http:\S+/.exec(text);
      if (address) resolve(address[0]);
    });
  });
  const page = await browser.open(url, { width: 1280, height: 800 });
  check(await page.evaluate(grows, "drawn", 2), "the run is not drawn");
  await looked(page, "live");
  run.kill("SIGINT");
  check((await gone) === 130, "Ctrl-C does not stop the run");
  check((await page.close()).length === 0, `live: ${page.faults.join("; ")}`);
}

await recorded();
await live();
browser.end();
rmSync(work, { recursive: true, force: true });
end();
