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
  "en-GB": { start: "Measure yourself", review: "What you have entered", height: "Height" },
  "pt-PT": { start: "Tire as suas medidas", review: "O que indicou", height: "Altura" },
};

const title = (page) => page.locator("h1");

/** The measurement that the page asks for, from its address. */
const asked = (page) => new URL(page.url()).pathname.split("/").pop();

/** Nothing sticks out sideways: one scrolls a page downwards only. */
async function expectNarrow(page) {
  const overflow = () => document.documentElement.scrollWidth - window.innerWidth;
  expect(await page.evaluate(overflow)).toBeLessThanOrEqual(0);
}

for (const [locale, units, values, javaScriptEnabled, width] of [
  ["en-GB", "metric", METRIC, true, 360],
  ["en-GB", "imperial", IMPERIAL, false, 1280],
  ["pt-PT", "metric", METRIC, false, 360],
  ["pt-PT", "imperial", IMPERIAL, true, 1280],
]) {
  const scripts = javaScriptEnabled ? "with" : "without";
  test.describe(`${locale}, ${units}, ${scripts} scripts, ${width} pixels`, () => {
    test.use({ locale, javaScriptEnabled, viewport: { width, height: 760 } });

    test("from the start to the review and the body", async ({ page }) => {
      await page.goto("/");
      await expect(title(page)).toHaveText(WORDS[locale].start);
      await begin(page, units);
      await expect(title(page)).toHaveText(WORDS[locale].height);
      await walk(page, values, () => (javaScriptEnabled ? expectNarrow(page) : undefined));
      await expect(title(page)).toHaveText(WORDS[locale].review);
      await expect(page.locator(".entered li")).toHaveCount(Object.keys(values).length);
      await expect(page.locator(".question")).toHaveCount(0);
      await page.locator("main .actions .button").click();
      await expect(page).toHaveURL(/\/avatar$/);
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

test("by keyboard alone, from the start to the review", async ({ page }) => {
  await page.setViewportSize({ width: 360, height: 740 });
  await page.goto("/");
  await tabTo(page, "input[name=body]");
  await page.keyboard.press("Space");
  await page.keyboard.press("Enter");
  await expect(page).toHaveURL(/\/measure\/stature$/);
  for (let steps = 0; steps < 12 && !page.url().endsWith("/review"); steps += 1) {
    const name = asked(page);
    await tabTo(page, `#${name}`);
    if (name === "stature") await page.keyboard.type("168");
    if (name === "weight") await page.keyboard.type("62");
    if (name === "stature" || name === "weight") {
      await page.keyboard.press("Enter");
    } else {
      await tabTo(page, "button[name=skip]");
      await page.keyboard.press("Space");
    }
    await expect.poll(() => asked(page)).not.toBe(name);
  }
  await expect(page).toHaveURL(/\/review$/);
  await tabTo(page, "main .actions .button");
});

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

test("the view in 3D opens once, however often its button is pressed while it comes", async ({
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
  for (let press = 0; press < 3; press += 1) await page.locator("#preview button").click();
  release();
  const viewer = page.locator("#viewer");
  await expect(viewer).toHaveAttribute("data-state", "ready", { timeout: 30_000 });
  await expect(viewer.locator("canvas")).toHaveCount(1);
  await expect(viewer.locator(".tape-label")).toHaveCount(1);
});

test("the tape is shown in 3D on the person's own body, which changes as they type", async ({
  page,
}) => {
  await begin(page);
  await page.locator("#stature").fill("168");
  await page.locator(NEXT).click();
  await page.goto("/measure/waist_girth");
  await expect(page.locator("#viewer")).toBeHidden();
  await page.locator("#preview button").click();
  const viewer = page.locator("#viewer");
  await expect(viewer).toBeVisible();
  await expect(viewer).toHaveAttribute("data-state", "ready", { timeout: 30_000 });
  await expect(viewer.locator(".tape-label")).toContainText("Waist");
  await page.locator("#waist_girth").fill("84");
  await expect(viewer.locator(".tape-label")).toContainText("84.0 cm");
  expect(await axe(page)).toEqual([]);
});
