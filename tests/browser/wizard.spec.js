/** The whole way through the wizard: languages, units, with and without scripts, by keyboard. */

import { axe, expect, tabTo, test } from "./site.js";
import { METRIC, NEXT, begin, walk } from "./wizard.js";

const IMPERIAL = {
  stature: "5 ft 6",
  weight: "138",
  bust_girth: "36 1/4",
  waist_girth: "29 1/8",
  abdomen_girth: "32.3",
  hip_girth: "39",
  thigh_girth: "22.8",
  mid_thigh_girth: "18 1/2",
  inseam_height: "30.7",
};
const WORDS = {
  "en-GB": { start: "Measure yourself", review: "Your numbers", height: "Height" },
  "pt-PT": { start: "Tire as suas medidas", review: "Os seus números", height: "Altura" },
};

const title = (page) => page.locator("h1");

/** Nothing sticks out sideways: one scrolls a page downwards only. */
async function expectNarrow(page) {
  const overflow = () => document.documentElement.scrollWidth - window.innerWidth;
  expect(await page.evaluate(overflow)).toBeLessThanOrEqual(0);
}

/** Choose one of some radio buttons as the keyboard does: come to them, then the arrows. */
async function choose(page, name, value) {
  await tabTo(page, `input[name="${name}"]`);
  await page.keyboard.press("Space");
  const chosen = page.locator(`input[name="${name}"]:checked`);
  for (let presses = 0; (await chosen.inputValue()) !== value && presses < 3; presses += 1) {
    await page.keyboard.press("ArrowDown");
  }
  expect(await chosen.inputValue()).toBe(value);
}

for (const [locale, units, values, javaScriptEnabled] of [
  ["en-GB", "metric", METRIC, true],
  ["en-GB", "imperial", IMPERIAL, false],
  ["pt-PT", "metric", METRIC, false],
  ["pt-PT", "imperial", IMPERIAL, true],
]) {
  const scripts = javaScriptEnabled ? "with" : "without";
  test.describe(`${locale}, ${units}, ${scripts} scripts, by keyboard alone`, () => {
    test.use({ locale, javaScriptEnabled, viewport: { width: 360, height: 740 } });

    test("from the start to the review and the body", async ({ page }) => {
      await page.goto("/");
      await expect(title(page)).toHaveText(WORDS[locale].start);
      await choose(page, "body", "female");
      await choose(page, "units", units);
      await page.keyboard.press("Enter");
      for (const [name, value] of Object.entries(values)) {
        await page.waitForURL(`**/measure/${name}`);
        if (name === "stature") await expect(title(page)).toHaveText(WORDS[locale].height);
        if (name === "inseam_height") await choose(page, "inseam_height:to", "floor");
        await tabTo(page, `#${name}`);
        await page.keyboard.type(value);
        await expectNarrow(page);
        await page.keyboard.press("Enter");
      }
      await page.waitForURL("**/review");
      await expect(title(page)).toHaveText(WORDS[locale].review);
      await expect(page.locator(".entered li")).toHaveCount(Object.keys(values).length);
      await expect(page.locator(".question")).toHaveCount(0);
      await tabTo(page, "main .actions .button");
      await page.keyboard.press("Enter");
      await expect(page).toHaveURL(/\/avatar$/);
      await expect(page.locator('tr[data-measurement="waist_girth"]')).toHaveCount(1);
    });
  });
}

