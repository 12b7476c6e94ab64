/**
 * The pictures of docs/wizard.md: every step as a shopper sees it, from a site that is running.
 *
 *     node scripts/wizard_pictures.mjs http://127.0.0.1:8000 docs/images/wizard
 */

import { writeFileSync } from "node:fs";

import { chromium } from "@playwright/test";

import { launchOptions } from "../tests/browser/chromium.js";
import { METRIC, NEXT, begin, walk } from "../tests/browser/wizard.js";

const [site, folder] = process.argv.slice(2);
const browser = await chromium.launch(launchOptions());
const QUALITY = 0.6;

/** A picture as WebP, which the browser itself writes. */
async function asWebp(png) {
  const page = await browser.newPage();
  const base64 = await page.evaluate(
    async ([png, quality]) => {
      const picture = await createImageBitmap(await (await fetch(`data:image/png;base64,${png}`)).blob());
      const canvas = new OffscreenCanvas(picture.width, picture.height);
      canvas.getContext("2d").drawImage(picture, 0, 0);
      const file = new FileReader();
      file.readAsDataURL(await canvas.convertToBlob({ type: "image/webp", quality }));
      await new Promise((resolve) => file.addEventListener("load", resolve));
      return file.result.split(",")[1];
    },
    [png.toString("base64"), QUALITY],
  );
  await page.close();
  return Buffer.from(base64, "base64");
}

async function open(locale, width, colorScheme) {
  const viewport = { width, height: 740 };
  const page = await browser.newPage({ baseURL: site, locale, colorScheme, viewport });
  page.setDefaultTimeout(180_000); // the machine may be busy
  const picture = async (name) =>
    writeFileSync(`${folder}/${name}.webp`, await asWebp(await page.screenshot({ fullPage: true })));
  return { page, picture };
}

/** Every step, as on a telephone. */
const phone = await open("en-GB", 360, "light");
await begin(phone.page, "metric", () => phone.picture("0_start"));
let number = 0;
await walk(phone.page, METRIC, async (name) => {
  await phone.page.waitForTimeout(1500);
  number += 1;
  await phone.picture(`${number}_${name}`);
});
await phone.picture("10_review");
await phone.page.goto("/measure");
await phone.picture("11_more");
await phone.page.goto("/numbers");
await phone.picture("12_numbers");
await phone.page.goto("/measure/waist_girth");
for (const [typed, name] of [
  ["29", "13_unit"],
  ["97", "14_question"],
]) {
  await phone.page.fill("#waist_girth", typed);
  await phone.page.waitForTimeout(1500);
  await phone.picture(name);
}
await phone.page.goto("/measure/hip_girth");
await phone.page.click("details.again summary");
await phone.page.fill("#hip_girth-2", "102");
await phone.page.click(NEXT);
await phone.page.waitForSelector("#third");
await phone.picture("15_third");

/** What men are asked besides. */
const other = await open("en-GB", 360, "light");
await other.page.goto("/");
await other.page.check("#body-male");
await other.page.click(NEXT);
await other.page.waitForURL("**/measure/stature");
await other.page.goto("/measure/neck_girth");
await other.picture("18_neck_girth");

/** In Portuguese, on a desktop in the dark, with the body in 3D. */
const desk = await open("pt-PT", 1280, "dark");
await begin(desk.page, "metric", () => desk.picture("16_portuguese_start"));
await desk.page.fill("#stature", "168");
await desk.page.click(NEXT);
await desk.page.goto("/measure/waist_girth");
await desk.page.fill("#waist_girth", "74");
await desk.page.click("#preview button");
await desk.page.waitForSelector('#viewer[data-state="ready"]');
await desk.page.waitForTimeout(3000);
await desk.picture("17_portuguese_waist");
await browser.close();
