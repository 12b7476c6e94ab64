/** From the first page to the file at home: by keyboard alone, and without scripts. */

import { readFileSync } from "node:fs";

import { validateBytes } from "gltf-validator";

import {
  WOMAN,
  drawn,
  enter,
  expect,
  look,
  openAvatar,
  pixels,
  ready,
  tabTo,
  test,
} from "./site.js";

const SUBMIT = "main form button.button[type=submit]";
const DOWNLOAD = 'a[download="avatar.glb"]';

/** The lowest and highest point of a GLB file's body, in metres. */
function upright(glb) {
  const document = JSON.parse(glb.subarray(20, 20 + glb.readUInt32LE(12)).toString());
  const { POSITION } = document.meshes[0].primitives[0].attributes;
  const { min, max } = document.accessors[POSITION];
  return { document, low: min[1], high: max[1] };
}

/** What the page's table says of a measurement: the numbers in its row, in their order. */
async function row(page, measurement) {
  const cells = page.locator(`tr[data-measurement="${measurement}"] td`);
  return (await cells.allTextContents()).map((text) => text.trim());
}

async function checkFile(page, file) {
  const glb = readFileSync(file);
  const { issues } = await validateBytes(new Uint8Array(glb));
  expect(issues.messages.filter(({ severity }) => severity < 2)).toEqual([]);
  const { document, low, high } = upright(glb);
  expect(low).toBeCloseTo(0, 6);
  const [, taken] = await row(page, "stature");
  expect((100 * (high - low)).toFixed(1)).toBe(taken);
  expect(document.asset.extras.measurements.stature.taken).toBeCloseTo(high - low, 4);
}

for (const width of [360, 1280]) {
  test(`from the form to the file by keyboard alone, ${width} pixels wide`, async ({ page }) => {
    await page.setViewportSize({ width, height: 800 });
    await page.goto("/numbers");
    const { body, ...values } = WOMAN;
    await tabTo(page, 'input[name="body"]');
    await page.keyboard.press("Space");
    const chosen = page.locator('input[name="body"]:checked');
    for (let i = 0; i < 3 && (await chosen.inputValue()) !== body; i += 1) {
      await page.keyboard.press("ArrowDown");
    }
    expect(await chosen.inputValue()).toBe(body);
    for (const [name, value] of Object.entries(values)) {
      await tabTo(page, `input[name="${name}"]`);
      await page.keyboard.type(value);
    }
    await tabTo(page, SUBMIT);
    await page.keyboard.press("Enter");
    await expect(page).toHaveURL(/\/avatar$/);
    await ready(page);

    await tabTo(page, DOWNLOAD);
    const download = page.waitForEvent("download");
    await page.keyboard.press("Enter");
    const file = await download;
    expect(file.suggestedFilename()).toMatch(/\.glb$/);
    await checkFile(page, await file.path());

    expect(drawn(await look(page))).toBeGreaterThan(0.08);
    for (const control of ["#viewer canvas", '[data-view="side"]']) await tabTo(page, control);
    // Nothing sticks out sideways: one scrolls a page downwards only.
    const overflow = () => document.documentElement.scrollWidth - window.innerWidth;
    expect(await page.evaluate(overflow)).toBeLessThanOrEqual(0);
  });
}

test("the table shows what was entered and what the body measures", async ({ page }) => {
  await openAvatar(page);
  const [asked, taken] = await row(page, "stature");
  expect(asked).toBe("168.0");
  expect(Number(taken)).toBeCloseTo(168, 0);
});

test("measurements are in no address", async ({ page }) => {
  const addresses = [];
  page.on("request", (request) => addresses.push(request.url()));
  await openAvatar(page);
  for (const address of addresses) expect(address).not.toMatch(/168|stature|girth/);
});

test.describe("without scripts", () => {
  test.use({ javaScriptEnabled: false });

  test("the form, the pictures and the file are there", async ({ page, browser }) => {
    const pictures = [];
    page.on("response", (response) => {
      if (response.url().endsWith(".webp")) pictures.push(response);
    });
    await enter(page);
    await expect(page).toHaveURL(/\/avatar$/);
    const images = page.locator("figure img");
    await expect(images).toHaveCount(2);
    for (const image of await images.all()) {
      await expect(image).toBeVisible();
      await image.scrollIntoViewIfNeeded();
    }
    await page.waitForLoadState("networkidle");
    expect(pictures.length).toBeGreaterThanOrEqual(2);
    for (const picture of pictures) {
      expect(picture.status()).toBe(200);
      expect(picture.headers()["content-type"]).toBe("image/webp");
    }
    const other = await browser.newPage();
    for (const image of await images.all()) {
      expect(drawn(await pixels(other, await image.screenshot()))).toBeGreaterThan(0.08);
    }
    await other.close();

    const download = page.waitForEvent("download");
    await page.locator(DOWNLOAD).click();
    await checkFile(page, await (await download).path());
  });

  test("a mistake is pointed out and nothing typed is lost", async ({ page, complaints }) => {
    await enter(page, { ...WOMAN, waist_girth: "seventy" });
    await expect(page.locator("[aria-invalid=true]")).toHaveValue("seventy");
    await expect(page.locator('input[name="hip_girth"]')).toHaveValue("100");
    complaints.expect(/status of 422/); // the answer's own
  });
});
