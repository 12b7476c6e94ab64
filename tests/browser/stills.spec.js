/** The body in 3D and the still pictures of it: one camera and one scale. */

import {
  changed,
  enter,
  expect,
  inViewer,
  look,
  openAvatar,
  pixels,
  ready,
  test,
} from "./site.js";

test.use({ contextOptions: { reducedMotion: "reduce" } });

test("beside the pictures the body has their camera and their scale", async ({ page }) => {
  await page.setViewportSize({ width: 1280, height: 1000 });
  await openAvatar(page);
  await page.locator('[data-switch="beside"]').click();
  await page.locator("#viewer .overlay").evaluate((overlay) => {
    overlay.style.visibility = "hidden"; // a height in hand is drawn wider than the body
  });
  const compare = async (side) => {
    await expect.poll(() => inViewer(page, (viewer) => viewer.hasGhost)).toBe(false);
    const seen = await look(page);
    const shown = span(seen);
    const still = page.locator(`figure img[data-side="${side}"]`);
    await still.scrollIntoViewIfNeeded();
    await expect.poll(() => still.evaluate((image) => image.complete)).toBe(true);
    const picture = span(await pixels(page, await still.screenshot()));
    expect(Math.abs(shown.height / picture.height - 1)).toBeLessThan(0.015);
    expect(Math.abs(shown.width / picture.width - 1)).toBeLessThan(0.03);
    expect(shown.height).toBeLessThan(0.95 * seen.height); // neither head nor feet are cut off
  };
  await compare("front");
  // Another body comes into the same frame, without a press.
  await changed(page, "stature", "185");
  await compare("front");
  await page.locator('[data-view="side"]').click();
  await compare("profile");
  await changed(page, "stature", "160");
  await compare("profile");
});

for (const size of [{ width: 1000, height: 800 }, { width: 360, height: 740 }]) {
  test(`the body in 3D takes the still picture's place unnoticed, ${size.width} wide`, async ({ page }) => {
    await page.setViewportSize(size);
    await enter(page);
    const still = page.locator("#viewer img");
    await expect(still).toBeVisible();
    await expect.poll(() => still.evaluate((image) => image.complete)).toBe(true);
    const before = span(await pixels(page, await page.locator("#viewer").screenshot()));
    await ready(page);
    const after = span(await look(page));
    expect(before.height).toBeGreaterThan(100);
    expect(Math.abs(before.height / after.height - 1)).toBeLessThan(0.03);
    expect(Math.abs(before.width / after.width - 1)).toBeLessThan(0.04);
  });
}

/** How far a picture's body reaches: skin and cloth are far from the greys of the backdrop. */
function span({ width, height, data }) {
  const [rows, columns] = [new Set(), new Set()];
  for (let y = 4; y < height - 4; y += 1) {
    for (let x = 4; x < width - 4; x += 1) {
      const at = 4 * (y * width + x);
      if (Math.abs(data[at] - data[at + 2]) < 14) continue;
      rows.add(y);
      columns.add(x);
    }
  }
  const reach = (set) => Math.max(...set) - Math.min(...set);
  return { height: reach(rows), width: reach(columns) };
}