for (const [width, colorScheme] of [
  [360, "light"],
  [1280, "dark"],
]) {
  test.describe(`axe at ${width} pixels, ${colorScheme}`, () => {
    test.use({ viewport: { width, height: 800 }, colorScheme });

    test("finds nothing on any page of the wizard", async ({ page, complaints }) => {
      await page.goto("/");
      expect(await axe(page)).toEqual([]);
      await begin(page);
      await page.locator("#stature").fill("168");
      await page.locator(NEXT).click();
      for (const path of ["measure/stature", "measure/inseam_height", "measure", "review"]) {
        await page.goto(`/${path}`);
        expect(await axe(page), path).toEqual([]);
      }
      // A fault, a question, a third reading.
      await page.goto("/measure/waist_girth");
      await page.locator("#waist_girth").fill("29");
      await page.locator(NEXT).click();
      await expect(page.locator("#summary")).toBeFocused();
      expect(await axe(page)).toEqual([]);
      complaints.expect(/status of 422/); // the answer's own
      await page.goto("/measure/waist_girth");
      await page.locator("#waist_girth").fill("95");
      await expect(page.locator(".question button[name=keep]")).toBeVisible();
      expect(await axe(page)).toEqual([]);
      await page.goto("/measure/hip_girth");
      await page.locator("#hip_girth").fill("98");
      await page.locator("details.again summary").click();
      await page.locator("#hip_girth-2").fill("102");
      await page.locator(NEXT).click();
      await expect(page.locator("#third input")).toBeVisible();
      expect(await axe(page)).toEqual([]);
    });
  });
}

test("a number in another unit is proposed as it is typed, and taken by one press", async ({
  page,
}) => {
  await begin(page);
  await page.locator("#stature").fill("1.68");
  await expect(page.locator("#check")).toContainText("Did you mean 168 cm?");
  await page.locator("#check button[name=use]").click();
  await expect(page).toHaveURL(/\/measure\/weight$/);
  await page.locator("#back").click();
  await expect(page.locator("#stature")).toHaveValue("168");
});

test("an unusual number is asked about as it is typed, and may be kept", async ({ page }) => {
  await begin(page);
  await page.locator("#stature").fill("168");
  await page.locator(NEXT).click();
  await page.locator("#weight").fill("62");
  await page.locator(NEXT).click();
  await page.goto("/measure/neck_girth");
  await page.locator("#neck_girth").fill("45");
  await expect(page.locator("#check")).toContainText("seems unusual");
  await page.locator("#check button[name=keep]").click();
  await page.goto("/review");
  await expect(page.locator("main")).toContainText("You looked at it again and kept it.");
});

test("what was typed and never sent survives a reload, and a change of language", async ({
  page,
}) => {
  await begin(page);
  await page.locator("#stature").fill("17");
  await page.reload();
  await expect(page.locator("#stature")).toHaveValue("17");
  await page.locator("#stature").fill("171");
  await page.getByRole("button", { name: "Português" }).click();
  await expect(title(page)).toHaveText("Altura");
  await expect(page.locator("#stature")).toHaveValue("171");
});

test("units change on any step and come back to what was typed", async ({ page }) => {
  await begin(page);
  await page.locator("#stature").fill("168");
  await page.locator("button[value=imperial]").click();
  await expect(page.locator("#stature")).toHaveValue("5 ft 6.14 in");
  await page.locator("button[value=metric]").click();
  await expect(page.locator("#stature")).toHaveValue("168");
});

test("the tape is shown in 3D on the person's own body, once, which changes as they type", async ({
  page,
}) => {
  await begin(page);
  await page.locator("#stature").fill("168");
  await page.locator(NEXT).click();
  await page.goto("/measure/waist_girth");
  let release;
  const held = new Promise((resolve) => {
    release = resolve;
  });
  await page.route(/build\/stage-/, async (route) => {
    await held;
    await route.continue();
  });
  const viewer = page.locator("#viewer");
  await expect(viewer).toBeHidden();
  // Pressed again and again while it comes.
  for (let press = 0; press < 3; press += 1) await page.locator("#preview button").click();
  release();
  await expect(viewer).toHaveAttribute("data-state", "ready", { timeout: 30_000 });
  await expect(viewer.locator("canvas")).toHaveCount(1);
  await expect(viewer.locator(".tape-label")).toHaveCount(1);
  await expect(viewer.locator(".tape-label")).toContainText("Waist");
  await page.locator("#waist_girth").fill("84");
  await expect(viewer.locator(".tape-label")).toContainText("84.0 cm");
  expect(await axe(page)).toEqual([]);
});
