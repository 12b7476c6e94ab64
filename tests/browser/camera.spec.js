/** The camera: it says how to stand, and takes the photo by itself. */

import { writeFile } from "node:fs/promises";

import { launchOptions } from "./chromium.js";
import { composed } from "./photos.js";
import { CHATTER, SLOWLY, card, found, open, photos, status, test } from "./photos_page.js";
import { axe, enter, expect } from "./site.js";

test.setTimeout(300_000);

test("the camera says what to do and takes the photo once the person stands well", async ({
  page,
  request,
  playwright,
  traffic,
  complaints,
  baseURL,
}, testInfo) => {
  complaints.expect(CHATTER);
  // A camera that shows the composed photo, again and again: frames of a motion JPEG.
  const frame = await composed(page, request, { size: [480, 720] });
  photos.push(frame);
  const film = testInfo.outputPath("camera.mjpeg");
  await writeFile(film, Buffer.concat([frame, frame, frame]));
  const options = launchOptions();
  const browser = await playwright.chromium.launch({
    ...options,
    args: [
      ...options.args,
      "--use-fake-device-for-media-stream",
      "--use-fake-ui-for-media-stream",
      `--use-file-for-fake-video-capture=${film}`,
    ],
  });
  const context = await browser.newContext({ baseURL, viewport: { width: 400, height: 800 } });
  const phone = await context.newPage();
  complaints.watch(phone);
  await phone.addInitScript(() => {
    window.spoken = [];
    speechSynthesis.speak = ({ text }) => window.spoken.push(text);
  });
  await enter(phone);
  await phone.goto("/compare");
  const dialog = phone.locator("#camera");

  // The same person is wrong for the side: told so, and never photographed.
  await card(phone, "profile").getByRole("button", { name: "Use the camera" }).click();
  await expect(dialog.locator("[data-hint]")).toHaveText("Turn your side to the camera.", SLOWLY);
  expect(await axe(phone)).toEqual([]);
  await phone.keyboard.press("Escape");
  await expect(dialog).toBeHidden();
  await expect(card(phone, "profile").locator(".sight")).toBeHidden();
  // What is hidden is told as closed a task later: only then is the camera let go.
  const running = () => phone.evaluate(() => document.querySelector("video").srcObject !== null);
  await expect.poll(running).toBe(false);

  await card(phone).getByRole("button", { name: "Use the camera" }).click();
  await expect(dialog.locator("[data-count]")).toHaveText("2", SLOWLY);
  await found(phone);
  await expect(dialog).toBeHidden();
  await expect.poll(running).toBe(false);
  await expect(status(phone)).toHaveText(/This is your outline/);
  const spoken = await phone.evaluate(() => window.spoken);
  expect(spoken[0]).toBe("One moment."); // in the click itself
  for (const words of ["Turn your side to the camera.", "Good. Stay like that.", "3", "2", "1"]) {
    expect(spoken).toContain(words);
  }
  // Pictures of the camera went to the worker alone.
  const sent = traffic.heard.filter(({ body }) => body.length).map(({ url }) => url);
  expect(sent.filter((url) => !url.startsWith("/api/"))).toEqual(["/numbers"]);
  expect(traffic.heard.filter(({ url }) => /[?&](?!v=)/.test(url))).toEqual([]);
  await browser.close();
});

test("without a camera the page says so", async ({ page, complaints }) => {
  await open(page, complaints);
  await page.evaluate(() => {
    navigator.mediaDevices.getUserMedia = () => Promise.reject(new DOMException("none", "NotFoundError"));
    delete globalThis.OffscreenCanvas;
  });
  await card(page).getByRole("button", { name: "Use the camera" }).click();
  await expect(status(page)).toHaveText(/cannot use a camera here/);
  await expect(page.locator("#camera")).toBeHidden();
});
