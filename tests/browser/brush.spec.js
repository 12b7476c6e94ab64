/** The brush: an outline is mended by hand, and made by hand alone where nothing finds the person. */

import { composed } from "./photos.js";
import { SLOWLY, boxes, brushAlone, card, choose, compare, found, open, status, test, uncovered } from "./photos_page.js";
import { axe, expect, tabTo } from "./site.js";

test.setTimeout(300_000);

test.describe("at 360 pixels, dark", () => {
  test.use({ viewport: { width: 360, height: 740 }, colorScheme: "dark", hasTouch: true });

  test("an outline is mended by hand: mouse, finger, keys, one step back, and all", async ({
    page,
    complaints,
  }) => {
    await open(page, complaints);
    const view = card(page);
    await page.locator("#front-outline").setInputFiles(await boxes(page, [100, 100, 100, 400]));
    await found(page);
    expect(await page.locator("#front-outline").inputValue()).toBe(""); // the form holds no file
    await expect(view.locator("[data-tool=look]")).toHaveAttribute("aria-pressed", "true");
    expect(await axe(page)).toEqual([]);
    expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBe(360);
    const canvas = view.locator("canvas");
    const tool = (name) => view.getByRole("button", { name, exact: true });
    const areas = [await uncovered(page)];
    const changed = async (act, sign) => {
      await act();
      await expect
        .poll(async () => Math.sign((await uncovered(page)) - areas.at(-1)), { message: `${act}` })
        .toBe(sign);
      areas.push(await uncovered(page));
    };
    await canvas.scrollIntoViewIfNeeded();
    const { x, y, width, height } = await canvas.boundingBox();
    const at = (across, down) => [x + across * width, y + down * height];

    await page.mouse.click(...at(0.8, 0.4)); // looking changes nothing
    await tool("Add").click();
    await changed(async () => {
      await page.mouse.move(...at(0.7, 0.4));
      await page.mouse.down();
      await page.mouse.move(...at(0.9, 0.4), { steps: 4 });
      await page.mouse.up();
    }, 1);
    await tool("Erase").tap();
    await canvas.scrollIntoViewIfNeeded();
    await changed(() => canvas.tap({ position: { x: 0.5 * width, y: 0.5 * height } }), -1);
    await tool("Add").focus();
    await page.keyboard.press("Enter");
    await tabTo(page, '.view[data-view="front"] canvas');
    await changed(async () => {
      // From where the finger was, to the right and out of the figure.
      for (let i = 0; i < 40; i += 1) await page.keyboard.press("ArrowRight");
      await page.keyboard.press("Space");
    }, 1);
    for (const sign of [-1, 1, -1]) {
      const before = areas.at(-2);
      await changed(() => tool("Undo").click(), sign);
      expect(areas.pop()).toBe(before);
      areas.pop();
    }
    await expect(tool("Undo")).toBeDisabled();
    const first = areas[0];
    await tool("Erase").click();
    await canvas.scrollIntoViewIfNeeded();
    await changed(() => canvas.tap({ position: { x: 0.5 * width, y: 0.3 * height } }), -1);
    await changed(() => tool("Reset").click(), 1);
    expect(areas.at(-1)).toBe(first);
    await view.getByRole("button", { name: "Remove this photo" }).click();
    await expect(canvas).toBeHidden();
    await compare(page);
    await expect(page.locator(".form-status")).toHaveText(/Choose or take a photo first/);
  });
});

for (const [what, without] of Object.entries({
  "WebGL 2": () => {
    const { getContext } = OffscreenCanvas.prototype;
    OffscreenCanvas.prototype.getContext = function without(kind, ...rest) {
      return kind === "webgl2" ? null : getContext.call(this, kind, ...rest);
    };
  },
  WebAssembly: () => delete globalThis.WebAssembly,
})) {
  test(`without ${what} the brush alone makes an outline`, async ({
    page,
    request,
    traffic,
    complaints,
  }) => {
    await page.addInitScript(without);
    const photo = await composed(page, request);
    await open(page, complaints);
    await choose(page, photo);
    await brushAlone(page);
    expect(traffic.heard.filter(({ url }) => /wasm|\.task/.test(url))).toEqual([]);
  });
}

for (const part of ["pose.task", "vision.wasm", "worker.js"]) {
  test(`where ${part} does not come, the brush makes an outline; the next photo asks again`, async ({
    page,
    request,
    traffic,
    complaints,
  }) => {
    complaints.expect(/ERR_EMPTY_RESPONSE|wasm|ArrayBuffer|Failed to load/i);
    const photo = await composed(page, request);
    await open(page, complaints);
    traffic.refused = new RegExp(part);
    await choose(page, photo);
    await brushAlone(page);
    traffic.refused = null;
    await choose(page, photo);
    await expect(status(page)).toHaveText(/This is your outline/, SLOWLY);
  });
}

test("where the network fails at a photo, the brush makes an outline", async ({
  page,
  request,
  complaints,
}) => {
  const photo = await composed(page, request);
  await open(page, complaints);
  await page.evaluate(() => {
    const { postMessage } = Worker.prototype;
    Worker.prototype.postMessage = function broken(message, ...rest) {
      // A picture that is closed already: the worker cannot draw it.
      message.picture?.close();
      return postMessage.call(this, { ...message, picture: undefined }, ...rest.map(() => []));
    };
  });
  await choose(page, photo);
  await brushAlone(page);
});
