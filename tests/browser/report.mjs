// Reports in a browser: they load offline without an error, answer on the first screen, play by keyboard alone, and can be read in
// the dark, on a narrow screen, on paper and without script.
//
//     node tests/browser/report.mjs FOLDER [FOLDER for pictures]
//
// FOLDER holds folders of results with a report.html each.
import { mkdirSync, readdirSync, statSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { barriers, checks, start } from "./start.mjs";

const [folder, pictures] = process.argv.slice(2);
const reports = readdirSync(folder).filter((name) => statSync(join(folder, name)).isDirectory());
if (pictures) mkdirSync(pictures, { recursive: true });
const { check, end } = checks();
const browser = await start();
let accessible = true;

for (const name of reports) {
  const path = resolve(folder, name, "report.html");
  const url = pathToFileURL(path).href;
  const size = statSync(path).size;
  check(size <= 3e6, `${name}: ${size} bytes; 3 MB are allowed`);

  const page = await browser.open(url);
  if (pictures) await page.screenshot(join(pictures, `${name}.png`));
  const seen = await page.evaluate(look);
  check(seen.words <= 900, `${name}: ${seen.words} words outside folds; 900 are allowed`);
  check(seen.answer > 0 && seen.answer <= 800, `${name}: the answer ends at ${seen.answer} px, below the first screen`);
  check(seen.wide <= 1280, `${name}: ${seen.wide} px wide`);
  if (seen.matrix) check(seen.front <= 800, `${name}: the first screen ends at ${seen.front} px`);
  for (const link of seen.links) check(await page.evaluate(leads, link), `${name}: ${link} leads nowhere, or not to what is unfolded`);
  const serious = await barriers(page);
  if (serious === null) accessible = false;
  else serious.forEach((words) => check(false, `${name}: ${words}`));
  if (seen.player) await play(name, page);
  check((await page.close()).length === 0, `${name}: ${page.faults.join("; ")}`);

  await look_at(name, url, "dark", { dark: true });
  const narrow = await look_at(name, url, "narrow", { width: 400, height: 800 });
  check(narrow.wide <= 400, `${name}: ${narrow.wide} px wide on a screen of 400`);
  await look_at(name, url, "print", { print: true });
  const bare = await look_at(name, url, "without script", { script: false });
  if (seen.player) check(bare.stills > 0, `${name}: no still picture without script`);
  console.log(`${name}: ${(size / 1e6).toFixed(2)} MB, ${seen.words} words outside folds, first screen ends at ${Math.round(seen.matrix ? seen.front : seen.answer)} px`);
}

browser.end();
if (!accessible) console.log("left out: what axe-core looks for (npm has not installed it)");
end();

async function look_at(name, url, words, options) {
  const page = await browser.open(url, options);
  const seen = options.script === false ? { stills: 1, ...(await still(page)) } : await page.evaluate(look);
  if (pictures) await page.screenshot(join(pictures, `${name} ${words}.png`), words === "narrow");
  if (words === "dark") for (const fault of (await barriers(page)) || []) check(false, `${name}, ${words}: ${fault}`);
  const faults = await page.close();
  check(faults.length === 0, `${name}, ${words}: ${faults.join("; ")}`);
  return seen;
}

// Even where a page may not run script the browser itself can look at it.
async function still(page) {
  return { stills: await page.evaluate("document.querySelectorAll('.panel svg').length") };
}

// In the page: what can be seen without unfolding anything.
function look() {
  const bottom = (selector) => Math.max(0, ...[...document.querySelectorAll(selector)].map((one) => one.getBoundingClientRect().bottom));
  const folded = (node) => node.parentElement.closest("details:not([open]), script, style, noscript, option, title");
  const walker = document.createTreeWalker(document.documentElement, NodeFilter.SHOW_TEXT);
  let words = 0;
  while (walker.nextNode()) {
    const node = walker.currentNode;
    if (!folded(node) || node.parentElement.closest("summary")) words += node.textContent.split(/\s+/).filter((word) => /[\p{L}\p{N}]/u.test(word)).length;
  }
  return {
    words,
    answer: bottom("p.verdict"),
    front: bottom(".front"),
    matrix: document.querySelector(".matrix") !== null,
    player: document.querySelector("section.player") !== null,
    wide: document.documentElement.scrollWidth,
    links: [...document.querySelectorAll('a[href^="#"]')].map((link) => link.getAttribute("href")),
  };
}

// In the page: whether a link leads to something that is unfolded then.
function leads(link) {
  location.hash = "";
  location.hash = link;
  const part = document.getElementById(link.slice(1));
  return part !== null && (part.closest("details") === null || part.closest("details").open);
}

// The player by keyboard alone: it moves when asked, stops when asked, and says where it is.
async function play(name, page) {
  const time = () => page.evaluate(() => document.querySelector(".player output").textContent);
  const drawn = () => page.evaluate(() => document.querySelector(".player canvas").toDataURL());
  const painted = await page.evaluate(() => [...document.querySelectorAll(".player canvas")].every((canvas) => canvas.width > 100 && canvas.getAttribute("aria-label")));
  check(painted, `${name}: a panel is empty, or has no text`);
  await page.evaluate(() => document.querySelector(".player canvas").focus());
  const [start, picture] = [await time(), await drawn()];
  await page.key("ArrowRight");
  check((await time()) !== start, `${name}: the right arrow does not advance the time`);
  await page.key(" ");
  const rate = await page.evaluate(frames);
  check((await time()) !== start && (await drawn()) !== picture, `${name}: it does not play`);
  await page.key(" ");
  const held = await time();
  await new Promise((resolve) => setTimeout(resolve, 200));
  check((await time()) === held, `${name}: it does not stop`);
  console.log(`${name}: ${rate.toFixed(0)} frames per second`);
}

// In the page: frames per second over one second.
function frames() {
  return new Promise((resolve) => {
    let [count, began] = [0, performance.now()];
    const next = () => {
      count += 1;
      const gone = performance.now() - began;
      if (gone < 1000) requestAnimationFrame(next);
      else resolve((1000 * count) / gone);
    };
    requestAnimationFrame(next);
  });
}
