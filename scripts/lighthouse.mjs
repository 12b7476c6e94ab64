/**
 * Lighthouse's scores of the wizard's pages and of the avatar's, on its slow telephone: the processor
 * four times slower than this one, a slow 4G network. Of five runs of each page the middle one is
 * told, as Lighthouse advises where runs vary. Stops with 1 where a score is below 95, or where a
 * page can be used only after two seconds.
 *
 *     npm run lighthouse                                  the site of this folder
 *     BASE_URL=http://127.0.0.1:8000 npm run lighthouse   a site that is already running
 *     npm run lighthouse -- --page avatar                 one page only
 *     npm run lighthouse -- --report build/lighthouse     keep the whole reports
 *
 * Times are reckoned by Lighthouse from a load without a brake, four times as long as they passed:
 * other work on the machine counts fourfold. So each run waits until the machine rests, within the
 * first two minutes of a page. Before a page is loaded Lighthouse also counts what the machine can do,
 * its benchmark index: a run that found much less than the best one was disturbed, and another is made
 * for it. All runs are told, also those.
 *
 * What a page does at the reader's first touch or after a rest is not seen here: frames.mjs tells
 * what the view in 3D costs.
 */

import { writeFileSync } from "node:fs";
import { cpus, loadavg } from "node:os";
import { parseArgs } from "node:util";

import * as chromeLauncher from "chrome-launcher";
import lighthouse from "lighthouse";

import { launchOptions } from "../tests/browser/chromium.js";
import { fillIn, serve } from "./served.mjs";

const CATEGORIES = ["performance", "accessibility", "best-practices"];
const LEAST = 95;
const INTERACTIVE = 2000; // milliseconds at most
const RUNS = 5;
const SPARE = 5; // runs more, for disturbed ones
const DISTURBED = 0.75; // of the best benchmark index, below which a run was
const RESTING = 0.15; // the share of the processors that may be busy before a run
const PATIENCE = 120; // seconds of a page's measuring in which that is waited for
const PAGES = {
  start: "/",
  step: "/measure/waist_girth",
  form: "/numbers",
  review: "/review",
  avatar: "/avatar",
};

/** The runs of a page, and those of them that count, the worst first: those that nothing disturbed. */
async function measure(url, cookie) {
  const runs = [];
  const until = Date.now() + 1000 * PATIENCE;
  const steady = () => runs.filter((run) => power(run) >= DISTURBED * best);
  for (let tries = 0; steady().length < RUNS && tries < RUNS + SPARE; tries += 1) {
    const busy = await rest(until);
    const run = await once(url, cookie);
    if (run.lhr.runtimeError) {
      console.log(`\n${url}: ${run.lhr.runtimeError.code}`); // now and then a trace lacks its beginning
      continue;
    }
    runs.push({ ...run, busy });
    best = Math.max(best, power(run));
  }
  if (runs.length < RUNS) throw new Error(`${url}: only ${runs.length} runs came to an end`);
  const counted = steady().length < RUNS ? [...runs] : steady();
  return { runs, counted: counted.sort((one, other) => performance(one) - performance(other)) };
}

let best = 0; // benchmark index of all runs so far
const performance = ({ lhr }) => Math.round(100 * lhr.categories.performance.score);
const power = ({ lhr }) => lhr.environment.benchmarkIndex;

/** Wait until the machine rests, or until a time; the share of its processors that is busy then. */
async function rest(until) {
  for (;;) {
    const before = spent();
    await new Promise((resolve) => setTimeout(resolve, 1000));
    const after = spent();
    const busy = 1 - (after.idle - before.idle) / (after.all - before.all);
    if (busy <= RESTING || Date.now() > until) return busy;
  }
}

/** Milliseconds of the machine's processors so far. */
function spent() {
  const times = cpus().map(({ times }) => times);
  const sum = (values) => values.reduce((total, value) => total + value, 0);
  return { idle: sum(times.map(({ idle }) => idle)), all: sum(times.flatMap(Object.values)) };
}

