/** What axe finds on the form of all numbers and on the body's page: nothing. Other pages' tests ask it too. */

import { WOMAN, axe, enter, expect, openAvatar, test } from "./site.js";

// Each width and each scheme once: neither hides what the other shows.
for (const [width, colorScheme] of [[360, "light"], [1280, "dark"]]) {
  test.describe(`${width} pixels, ${colorScheme}`, () => {
    test.use({ viewport: { width, height: 800 }, colorScheme });

    test("the form", async ({ page }) => {
      await page.goto("/numbers");
      expect(await axe(page)).toEqual([]);
    });

    test("the form with messages", async ({ page, complaints }) => {
      await enter(page, { ...WOMAN, stature: "", waist_girth: "seventy" });
      await expect(page.locator("[aria-invalid=true]")).toHaveCount(2);
      expect(await axe(page)).toEqual([]);
      complaints.expect(/status of 422/); // the answer's own
    });

    test("the avatar", async ({ page }) => {
      await openAvatar(page);
      expect(await axe(page)).toEqual([]);
    });
  });
}
