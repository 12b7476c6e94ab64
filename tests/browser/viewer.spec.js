/** The body in 3D: what it shows, what moves it, and what stands in when it cannot be. */

import { REGIONS } from "../../static/regions.js";
import { difference, drawn, enter, expect, look, openAvatar, ready, test } from "./site.js";

// Small, since every picture is drawn and compared without a graphics card; and where views end, not
// how they are come by: a turn's own pictures would be drawn one by one.
test.use({ viewport: { width: 700, height: 560 }, contextOptions: { reducedMotion: "reduce" } });

const view = (page, name) => page.locator(`button[data-view="${name}"]`);
const canvas = (page) => page.locator("#viewer canvas");

/** Count what is drawn, from before the page's own scripts run. */
async function countDrawing(page) {
  await page.addInitScript(() => {
    window.drawCalls = 0;
    const { drawElements } = WebGL2RenderingContext.prototype;
    WebGL2RenderingContext.prototype.drawElements = function count(...values) {
      window.drawCalls += 1;
      return drawElements.apply(this, values);
    };
  });
  return () => page.evaluate(() => window.drawCalls);
}

test("front, side and back are three different pictures of a body", async ({ page }) => {
  await openAvatar(page);
  const pictures = [];
  for (const name of ["front", "side", "back"]) {
    await view(page, name).click();
    pictures.push(await look(page));
    await expect(view(page, name)).toHaveAttribute("aria-pressed", "true");
    await expect(page.locator('[data-view][aria-pressed="true"]')).toHaveCount(1);
  }
  for (const picture of pictures) expect(drawn(picture)).toBeGreaterThan(0.05);
  const [front, side, back] = pictures;
  expect(difference(front, side)).toBeGreaterThan(0.03);
  expect(difference(side, back)).toBeGreaterThan(0.03);
  expect(difference(front, back)).toBeGreaterThan(0.005);
});

test("without a graphics processor the body in 3D waits for the reader's touch", async ({ page }) => {
  const files = [];
  page.on("request", (request) => request.url().includes(".glb") && files.push(request.url()));
  await enter(page);
  await page.waitForTimeout(4000); // twice the rest after which it comes where one draws
  expect(files).toEqual([]);
  await ready(page);
  // How it bends comes by itself a moment later.
  expect(files.filter((file) => !file.includes("live="))).toHaveLength(1);
});

test("where a graphics processor draws the body in 3D comes by itself", async ({ page }) => {
  await page.route("**/renderer.js*", async (route) => {
    const response = await route.fetch();
    const script = await response.text();
    await route.fulfill({ response, body: script.replace("SOFTWARE.test", "/a card/.test") });
  });
  await enter(page);
  await expect(page.locator("#viewer")).toHaveAttribute("data-state", "ready", { timeout: 60_000 });
});

test("the keys do what the buttons do", async ({ page }) => {
  await openAvatar(page);
  const byButton = {};
  for (const name of ["side", "back", "front"]) {
    await view(page, name).click();
    byButton[name] = await look(page);
  }
  await canvas(page).focus();
  const focused = await look(page); // with the mark of the focus
  expect(difference(focused, byButton.front)).toBeLessThan(0.03);
  for (const [key, name] of [["3", "side"], ["4", "back"], ["1", "front"]]) {
    await page.keyboard.press(key);
    expect(difference(await look(page), byButton[name])).toBeLessThan(0.03);
  }
  await page.keyboard.press("ArrowRight");
  expect(difference(await look(page), focused)).toBeGreaterThan(0.01);
  await expect(page.locator('[data-view][aria-pressed="true"]')).toHaveCount(0);
  await page.keyboard.press("1");
  await page.keyboard.press("+");
  const near = await look(page);
  expect(drawn(near)).toBeGreaterThan(1.1 * drawn(focused));
  await page.keyboard.press("-");
  expect(difference(await look(page), focused)).toBeLessThan(0.005);
  await page.keyboard.press("PageUp");
  expect(difference(await look(page), focused)).toBeGreaterThan(0.03);
  await page.keyboard.press("PageDown");
  expect(difference(await look(page), focused)).toBeLessThan(0.005);
});

test("dragging and the zoom buttons move the body", async ({ page }) => {
  await openAvatar(page);
  const front = await look(page);
  const box = await canvas(page).boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + 200);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2 + 120, box.y + 200, { steps: 6 });
  await page.mouse.up();
  const turned = await look(page);
  expect(difference(front, turned)).toBeGreaterThan(0.02);
  await page.locator('[data-zoom="in"]').click();
  const near = await look(page);
  expect(drawn(near)).toBeGreaterThan(1.1 * drawn(turned));
  await page.locator('[data-zoom="out"]').click();
  expect(drawn(await look(page))).toBeCloseTo(drawn(turned), 2);
});

