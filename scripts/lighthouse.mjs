/**
 * Lighthouse's scores of the wizard's pages and of the avatar's, on its slow telephone: the processor
 * four times slower than this one, a slow 4G network. Of three runs of each page the middle one is
 * told. Stops with 1 where a score is below 95.
 *
 *     npm run lighthouse                                  the site of this folder
 *     BASE_URL=http://127.0.0.1:8000 npm run lighthouse   a site that is already running
 *     npm run lighthouse -- --page avatar                 one page only
 *     npm run lighthouse -- --report build/lighthouse     keep the whole reports
 *
 * Times are reckoned by Lighthouse from a load without a brake, so that other work on the machine
 * makes them longer: measure where nothing else runs. The machine's load is printed beside them.
 * What a page does at the reader's first touch or after a rest is not seen here: frames.mjs tells
 * what the view in 3D costs.
 */

import { writeFileSync } from "node:fs";
import { loadavg } from "node:os";
import { parseArgs } from "node:util";

import * as chromeLauncher from "chrome-launcher";
import lighthouse from "lighthouse";

import { launchOptions } from "../tests/browser/chromium.js";
import { fillIn, serve } from "./served.mjs";

const CATEGORIES = ["performance", "accessibility", "best-practices"];
const LEAST = 95;
const RUNS = 3;
const SPARE = 4; // a browser now and then loses the beginning of what it records
const PAGES = {
  start: "/",
  step: "/measure/waist_girth",
  form: "/numbers",
  review: "/review",
  avatar: "/avatar",
};

/** The middle one of some runs by its performance, and how all of them did. */
async function measure(url, cookie) {
  const runs = [];
  for (let left = RUNS + SPARE; runs.length < RUNS; left -= 1) {
    const run = await once(url, cookie);
    if (!run.lhr.runtimeError) runs.push(run);
    else if (left > RUNS - runs.length) console.log(`\n${url}: ${run.lhr.runtimeError.code}, again`);
    else throw new Error(run.lhr.runtimeError.message);
  }
  const performance = ({ lhr }) => lhr.categories.performance.score;
  runs.sort((one, other) => performance(one) - performance(other));
  const all = runs.map((run) => Math.round(100 * performance(run)));
  return { ...runs[Math.floor(RUNS / 2)], all };
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
    await new Promise((resolve) => setTimeout(resolve, 3000));
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

function tell(name, { audits, categories }, all) {
  const scores = CATEGORIES.map((id) => Math.round(100 * categories[id].score));
  console.log(`\n${name}, at a load of ${loadavg()[0].toFixed(1)}`);
  CATEGORIES.forEach((id, i) => console.log(`  ${id.padEnd(34)} ${scores[i]}`));
  console.log(`  ${"performance of all runs".padEnd(34)} ${all.join(", ")}`);
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
  return scores.every((score) => score >= LEAST);
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
    const { lhr, report, all } = await measure(`${base}${address}`, cookie);
    good = tell(`${name}, ${address}`, lhr, all) && good;
    if (values.report) writeFileSync(`${values.report}-${name}.html`, report);
  }
} finally {
  stop();
}
process.exitCode = good ? 0 : 1;
