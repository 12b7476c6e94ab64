/**
 * What the avatar's page costs a machine for each picture that it draws: milliseconds of script,
 * draw calls and triangles, at rest, while a value is dragged, while the body turns.
 *
 *     npm run frames                                  the site of this folder
 *     BASE_URL=http://127.0.0.1:8000 npm run frames   a site that is already running
 *
 * A sixtieth of a second is 16.7 ms. Without a graphics card the drawing itself is reckoned in
 * another process, and how many frames come of it says nothing of a machine that has one; the
 * script's share says what the page adds on any. Stops with 1 where a page at rest draws.
 */

import { cpus, loadavg } from "node:os";

import { chromium } from "@playwright/test";

import { launchOptions } from "../tests/browser/chromium.js";
import { fillIn, serve } from "./served.mjs";

const SIZE = { width: 1280, height: 900 };
const PATIENCE = 120_000; // milliseconds, on a machine that does other things besides
const CHANGES = 60;

const { base, stop } = await serve();
const browser = await chromium.launch(launchOptions());
try {
  const context = await browser.newContext({ viewport: SIZE });
  context.setDefaultTimeout(PATIENCE);
  await context.addCookies(cookies(await fillIn(base)));
  const page = await context.newPage();
  await page.addInitScript(watchTasks);
  await page.goto(`${base}/avatar`);
  await page.mouse.move(8, 8);
  await page.waitForSelector("#viewer[data-learned]", { state: "attached" });
  const opening = await page.evaluate(() => window.tasks);
  await page.waitForTimeout(1500);

  console.log(`Chromium ${browser.version()}, ${SIZE.width} by ${SIZE.height} pixels, without a graphics card;`);
  console.log(`${cpus().length} cores at a load of ${loadavg()[0].toFixed(1)}`);
  console.log(`Tasks over 50 ms until the body stands there and bends: ${opening.length}, the longest ${Math.max(0, ...opening).toFixed(0)} ms`);
  console.log("\n                          frames   script, ms             draw calls  triangles");
  console.log("                                   median  95 %  longest");

  const still = await page.evaluate(rest, 1000);
  console.log(`at rest, in one second  ${String(still).padStart(8)}`);
  tell("a value dragged", await page.evaluate(drag, { name: "waist_girth", changes: CHANGES }));
  await page.waitForTimeout(4000); // the server's body has come, and the one before has gone
  await page.locator('button[data-region="around"]').click();
  await page.waitForTimeout(1500);
  tell("dragged, with six tapes", await page.evaluate(drag, { name: "hip_girth", changes: CHANGES }));
  await page.waitForTimeout(4000);
  await page.locator('button[data-region=""]').click();
  await page.waitForTimeout(1500);
  tell("turning", await page.evaluate(turn));
  process.exitCode = still === 0 ? 0 : 1;
} finally {
  await browser.close();
  stop();
}

function tell(name, frames) {
  const times = frames.map(({ script }) => script).sort((a, b) => a - b);
  const at = (share) => times[Math.min(times.length - 1, Math.floor(share * times.length))].toFixed(1);
  const most = (key) => Math.max(...frames.map((frame) => frame[key]));
  console.log(
    name.padEnd(24) +
      String(frames.length).padStart(8) +
      at(0.5).padStart(9) +
      at(0.95).padStart(6) +
      at(1).padStart(9) +
      String(most("drawCalls")).padStart(12) +
      String(most("triangles")).padStart(11),
  );
}

function cookies(header) {
  return header.split("; ").map((pair) => {
    const end = pair.indexOf("=");
    return { name: pair.slice(0, end), value: pair.slice(end + 1), url: base };
  });
}

// ---- in the page ----

/** Keep how long the tasks take that hold the page up. */
function watchTasks() {
  window.tasks = [];
  new PerformanceObserver((list) => {
    for (const { duration } of list.getEntries()) window.tasks.push(duration);
  }).observe({ type: "longtask", buffered: true });
}

/** The pictures drawn in so many milliseconds without a change. */
async function rest(milliseconds) {
  const { viewer } = document.querySelector("#viewer");
  const before = viewer.stats.frames;
  await new Promise((resolve) => setTimeout(resolve, milliseconds));
  return viewer.stats.frames - before;
}

/** Change a field once a frame, up and down; of each frame, what the change and the drawing took. */
async function drag({ name, changes }) {
  const element = document.querySelector("#viewer");
  const field = document.querySelector(`#edit-${name}`);
  const { stats } = element.viewer;
  const middle = Number(field.value);
  const frames = [];
  for (let i = 0; i < changes; i += 1) {
    const drawn = new Promise((resolve) => {
      element.addEventListener("frame", resolve, { once: true });
    });
    const began = performance.now();
    field.value = (middle + 4 * Math.sin((2 * Math.PI * (i + 1)) / changes)).toFixed(1);
    field.dispatchEvent(new Event("input", { bubbles: true }));
    const change = performance.now() - began;
    await drawn;
    frames.push({ ...stats, script: change + stats.script });
  }
  return frames;
}

/** Turn to the back; of each frame, what the drawing took. */
async function turn() {
  const element = document.querySelector("#viewer");
  const { stats } = element.viewer;
  const frames = [];
  const hear = () => frames.push({ ...stats });
  element.addEventListener("frame", hear);
  const rested = new Promise((resolve) => {
    element.addEventListener("rest", resolve, { once: true });
  });
  document.querySelector('button[data-view="back"]').click();
  await rested;
  element.removeEventListener("frame", hear);
  return frames;
}
