/** What the tests of the page of photos share: a server that hears all, and what a shopper does there. */

import { carries, listen } from "./photos.js";
import { enter, expect, test as base } from "./site.js";

// The runtime says what it does as if it were an error.
export const CHATTER = /XNNPACK/;

/** The photos that a test has shown to a page. */
export const photos = [];

/**
 * Every page here is asked for through a server that hears all that is sent: the numbers and
 * outlines, and of no photo any part, however it is written.
 */
export const test = base.extend({
  traffic: async ({}, use, { project }) => {
    const traffic = await listen(project.use.baseURL);
    photos.length = 0;
    await use(traffic);
    await traffic.close();
    const sent = traffic.heard.filter(({ method, body }) => method !== "GET" || body.length);
    const ours = /^(POST \/(numbers|compare)|POST \/api\/v1\/avatars\/(front|profile)\.png)$/;
    expect(sent.map(({ method, url }) => `${method} ${url}`).filter((one) => !ours.test(one))).toEqual([]);
    expect(photos.filter((photo) => carries(traffic.heard, photo))).toEqual([]);
  },
  baseURL: ({ traffic }, use) => use(traffic.url),
});

/** For what a network has to be loaded for, on a machine that does other things besides. */
export const SLOWLY = { timeout: 120_000 };

export const card = (page, view = "front") => page.locator(`.view[data-view="${view}"]`);
export const status = (page, view) => card(page, view).locator(".view-status");
export const compare = (page) => page.locator("#comparison [type=submit]").click();

export async function open(page, complaints) {
  complaints.expect(CHATTER);
  await enter(page);
  await page.goto("/compare");
  await expect(card(page).locator(".ways")).toBeVisible();
}

export async function choose(page, buffer, view = "front", mimeType = "image/jpeg") {
  photos.push(buffer);
  const file = { name: "photo", mimeType, buffer };
  await page.locator(`#${view}-photo`).setInputFiles(file);
}

export const found = (page, view) =>
  expect(card(page, view)).toHaveAttribute("data-state", "open", SLOWLY);

/** A drawing of somebody: light boxes on dark, each [left, top, width, height], as a PNG file. */
export async function boxes(page, ...drawn) {
  const base64 = await page.evaluate(async (drawn) => {
    const context = new OffscreenCanvas(300, 600).getContext("2d");
    context.fillRect(0, 0, 300, 600);
    context.fillStyle = "white";
    for (const box of drawn) context.fillRect(...box);
    const blob = await context.canvas.convertToBlob();
    return btoa(String.fromCharCode(...new Uint8Array(await blob.arrayBuffer())));
  }, drawn);
  return { name: "outline.png", mimeType: "image/png", buffer: Buffer.from(base64, "base64") };
}

/** How many pixels of an open outline are the person's. */
export const uncovered = async (page, view = "front") =>
  Number(await card(page, view).locator(".sight").getAttribute("data-pixels"));

/** The photo is shown, nothing of it is the person's yet, and the brush paints. */
export async function brushAlone(page) {
  await expect(status(page)).toHaveText(/Paint over yourself with the brush/, SLOWLY);
  await found(page);
  await expect(card(page).locator("[data-tool=add]")).toHaveAttribute("aria-pressed", "true");
  expect(await uncovered(page)).toBe(0);
  await card(page).locator("canvas").click();
  await expect.poll(() => uncovered(page)).toBeGreaterThan(0);
}
