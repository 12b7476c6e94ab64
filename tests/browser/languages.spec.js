/** What pages say once they live: in Portuguese, and beside the body in feet and inches. */

import { enter, expect, ready, test } from "./site.js";

/** Words that English texts hardly do without, and Portuguese ones never have. */
const ENGLISH = /\b(the|of|and|your|you|with|is|are|this|to|not|on|by|from|here|body|entered)\b/gi;

/** All that is seen or read out, now. */
const said = (page) =>
  page.evaluate(() => {
    const spoken = [...document.querySelectorAll("*")].flatMap((element) =>
      ["aria-label", "aria-valuetext", "title", "alt"].map((name) => element.getAttribute(name) ?? ""),
    );
    return [document.title, document.body.innerText, ...spoken]
      .join(" | ")
      .replaceAll("The Fitting Room", "");
  });

const changed = (page, name, value) =>
  Promise.all([
    page.waitForResponse((answer) => answer.request().method() === "POST" && answer.ok()),
    page.locator(`#edit-${name}`).fill(value),
  ]);

test.describe("in Portuguese", () => {
  test.use({ locale: "pt-PT", viewport: { width: 700, height: 560 } });

  test("the mirror says all it says in Portuguese, with decimal commas", async ({ page }) => {
    await enter(page);
    await ready(page);
    await expect(page.locator(".viewer-status")).toHaveText(/O seu corpo está aqui em 3D/);
    await page.locator('button[data-region="around"]').click();
    await page.locator('[data-switch="ruler"]').click();
    await expect(page.locator(".tape-label")).not.toHaveCount(0);
    await changed(page, "waist_girth", "95,5");
    await expect(page.locator("#edit-waist_girth-note")).toContainText("parece invulgar");
    expect((await said(page)).match(ENGLISH)).toBeNull();
    await expect(page.locator('tr[data-measurement="waist_girth"] td').first()).toHaveText("95,5");
    const numbers = page.locator("tr[data-measurement] td, .tape-value, .tape-note, .ruler text");
    expect((await numbers.allTextContents()).filter((text) => /\d\.\d/.test(text))).toEqual([]);
  });

  test("so does the page of photos", async ({ page }) => {
    await enter(page);
    await page.goto("/compare");
    await page.locator("#comparison button.button[type=submit]").click();
    await expect(page.locator(".form-status")).toHaveText(/Primeiro escolha ou tire uma fotografia/);
    expect((await said(page)).match(ENGLISH)).toBeNull();
    const words = await page.evaluate(() => document.getElementById("words").textContent);
    expect(words.match(ENGLISH)).toBeNull();
  });
});

test("a height in feet and inches is changed as it is typed elsewhere", async ({ page }) => {
  await page.setViewportSize({ width: 700, height: 560 });
  await page.goto("/numbers");
  await page.locator("button[value=imperial]").click();
  await expect(page.locator("#stature-unit")).toHaveText("ft, in");
  await page.locator('input[name="body"][value="female"]').check();
  await page.locator("#stature").fill("5 ft 6");
  await page.locator("#neck_girth").fill("13 1/4");
  await page.locator("main form button.button[type=submit]").click();
  await ready(page);
  const height = page.locator("#edit-stature");
  const cell = page.locator('tr[data-measurement="stature"] td').first();
  await expect(height).toHaveValue("5 ft 6 in");
  await changed(page, "stature", "5'7 1/2\"");
  await expect(cell).toHaveText("5′ 7.50″");
  await height.press("ArrowUp");
  await expect(height).toHaveValue("5 ft 7.75 in");
  await expect(height).toHaveAttribute("aria-valuenow", "67.75");
  await expect(page.locator('tr[data-measurement="neck_girth"] td').first()).toHaveText("13.25");
  await page.locator("[data-step='-1']").first().click();
  await expect(cell).toHaveText("5′ 7.50″");
});
