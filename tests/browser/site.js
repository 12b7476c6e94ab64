/** What the browser tests share: a page that is watched, ways to fill it in, ways to look at it. */

import { test as base, expect } from "@playwright/test";

export { axe } from "./axe.js";
export { expect };

/**
 * A test whose page may not complain: no error on the console, none thrown, and nothing asked of
 * another origin. A test that provokes complaints says which: `complaints.expect(/422/)`; one that
 * opens a page in a browser of its own has it watched too: `complaints.watch(page)`.
 */
export const test = base.extend({
  complaints: [
    async ({ page, baseURL }, use) => {
      const heard = [];
      const expected = [];
      const watch = (page) => {
        page.on("console", (message) => {
          if (message.type() === "error") heard.push(`console: ${message.text()}`);
        });
        page.on("pageerror", (error) => heard.push(`thrown: ${error.message}`));
        page.on("request", (request) => {
          const { origin, protocol } = new URL(request.url());
          if (["blob:", "data:"].includes(protocol)) return;
          if (origin !== new URL(baseURL).origin) heard.push(`another origin: ${request.url()}`);
        });
      };
      watch(page);
      await use({ expect: (pattern) => expected.push(pattern), watch });
      const unexpected = heard.filter((line) => !expected.some((pattern) => pattern.test(line)));
      expect(unexpected).toEqual([]);
    },
    { auto: true },
  ],
});

export const WOMAN = {
  body: "female",
  stature: "168",
  bust_girth: "92",
  waist_girth: "74",
  hip_girth: "100",
  thigh_girth: "58",
};

/** Fill in the form of all numbers with the pointer and send it. */
export async function enter(page, person = WOMAN) {
  await page.goto("/numbers");
  const { body, ...values } = person;
  if (body) await page.locator(`input[name="body"][value="${body}"]`).check();
  for (const [name, value] of Object.entries(values)) {
    await page.locator(`input[name="${name}"]`).fill(value);
  }
  await page.locator("main form button.button[type=submit]").click();
}

/** The avatar's page, with the body in 3D on it. */
export async function openAvatar(page, person = WOMAN) {
  await enter(page, person);
  await expect(page).toHaveURL(/\/avatar$/);
  await ready(page);
}

/** The body in 3D comes at the reader's first touch, once the page's script listens for it. */
export async function ready(page, state = "ready") {
  const viewer = page.locator("#viewer");
  await expect(async () => {
    await viewer.dispatchEvent("pointermove");
    await expect(viewer).toHaveAttribute("data-state", state, { timeout: 2000 });
  }).toPass({ timeout: 60_000 });
}

/** A field beside the body. */
export const field = (page, name) => page.locator(`#edit-${name}`);

/** Do something with the viewer in the page. */
export async function inViewer(page, work, given) {
  const viewer = await page.evaluateHandle(() => document.querySelector("#viewer").viewer);
  return viewer.evaluate(work, given);
}

/** Type a value beside the body, and wait until the server's body is on its way. */
export const changed = (page, name, value) =>
  Promise.all([
    page.waitForResponse((answer) => answer.request().method() === "POST" && answer.ok()),
    page.waitForResponse((answer) => answer.url().endsWith("/avatar.glb")),
    field(page, name).fill(value),
  ]);

/** Press Tab until the element has the focus, as somebody without a pointer does. */
export async function tabTo(page, selector, most = 80) {
  const reached = () => page.evaluate((s) => document.activeElement?.matches(s) ?? false, selector);
  for (let presses = 0; presses < most; presses += 1) {
    if (await reached()) return;
    await page.keyboard.press("Tab");
  }
  expect(await reached(), `${selector} is reached with the Tab key`).toBe(true);
}

/** The pixels of a screenshot at half its size: {width, height, data}, four numbers each. */
export async function pixels(page, png) {
  const { width, height, text } = await page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const [width, height] = [bitmap.width >> 1, bitmap.height >> 1];
    const context = new OffscreenCanvas(width, height).getContext("2d");
    context.drawImage(bitmap, 0, 0, width, height);
    const { data } = context.getImageData(0, 0, width, height);
    let text = "";
    for (const value of data) text += String.fromCharCode(value);
    return { width, height, text: btoa(text) };
  }, png.toString("base64"));
  return { width, height, data: Buffer.from(text, "base64") };
}

/** The share of pixels, 0 to 1, in which two pictures of one size are visibly different. */
export function difference(one, other) {
  expect([one.width, one.height]).toEqual([other.width, other.height]);
  return share(one, (at, channel) => other.data[at + channel]);
}

/** The share of a picture that is not of its background's colour, as near its upper left corner. */
export function drawn(picture) {
  const near = 4 * (6 * picture.width + 6);
  return share(picture, (_, channel) => picture.data[near + channel]);
}

function share({ data }, expected) {
  let changed = 0;
  for (let at = 0; at < data.length; at += 4) {
    const differs = (channel) => Math.abs(data[at + channel] - expected(at, channel)) > 12;
    if (differs(0) || differs(1) || differs(2)) changed += 1;
  }
  return changed / (data.length / 4);
}

/** The view in 3D as it stands, once it has come to rest. */
export async function look(page) {
  const canvas = page.locator("#viewer canvas");
  const calm = await page.evaluate(() => matchMedia("(prefers-reduced-motion: reduce)").matches);
  await page.waitForTimeout(calm ? 150 : 700); // a turn's time
  let before = await canvas.screenshot();
  for (let tries = 0; tries < 20; tries += 1) {
    await page.waitForTimeout(100);
    const now = await canvas.screenshot();
    if (now.equals(before)) return pixels(page, now);
    before = now;
  }
  throw new Error("the view does not come to rest");
}
