/** The sheet to print: one piece of paper, and readable by everyone on screen. */

import { axe, enter, expect, test } from "./site.js";

for (const format of ["A4", "Letter"]) {
  test(`all measurements and both pictures fit on one sheet, ${format}`, async ({ page }) => {
    await enter(page);
    await page.goto("/avatar/sheet", { waitUntil: "networkidle" });
    const paper = await page.pdf({ format });
    expect(paper.toString("latin1")).toContain("/Count 1\n");
    await page.emulateMedia({ media: "print" });
    await expect(page.locator(".site-header, .unprinted").first()).toBeHidden();
    await expect(page.locator("tr[data-measurement]")).toHaveCount(41);
  });
}

for (const colorScheme of ["light", "dark"]) {
  test(`axe finds nothing on the sheet, ${colorScheme}`, async ({ page }) => {
    await page.emulateMedia({ colorScheme });
    await page.setViewportSize({ width: 360, height: 700 });
    await enter(page);
    await page.goto("/avatar/sheet");
    expect(await axe(page)).toEqual([]);
  });
}

test.describe("in Portuguese, in inches", () => {
  test.use({ locale: "pt-PT", viewport: { width: 360, height: 700 } });

  test("nothing of the sheet sticks out sideways on a telephone", async ({ page }) => {
    await page.goto("/numbers");
    await page.locator("button[value=imperial]").click();
    await expect(page.locator("#stature-unit")).toHaveText("ft, in");
    await enter(page, { body: "male", stature: "5'10 1/4", weight: "170", hip_girth: "39 1/2" });
    await page.goto("/avatar/sheet");
    await expect(page.locator("h1")).toHaveText("As suas medidas");
    const overflow = () => document.documentElement.scrollWidth - window.innerWidth;
    expect(await page.evaluate(overflow)).toBeLessThanOrEqual(0);
  });
});
