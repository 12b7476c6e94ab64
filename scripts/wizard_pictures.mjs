/**
 * The pictures of docs/wizard.md: every step as a shopper sees it, from a site that is running.
 *
 *     node scripts/wizard_pictures.mjs http://127.0.0.1:8000 docs/images/wizard
 */

import { chromium } from "@playwright/test";

import { launchOptions } from "../tests/browser/chromium.js";

const PERSON = {
  stature: "168",
  weight: "62,5",
  bust_girth: "92",
  waist_girth: "74",
  abdomen_girth: "82",
  hip_girth: "99",
  thigh_girth: "58",
  mid_thigh_girth: "47",
  inseam_height: "78",
};
const NEXT = "main .finish button.button";

const [site, folder] = process.argv.slice(2);
const browser = await chromium.launch(launchOptions());

async function open(locale, width, colorScheme) {
  const page = await browser.newPage({ locale, colorScheme, viewport: { width, height: 740 } });
  const picture = (name) =>
    page.screenshot({ path: `${folder}/${name}.jpg`, type: "jpeg", quality: 62, fullPage: true });
  const visit = (path) => page.goto(new URL(path, site).href);
  return { page, picture, visit };
}

async function begin({ page, visit }, picture = async () => {}) {
  await visit("/");
  await picture();
  await page.check("#body-female");
  await page.click(NEXT);
}

/** Every step, as on a telephone. */
const phone = await open("en-GB", 360, "light");
await begin(phone, () => phone.picture("0_start"));
let number = 1;
for (const [name, value] of Object.entries(PERSON)) {
  await phone.page.waitForURL(`**/measure/${name}`);
  if (name === "inseam_height") await phone.page.check("#to-floor");
  await phone.page.fill(`#${name}`, value);
  await phone.page.waitForTimeout(1500);
  await phone.picture(`${number}_${name}`);
  await phone.page.click(NEXT);
  number += 1;
}
await phone.page.waitForURL("**/review");
await phone.picture("10_review");
await phone.visit("/measure");
await phone.picture("11_more");
await phone.visit("/numbers");
await phone.picture("12_numbers");
await phone.visit("/measure/waist_girth");
for (const [typed, name] of [
  ["29", "13_unit"],
  ["97", "14_question"],
]) {
  await phone.page.fill("#waist_girth", typed);
  await phone.page.waitForTimeout(1500);
  await phone.picture(name);
}
await phone.visit("/measure/hip_girth");
await phone.page.click("details.again summary");
await phone.page.fill("#hip_girth-2", "102");
await phone.page.click(NEXT);
await phone.page.waitForSelector("#third");
await phone.picture("15_third");

/** In Portuguese, on a desktop in the dark, with the body in 3D. */
const desk = await open("pt-PT", 1280, "dark");
await begin(desk, () => desk.picture("16_portuguese_start"));
await desk.page.fill("#stature", "168");
await desk.page.click(NEXT);
await desk.visit("/measure/waist_girth");
await desk.page.fill("#waist_girth", "74");
await desk.page.click("#preview button");
await desk.page.waitForSelector('#viewer[data-state="ready"]');
await desk.page.waitForTimeout(3000);
await desk.picture("17_portuguese_waist");
await browser.close();
