/** The way through the wizard, which its tests and the pictures of its docs go alike. */

/** What somebody enters, step by step, in centimetres and kilograms. */
export const METRIC = {
  stature: "168",
  weight: "62,5",
  bust_girth: "92",
  waist_girth: "74",
  abdomen_girth: "82",
  hip_girth: "99",
  thigh_girth: "58",
  mid_thigh_girth: "47",
  inseam_height: "78",
};

export const NEXT = "main :is(.finish button.button, .actions a.button)";

/** From the start to the first measurement; `look` sees the start before it is left. */
export async function begin(page, units = "metric", look = async () => {}) {
  await page.goto("/");
  await look();
  await page.locator("#body-female").check();
  await page.locator(`#units-${units}`).check();
  await page.locator(NEXT).click();
}

/** Through all steps with the pointer; `look` sees each page once it is filled in. */
export async function walk(page, values, look = async () => {}) {
  for (const [name, value] of Object.entries(values)) {
    await page.waitForURL(`**/measure/${name}`);
    if (name === "inseam_height") await page.locator("#to-floor").check();
    await page.locator(`#${name}`).fill(value);
    await look(name);
    await page.locator(NEXT).click();
  }
  await page.waitForURL("**/review");
}
