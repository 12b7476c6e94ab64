/**
 * What the avatar's page costs a machine for each picture that it draws: milliseconds of script,
 * draw calls and triangles, at rest, while a value is dragged, while the body turns.
 *
 *     npm run frames                                  the site of this folder
 *     BASE_URL=http://127.0.0.1:8000 npm run frames   a site that is already running
 *
 * A sixtieth of a second is 16.7 ms. Without a graphics card the drawing itself is reckoned in
 * another process, and how many frames come of it says nothing of a machine that has one; the
 * script's share says what the page adds on any. Beside the time that passes stands the processor's
 * own, of all that the page's thread does: other work on the machine makes only the first longer.
 * Stops with 1 where a page at rest draws.
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
  const devtools = await context.newCDPSession(page);
  await devtools.send("Performance.enable", { timeDomain: "threadTicks" });
  /** Milliseconds of the processor that the page's thread has taken so far. */
  const spent = async () => {
    const { metrics } = await devtools.send("Performance.getMetrics");
    return 1000 * metrics.find(({ name }) => name === "TaskDuration").value;
  };
  const costing = async (work, given) => {
    const before = await spent();
    const frames = await page.evaluate(work, given);
    return { frames, each: ((await spent()) - before) / frames.length };
  };
  await page.goto(`${base}/avatar`, { waitUntil: "load" });
  const [read, started] = [await spent(), await page.locator("#viewer canvas").count()];
  await page.mouse.move(8, 8);
  await page.waitForSelector("#viewer[data-learned]", { state: "attached" });
  await page.waitForTimeout(1500);
  const open = await spent();

  console.log(`Chromium ${browser.version()}, ${SIZE.width} by ${SIZE.height} pixels, without a graphics card;`);
  console.log(`${cpus().length} cores at a load of ${loadavg()[0].toFixed(1)}`);
  if (!started) console.log(`Until the page is read and edited: ${read.toFixed(0)} ms of the processor`);
  console.log(`Until the body stands there in 3D and bends, besides: ${(open - read).toFixed(0)} ms`);
  console.log("\n                          frames   script, ms       processor,  draw calls  triangles");
  console.log("                                   median    95 %      ms each");

  const still = await page.evaluate(rest, 1000);
  console.log(`at rest, in one second  ${String(still).padStart(8)}`);
  tell("a value dragged", await costing(drag, { name: "waist_girth", changes: CHANGES }));
  await page.waitForTimeout(4000); // the server's body has come, and the one before has gone
  await page.locator('button[data-region="around"]').click();
  await page.waitForTimeout(1500);
  tell("dragged, with six tapes", await costing(drag, { name: "hip_girth", changes: CHANGES }));
  await page.waitForTimeout(4000);
  await page.locator('button[data-region=""]').click();
  await page.waitForTimeout(1500);
  tell("turning", await costing(turn));
  process.exitCode = still === 0 ? 0 : 1;
} finally {
  await browser.close();
  stop();
}

function tell(name, { frames, each }) {
  const times = frames.map(({ script }) => script).sort((a, b) => a - b);
  const at = (share) => times[Math.min(times.length - 1, Math.floor(share * times.length))].toFixed(1);
  const most = (key) => Math.max(...frames.map((frame) => frame[key]));
  console.log(
    name.padEnd(24) +
      String(frames.length).padStart(8) +
      at(0.5).padStart(9) +
      at(0.95).padStart(8) +
      each.toFixed(1).padStart(13) +
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
  const hear = () => queueMicrotask(() => frames.push({ ...stats })); // they count this event too
  element.addEventListener("frame", hear);
  const rested = new Promise((resolve) => {
    element.addEventListener("rest", resolve, { once: true });
  });
  document.querySelector('button[data-view="back"]').click();
  await rested;
  element.removeEventListener("frame", hear);
  return frames;
}