test("panning slides along the body and never off it", async ({ page }) => {
  await openAvatar(page);
  const front = await look(page);
  const { x, y, width, height } = await canvas(page).boundingBox();
  const drag = async (right, down) => {
    await page.mouse.move(x + width / 2, y + height / 2);
    await page.mouse.down({ button: "right" });
    await page.mouse.move(x + width / 2 + right, y + height / 2 + down, { steps: 5 });
    await page.mouse.up({ button: "right" });
  };
  await drag(150, 0);
  expect(difference(await look(page), front)).toBeLessThan(0.005);
  await drag(0, 100);
  expect(difference(await look(page), front)).toBeGreaterThan(0.03);
});

test("the wheel scrolls the page until the body is chosen, and zooms then", async ({ page }) => {
  await page.setViewportSize({ width: 1000, height: 600 });
  await openAvatar(page);
  await canvas(page).scrollIntoViewIfNeeded();
  await canvas(page).hover();
  const top = () => page.evaluate(() => window.scrollY);
  const before = await top();
  await page.mouse.wheel(0, 150);
  await expect.poll(top).toBeGreaterThan(before);
  await canvas(page).focus();
  await canvas(page).hover();
  const picture = await look(page);
  const still = await top();
  await page.mouse.wheel(0, -300);
  expect(difference(await look(page), picture)).toBeGreaterThan(0.02);
  // A page that the wheel had scrolled would be at its top; an earlier motion may still settle.
  expect(still).toBeGreaterThan(80);
  expect(Math.abs((await top()) - still)).toBeLessThan(40);
});

test.describe("on a telephone", () => {
  test.use({ viewport: { width: 360, height: 740 }, hasTouch: true, isMobile: true });

  test("a thumb turns the body, two fingers bring it closer", async ({ page }) => {
    await openAvatar(page);
    const fingers = await page.context().newCDPSession(page);
    const touch = (type, ...points) =>
      fingers.send("Input.dispatchTouchEvent", {
        type,
        touchPoints: points.map(([x, y], id) => ({ x, y, id })),
      });
    await canvas(page).scrollIntoViewIfNeeded();
    const { x, y, width } = await canvas(page).boundingBox();
    const [middle, level] = [x + width / 2, y + 150];

    const front = await look(page);
    await touch("touchStart", [middle, level]);
    for (let step = 1; step <= 6; step += 1) await touch("touchMove", [middle + 15 * step, level]);
    await touch("touchEnd");
    const turned = await look(page);
    expect(difference(front, turned)).toBeGreaterThan(0.02);

    await touch("touchStart", [middle - 20, level], [middle + 20, level]);
    for (let step = 1; step <= 6; step += 1) {
      await touch("touchMove", [middle - 20 - 8 * step, level], [middle + 20 + 8 * step, level]);
    }
    await touch("touchEnd");
    expect(drawn(await look(page))).toBeGreaterThan(1.1 * drawn(turned));
  });
});

test("a turn ends, and nothing is drawn while nothing changes", async ({ page }) => {
  await page.emulateMedia({ reducedMotion: "no-preference" });
  const drawCalls = await countDrawing(page);
  await openAvatar(page);
  await view(page, "side").click();
  await look(page);
  const before = await drawCalls();
  expect(before).toBeGreaterThan(0);
  await page.waitForTimeout(1000);
  expect(await drawCalls()).toBe(before);
});

test("who wants little motion sees the view at once", async ({ page }) => {
  const drawCalls = await countDrawing(page);
  await openAvatar(page);
  await page.waitForTimeout(1500); // what comes after the body is drawn by then
  const before = await drawCalls();
  await view(page, "back").click();
  await page.waitForTimeout(500);
  const parts = 3; // skin, garment, shadow
  expect(await drawCalls()).toBeLessThanOrEqual(before + 2 * parts);
  expect(await drawCalls()).toBeGreaterThan(before);
});

test("the view follows the size of the window", async ({ page }) => {
  await openAvatar(page);
  for (const width of [1400, 500]) {
    await page.setViewportSize({ width, height: 900 });
    const picture = await look(page);
    expect(drawn(picture)).toBeGreaterThan(0.05);
    const box = await canvas(page).boundingBox();
    const buffer = await canvas(page).evaluate((c) => [c.width, c.height]);
    expect(buffer[0]).toBeCloseTo(box.width, -1);
    expect(buffer[1]).toBeCloseTo(box.height, -1);
  }
});

test("without WebGL the still picture stays, and it is said", async ({ page, complaints }) => {
  await page.addInitScript(() => {
    HTMLCanvasElement.prototype.getContext = () => null;
  });
  await openAvatarWithoutViewer(page);
  await expect(page.locator("#viewer img")).toBeVisible();
  await expect(page.getByRole("status").filter({ hasText: "3D" })).toContainText("not available");
  await expect(view(page, "front")).toBeHidden();
  complaints.expect(/WebGL/); // three.js's own
});

