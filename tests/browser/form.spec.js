/** The form of all numbers: nothing typed is lost, with scripts and without. */

import { enter, expect, test } from "./site.js";

const typed = (page) =>
  page.locator("#measurements").evaluate((form) =>
    Object.fromEntries(
      [...new FormData(form)].filter(([name, value]) => value && name !== "csrf_token"),
    ),
  );

const units = (page, choice) => page.locator(`button[name="switch_to"][value="${choice}"]`);

async function begin(page) {
  await page.goto("/numbers");
  await page.locator("#body-male").check();
  await page.locator("#stature").fill("180");
  await page.locator("#hip_girth").fill("101,5");
}

test("a reload keeps what was typed and never sent", async ({ page }) => {
  await begin(page);
  await page.reload();
  expect(await typed(page)).toEqual({
    body: "male",
    units: "metric",
    stature: "180",
    hip_girth: "101,5",
  });
});

test("units change in place, keep the focus, and come back to what was typed", async ({ page }) => {
  await begin(page);
  await units(page, "imperial").click();
  await expect(page.locator("#stature")).toHaveValue("5 ft 10.87 in");
  await expect(page.locator("#hip_girth")).toHaveValue("39.96");
  await expect(page.locator("#hip_girth-unit")).toHaveText("in");
  await expect(units(page, "imperial")).toBeFocused();
  await expect(units(page, "imperial")).toHaveAttribute("aria-pressed", "true");
  await units(page, "metric").click();
  await expect(page.locator("#stature")).toHaveValue("180");
  await expect(page.locator("#hip_girth")).toHaveValue("101.5");
});

test("units change although the script's way to the server fails", async ({ page, complaints }) => {
  complaints.expect(/Failed to load resource/);
  await begin(page);
  await page.route("/numbers", (route, request) =>
    request.resourceType() === "fetch" ? route.abort() : route.continue(),
  );
  await units(page, "imperial").click();
  await expect(page.locator("#stature")).toHaveValue("5 ft 10.87 in");
});

test("going back from the body shows what was typed", async ({ page }) => {
  await begin(page);
  await page.locator("#hip_girth").press("Enter");
  await expect(page).toHaveURL(/\/avatar$/);
  await page.goBack();
  await expect(page.locator("#stature")).toHaveValue("180");
  await expect(page.locator("#hip_girth")).toHaveValue("101,5");
});

test("the answers to look at again take the focus and lead to their fields", async ({
  page,
  complaints,
}) => {
  complaints.expect(/422/);
  await enter(page, { body: "female", stature: "1.68", waist_girth: "74" });
  await expect(page.locator("#summary")).toBeFocused();
  await page.getByRole("link", { name: "Height: That looks like metres." }).click();
  await expect(page.locator("#stature")).toBeFocused();
  await expect(page.locator("#stature")).toHaveValue("1.68");
});

test("forgotten measurements stay forgotten", async ({ page }) => {
  await begin(page);
  await units(page, "imperial").click();
  await expect(page.locator("#stature")).toHaveValue("5 ft 10.87 in");
  await page.locator("#neck_girth").fill("15");
  await page.getByRole("button", { name: "Forget my measurements now" }).click();
  await expect(page.getByRole("status")).toHaveText("Your measurements are forgotten.");
  expect(await typed(page)).toEqual({ units: "metric" });
  await page.reload();
  expect(await typed(page)).toEqual({ units: "metric" });
});

test.describe("without scripts", () => {
  test.use({ javaScriptEnabled: false });

  test("units change and come back to what was typed", async ({ page }) => {
    await begin(page);
    await units(page, "imperial").click();
    await expect(page.locator("#stature")).toHaveValue("5 ft 10.87 in");
    await expect(page.locator("#body-male")).toBeChecked();
    await units(page, "metric").click();
    await expect(page.locator("#hip_girth")).toHaveValue("101.5");
  });

  test("the answers to look at again take the focus", async ({ page, complaints }) => {
    complaints.expect(/422/);
    await enter(page, { stature: "1.68" });
    await expect(page.locator("#summary")).toBeFocused();
    await expect(page.locator("#stature")).toHaveAttribute("aria-invalid", "true");
  });
});

test("what was typed and not sent is forgotten with the rest", async ({ page }) => {
  await page.goto("/");
  await page.locator("#body-female").check();
  await page.locator("main .finish button.button").click();
  await page.waitForURL("**/measure/stature");
  await page.locator("#stature").fill("171");
  const kept = () => page.evaluate(() => Object.values(sessionStorage).join());
  await expect.poll(kept).toContain("171");
  await page.goto("/numbers");
  await page.getByRole("button", { name: "Forget my measurements now" }).click();
  await expect(page.getByRole("status")).toHaveText("Your measurements are forgotten.");
  await expect.poll(kept).not.toContain("171");
});
