/**
 * Lighthouse's scores of the wizard's pages and of the avatar's, on its slow telephone: the processor
 * four times slower than this one, a slow 4G network. Stops with 1 where a score is below 95.
 *
 *     npm run lighthouse                                  the site of this folder
 *     BASE_URL=http://127.0.0.1:8000 npm run lighthouse   a site that is already running
 *     npm run lighthouse -- --report build/lighthouse     keep the whole reports
 *
 * Times are reckoned by Lighthouse from a load without a brake, so that other work on the machine
 * makes them longer: measure where nothing else runs.
 */

import { spawn } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:net";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";

import * as chromeLauncher from "chrome-launcher";
import lighthouse from "lighthouse";

import { launchOptions } from "../tests/browser/chromium.js";

const CATEGORIES = ["performance", "accessibility", "best-practices"];
const LEAST = 95;
const PAGES = { start: "/", step: "/measure/waist_girth", avatar: "/avatar" };
const PERSON = {
  body: "female",
  units: "metric",
  stature: "168",
  weight: "64",
  bust_girth: "92",
  waist_girth: "74",
  hip_girth: "100",
};

const root = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "..");

/** The deployed server on a free port, and how to stop it. */
async function serve() {
  if (process.env.BASE_URL) return { base: process.env.BASE_URL, stop: () => {} };
  const port = await freePort();
  const command = readFileSync(path.join(root, "Procfile"), "utf8").match(/^web: (.+)$/m)[1];
  const server = spawn("sh", ["-c", `exec ${command}`], {
    cwd: root,
    stdio: ["ignore", "ignore", "inherit"],
    env: {
      ...process.env,
      PATH: [path.join(root, ".venv/bin"), process.env.PATH].join(path.delimiter),
      HOST: "127.0.0.1",
      PORT: String(port),
      FITTING_ROOM_LOCAL: "1",
      SECRET_KEY: "only-for-lighthouse",
      GUNICORN_CMD_ARGS: "--log-level warning",
    },
  });
  const base = `http://127.0.0.1:${port}`;
  for (let tries = 0; ; tries += 1) {
    const answer = await fetch(`${base}/healthz`).catch(() => null);
    if (answer?.ok) break;
    if (tries > 240) throw new Error("The site does not start.");
    await new Promise((resolve) => setTimeout(resolve, 500));
  }
  return { base, stop: () => server.kill("SIGTERM") };
}

function freePort() {
  return new Promise((resolve) => {
    const probe = createServer().listen(0, "127.0.0.1", () => {
      const { port } = probe.address();
      probe.close(() => resolve(port));
    });
  });
}

/** The cookie of a shopper who has filled in the form. */
async function fillIn(base) {
  const jar = new Map();
  const take = (response) => {
    for (const line of response.headers.getSetCookie()) {
      const [pair] = line.split(";");
      jar.set(pair.slice(0, pair.indexOf("=")), pair);
    }
    return response;
  };
  const cookie = () => [...jar.values()].join("; ");
  const page = await take(await fetch(`${base}/numbers`)).text();
  const token = page.match(/name="csrf_token" value="([^"]+)"/)[1];
  const body = new URLSearchParams({ csrf_token: token, ...PERSON });
  const headers = { Cookie: cookie(), Referer: `${base}/` };
  take(await fetch(`${base}/numbers`, { method: "POST", body, headers, redirect: "manual" }));
  const avatar = await fetch(`${base}/avatar`, { headers: { Cookie: cookie() }, redirect: "manual" });
  if (avatar.status !== 200) throw new Error(`The avatar's page: status ${avatar.status}.`);
  return cookie();
}

async function measure(url, cookie, port) {
  const { lhr, report } = await lighthouse(url, {
    port,
    output: "html",
    logLevel: "error",
    onlyCategories: CATEGORIES,
    extraHeaders: cookie ? { Cookie: cookie } : undefined,
  });
  return { lhr, report };
}

function tell(name, { audits, categories }) {
  const scores = CATEGORIES.map((id) => Math.round(100 * categories[id].score));
  console.log(`\n${name}`);
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
  for (const id of CATEGORIES) {
    for (const { id: audit, weight } of categories[id].auditRefs) {
      const { score, title } = audits[audit];
      if (weight > 0 && score !== null && score < 0.9) console.log(`    ${id}: ${title}`);
    }
  }
  return scores.every((score) => score >= LEAST);
}

const { values } = parseArgs({ options: { report: { type: "string" } } });
const { base, stop } = await serve();
const { executablePath, args } = launchOptions();
const chrome = await chromeLauncher.launch({
  chromePath: executablePath,
  chromeFlags: [...args, "--headless=new"],
});
let good = true;
try {
  const cookie = await fillIn(base);
  for (const [name, address] of Object.entries(PAGES)) {
    const { lhr, report } = await measure(`${base}${address}`, cookie, chrome.port);
    good = tell(`${name}, ${address}`, lhr) && good;
    if (values.report) writeFileSync(`${values.report}-${name}.html`, report);
  }
} finally {
  chrome.kill();
  stop();
}
process.exitCode = good ? 0 : 1;