/** One load in a browser that has just started and shown another page, as a telephone's has. */
async function once(url, cookie) {
  const { executablePath, args } = launchOptions();
  const chrome = await chromeLauncher.launch({
    chromePath: executablePath,
    chromeFlags: [...args, "--headless=new"],
  });
  try {
    const tabs = `http://127.0.0.1:${chrome.port}/json`;
    const warm = new URL("/", url);
    warm.hostname = "localhost"; // another host's cookies, which are in nobody's way
    const { id } = await (await fetch(`${tabs}/new?${warm}`, { method: "PUT" })).json();
    await new Promise((resolve) => setTimeout(resolve, 2000));
    await fetch(`${tabs}/close/${id}`);
    const run = await lighthouse(url, {
      port: chrome.port,
      output: "html",
      logLevel: "silent",
      onlyCategories: CATEGORIES,
      extraHeaders: cookie ? { Cookie: cookie } : undefined,
    });
    const { finalDisplayedUrl: shown, runtimeError } = run.lhr;
    if (!runtimeError && shown !== url) throw new Error(`${url} led to ${shown}`);
    return run;
  } finally {
    chrome.kill();
  }
}

function tell(name, { runs, counted }) {
  const { audits, categories } = counted[Math.floor(counted.length / 2)].lhr;
  const scores = CATEGORIES.map((id) => Math.round(100 * categories[id].score));
  console.log(`\n${name}, at a load of ${loadavg()[0].toFixed(1)}`);
  for (const run of runs) {
    const [index, busy] = [power(run).toFixed(0), (100 * run.busy).toFixed(0)];
    const note = counted.includes(run) ? "" : ", disturbed";
    console.log(`  a run: ${performance(run)}, benchmark index ${index}, ${busy} % busy before${note}`);
  }
  if (counted.some((run) => power(run) < DISTURBED * best)) console.log("  too many disturbed: all count");
  CATEGORIES.forEach((id, i) => console.log(`  ${id.padEnd(34)} ${scores[i]}`));
  for (const id of [
    "first-contentful-paint",
    "largest-contentful-paint",
    "total-blocking-time",
    "cumulative-layout-shift",
    "speed-index",
    "interactive",
  ]) {
    console.log(`  ${audits[id].title.padEnd(34)} ${audits[id].displayValue}`);
  }
  const items = audits["network-requests"].details.items;
  const besides = items.filter(({ url }) => !/\.glb|\.png|\.webp/.test(url));
  const kilobytes = (list) => (list.reduce((sum, { transferSize }) => sum + transferSize, 0) / 1000).toFixed(0);
  console.log(`  ${"Transferred".padEnd(34)} ${kilobytes(items)} kB, of that besides the avatar and its pictures ${kilobytes(besides)} kB`);
  for (const { url, startTime, duration } of audits["long-tasks"]?.details?.items ?? []) {
    console.log(`    ${duration.toFixed(0)} ms from ${startTime.toFixed(0)} ms: ${url}`);
  }
  for (const id of CATEGORIES) {
    for (const { id: audit, weight } of categories[id].auditRefs) {
      const { score, title } = audits[audit];
      if (weight > 0 && score !== null && score < 0.9) console.log(`    ${id}: ${title}`);
    }
  }
  return scores.every((score) => score >= LEAST) && audits.interactive.numericValue <= INTERACTIVE;
}

const { values } = parseArgs({
  options: {
    report: { type: "string" },
    page: { type: "string", multiple: true, default: Object.keys(PAGES) },
  },
});
const { base, stop } = await serve();
let good = true;
try {
  const cookie = await fillIn(base);
  for (const name of values.page) {
    const address = PAGES[name];
    const measured = await measure(`${base}${address}`, cookie);
    good = tell(`${name}, ${address}`, measured) && good;
    const { report } = measured.counted[Math.floor(measured.counted.length / 2)];
    if (values.report) writeFileSync(`${values.report}-${name}.html`, report);
  }
} finally {
  stop();
}
process.exitCode = good ? 0 : 1;