test("without the file the still picture stays, and it is said", async ({ page, complaints }) => {
  await page.route("**/*.glb", (route) => route.fulfill({ status: 503, body: "" }));
  await openAvatarWithoutViewer(page);
  await expect(page.locator("#viewer img")).toBeVisible();
  await expect(page.getByRole("status").filter({ hasText: "3D" })).toContainText("not available");
  complaints.expect(/status of 503/); // the answer's own
});

test("while the graphics context is lost the still picture is back", async ({ page }) => {
  await openAvatar(page);
  const lose = await canvas(page).evaluateHandle((element) =>
    element.getContext("webgl2").getExtension("WEBGL_lose_context"),
  );
  await lose.evaluate((extension) => extension.loseContext());
  await expect(page.locator("#viewer")).toHaveAttribute("data-state", "failed");
  await expect(page.locator("#viewer img")).toBeVisible();
  await lose.evaluate((extension) => extension.restoreContext());
  await ready(page);
  expect(drawn(await look(page))).toBeGreaterThan(0.06);
});

test("of two files asked for at once, the later one is shown", async ({ page }) => {
  await openAvatar(page);
  const body = await look(page);
  const glb = await page.locator("#viewer").getAttribute("data-glb");
  let release;
  const held = new Promise((resolve) => {
    release = resolve;
  });
  await page.route("**/slow.glb", async (route) => {
    await held;
    await route.fulfill({ status: 404, body: "" }).catch(() => {});
  });
  await page.evaluate(async (url) => {
    const { viewer } = document.querySelector("#viewer");
    const slow = viewer.load("/slow.glb");
    await viewer.load(url);
    await slow;
  }, glb);
  release();
  await ready(page);
  expect(difference(await look(page), body)).toBeLessThan(0.001);
});

test("a body that is replaced gives its memory back, and a closed viewer the still picture", async ({
  page,
}) => {
  await page.addInitScript(() => {
    window.held = 0;
    const { prototype } = WebGL2RenderingContext;
    for (const kind of ["Buffer", "Texture", "VertexArray", "Program"]) {
      for (const [verb, step] of [["create", 1], ["delete", -1]]) {
        const original = prototype[verb + kind];
        prototype[verb + kind] = function count(...values) {
          window.held += step;
          return original.apply(this, values);
        };
      }
    }
  });
  await openAvatar(page);
  await look(page);
  const held = () => page.evaluate(() => window.held);
  const reload = () =>
    page.evaluate(() => {
      const element = document.querySelector("#viewer");
      return element.viewer.load(element.dataset.glb);
    });
  await reload();
  await look(page);
  const before = await held();
  expect(before).toBeGreaterThan(0);
  for (let i = 0; i < 5; i += 1) await reload();
  await look(page);
  expect(await held()).toBe(before);

  await page.evaluate(() => document.querySelector("#viewer").viewer.dispose());
  await expect(canvas(page)).toHaveCount(0);
  await expect(page.locator("#viewer img")).toBeVisible();
});

async function openAvatarWithoutViewer(page) {
  await enter(page);
  await ready(page, "failed");
}

test("skin has the tone that is chosen, and a ruler stands beside the body", async ({ page }) => {
  await openAvatar(page);
  const before = await look(page);
  await page.locator('#tones input[value="tone6"]').check({ force: true });
  expect(difference(before, await look(page))).toBeGreaterThan(0.03);
  await page.locator('[data-switch="ruler"]').click();
  const texts = page.locator("#viewer .ruler text");
  await expect(page.locator("#viewer .ruler .crown")).toHaveText("168.0 cm");
  expect((await texts.allTextContents()).filter((text) => /^\d+$/.test(text))).toEqual(
    ["0", "20", "40", "60", "80", "100", "120", "140", "160"],
  );
});

test("the tapes of a region are named with the API's values, and a row shows its own", async ({
  page,
}) => {
  await openAvatar(page);
  const { measurements } = await page.evaluate(() => fetch("/avatar.json").then((a) => a.json()));
  const labels = page.locator(".tape-label");
  for (const region of ["around", "legs"]) {
    await page.locator(`button[data-region="${region}"]`).click();
    await expect(labels).toHaveCount(REGIONS[region].length);
    for (const name of REGIONS[region]) {
      const { taken, low, high, asked } = measurements.find((row) => row.name === name);
      const note = asked === null ? `${low.toFixed(1)} to ${high.toFixed(1)}` : "entered";
      const label = page.locator(`.tape-label[data-tape="${name}"]`);
      await expect(label.locator(".tape-value")).toHaveText(`${taken.toFixed(1)} cm`);
      await expect(label.locator(".tape-note")).toHaveText(note);
    }
  }
  await page.locator('button[data-region=""]').click();
  await expect(labels).toHaveCount(0);
  const without = await look(page);
  const row = page.getByRole("button", { name: "Waist", exact: true });
  await row.click();
  await expect(labels).toHaveCount(1);
  expect(difference(await look(page), without)).toBeGreaterThan(0.001);
  await row.click();
  await expect(labels).toHaveCount(0);
});
