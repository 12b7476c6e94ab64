/**
 * What axe finds wrong on any page that a person may come to, at 360 pixels, in both languages, in
 * the light and in the dark: the start, all 41 steps, what is said of numbers there, the lists, the
 * form, the body, its sheet, a comparison, and errors. Prints each and stops with 1 where there is one.
 *
 *     npm run axe                                  the site of this folder
 *     BASE_URL=http://127.0.0.1:8000 npm run axe   a site that is already running
 */

import { readFileSync } from "node:fs";

import { chromium } from "@playwright/test";

import { axe } from "../tests/browser/axe.js";
import { launchOptions } from "../tests/browser/chromium.js";
import { METRIC, NEXT, begin, walk } from "../tests/browser/wizard.js";
import { serve } from "./served.mjs";

const TABLE = readFileSync(new URL("../model/data/measurements.csv", import.meta.url), "utf8");
const STEPS = [...TABLE.matchAll(/^([a-z_]+),[^,]+,(?:height|mass|girth|length),/gm)].map(([, name]) => name);
if (STEPS.length !== 41) throw new Error(`${STEPS.length} measurements in the table`);

const { base, stop } = await serve();
const browser = await chromium.launch(launchOptions());
let pages = 0;
let found = 0;

async function see(page, name) {
  const wrong = await axe(page);
  pages += 1;
  found += wrong.length;
  for (const line of wrong) console.log(`${name}: ${line}`);
}

/** One person's way, in one language and one scheme. */
async function look(locale, colorScheme) {
  const viewport = { width: 360, height: 740 };
  const reducedMotion = "reduce"; // nothing is judged half-way
  const page = await browser.newPage({ baseURL: base, locale, colorScheme, viewport, reducedMotion });
  page.setDefaultTimeout(180_000); // the machine may be busy
  const tell = (name) => see(page, `${locale}, ${colorScheme}, ${name}`);
  const visit = async (path) => {
    await page.goto(path);
    await tell(path);
  };
  await page.goto("/");
  await page.click(NEXT);
  await page.waitForSelector("#summary");
  await tell("the start with a message");
  await begin(page, "metric", () => tell("/"));
  await walk(page, METRIC);
  await tell("/review");
  for (const name of STEPS) await visit(`/measure/${name}`);

  await page.goto("/measure/waist_girth");
  await page.fill("#waist_girth", "97");
  await page.waitForSelector(".question button[name=keep]");
  await tell("a question");
  await page.fill("#waist_girth", "29");
  await page.click(NEXT);
  await page.waitForSelector("#summary");
  await tell("a message and what was meant");
  await page.fill("#waist_girth", "74");
  await page.click("details.again summary");
  await page.fill("#waist_girth-2", "78");
  await page.click(NEXT);
  await page.waitForSelector("#third");
  await tell("a third reading");
  await page.click("button[name=enough]");
  await visit("/measure");
  await visit("/review");
  await visit("/numbers");
  await page.fill("#stature", "1.68");
  await page.click(NEXT);
  await page.waitForSelector("#summary");
  await tell("the form with a message");
  await page.fill("#stature", "168");
  await page.click(NEXT);
  await page.waitForURL("**/avatar");
  await page.mouse.move(8, 300);
  await page.waitForSelector('#viewer[data-state="ready"]');
  await tell("/avatar");
  await visit("/avatar/sheet");
  await visit("/compare");
  const shape = { body: "female", measurements: { stature: 168, waist_girth: 82 }, silhouette: true };
  const outline = await page.request.post("/api/v1/avatars/front.png", { data: shape });
  const file = { name: "outline.png", mimeType: "image/png", buffer: await outline.body() };
  await page.setInputFiles("#front-outline", file);
  await page.click("#comparison button.button[type=submit]");
  await page.waitForSelector("tr[data-measurement=waist_girth]");
  await tell("a comparison");
  await visit("/no-such-page");
  await page.close();
  console.log(`${locale}, ${colorScheme}: ${pages} pages by now, ${found} findings`);
}

try {
  for (const locale of ["en-GB", "pt-PT"]) {
    for (const colorScheme of ["light", "dark"]) await look(locale, colorScheme);
  }
} finally {
  await browser.close();
  stop();
}
process.exitCode = found ? 1 : 0;
