/**
 * The picture of the avatar's page in the README, from a site that is running.
 *
 *     node scripts/screenshot.mjs http://127.0.0.1:8000 docs/images/avatar.png
 */

import { chromium } from "@playwright/test";

import { launchOptions } from "../tests/browser/chromium.js";

const PERSON = {
  stature: "168",
  bust_girth: "92",
  waist_girth: "74",
  hip_girth: "100",
  thigh_girth: "58",
};

const [site, file] = process.argv.slice(2);
const browser = await chromium.launch(launchOptions());
const page = await browser.newPage({ locale: "en-GB", viewport: { width: 1280, height: 1110 }, reducedMotion: "reduce" });
page.setDefaultTimeout(180_000);
await page.goto(new URL("/numbers", site).href);
await page.check('input[name="body"][value="female"]');
for (const [name, value] of Object.entries(PERSON)) await page.fill(`input[name="${name}"]`, value);
await page.click("main form button.button[type=submit]");
await page.mouse.move(8, 8);
await page.waitForSelector('#viewer[data-state="ready"]');
await page.waitForLoadState("networkidle");
await page.focus("#edit-waist_girth"); // its tape, on the whole body
await page.mouse.move(8, 300);
await page.waitForTimeout(1000);
await page.screenshot({ path: file });
await browser.close();
