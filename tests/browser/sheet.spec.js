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
