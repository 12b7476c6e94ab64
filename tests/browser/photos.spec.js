/** Photos: from a file or the camera to an outline, mended by hand, compared, and never sent. */

import { writeFile } from "node:fs/promises";

import { launchOptions } from "./chromium.js";
import { carries, composed, elsewhere, listen, lyingOnItsSide, partsOf } from "./photos.js";
import { axe, enter, expect, pixels, tabTo, test as base } from "./site.js";

// The runtime says what it does as if it were an error.
const CHATTER = /XNNPACK/;

/** The photos that a test has shown to a page. */
const photos = [];

/**
 * Every page here is asked for through a server that hears all that is sent: the numbers and
 * outlines, and of no photo any part, however it is written.
 */
const test = base.extend({
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
const SLOWLY = { timeout: 120_000 };
test.setTimeout(300_000);

const card = (page, view = "front") => page.locator(`.view[data-view="${view}"]`);
const status = (page, view) => card(page, view).locator(".view-status");
const compare = (page) => page.locator("#comparison [type=submit]").click();

async function open(page, complaints) {
  complaints.expect(CHATTER);
  await enter(page);
  await page.goto("/compare");
  await expect(card(page).locator(".ways")).toBeVisible();
}

async function choose(page, buffer, view = "front", mimeType = "image/jpeg") {
  photos.push(buffer);
  const file = { name: "photo", mimeType, buffer };
  await page.locator(`#${view}-photo`).setInputFiles(file);
}

const found = (page, view) =>
  expect(card(page, view)).toHaveAttribute("data-state", "open", SLOWLY);

/** A drawing of somebody: light boxes on dark, each [left, top, width, height], as a PNG file. */
async function boxes(page, ...drawn) {
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
const uncovered = async (page, view = "front") =>
  Number(await card(page, view).locator(".sight").getAttribute("data-pixels"));

test("a photo becomes an outline and a comparison, and only the outline is sent", async ({
  page,
  request,
  traffic,
  complaints,
}) => {
  const taken = {
    front: await composed(page, request),
    profile: await composed(page, request, { side: "profile" }),
  };
  traffic.heard.length = 0; // what the test itself asked for
  await open(page, complaints);
  for (const view of ["front", "profile"]) {
    await choose(page, taken[view], view);
    await found(page, view);
    await expect(status(page, view)).toHaveText(/This is your outline/);
    await expect(card(page, view).locator("[data-finding]")).toHaveCount(0);
  }
  await compare(page);
  await expect(page.locator(".result .blend")).toHaveCount(2);
  await expect(page.locator(".result .blend").last()).toBeVisible();

  // The person of the photo is 6 cm more around the waist than the form's.
  for (const view of ["front", "profile"]) {
    const result = page.locator(`.result[data-view="${view}"]`);
    await expect(result.locator("canvas[data-picture=photo]")).toBeVisible();
    const cells = await result.locator("tr[data-measurement=waist_girth] td").allTextContents();
    expect(Number(cells[0])).toBeGreaterThan(Number(cells[1]) + 0.7);
    const common = await result.locator(".facts dd").first().textContent();
    expect(Number.parseFloat(common)).toBeGreaterThan(90);
  }
  await expect(page.locator("#results")).toBeFocused();
  expect(await axe(page)).toEqual([]);

  // What differs has its usual reasons beside it: the tape's where a girth was entered.
  for (const [name, words] of [
    ["waist_girth", "Usual reasons: Clothes, Breath, The tape"],
    ["abdomen_girth", "Usual reasons: An estimate, Clothes, Breath"],
  ]) {
    const why = page.locator(`.result tr[data-measurement=${name}] + .why`);
    await expect(why.first()).toHaveText(words);
  }

  // Wanted, the same outlines refine the body, and the page shows what changed.
  await page.getByLabel("Underwear, or clothes that fit close everywhere").check();
  await page.getByRole("button", { name: "Use my outline to refine the body" }).click();
  await expect(page.locator(".changes tbody tr").first()).toBeVisible(SLOWLY);
  await expect(page.locator(".result .blend").last()).toBeVisible();

  // Nothing goes elsewhere: `complaints` sees to that. What came here is read to the last byte.
  const addresses = traffic.heard.map(({ url }) => url.split("?")[0]);
  for (const part of ["worker.js", "vision.wasm", "pose.task"]) {
    expect(addresses).toContain(`/static/build/photos/${part}`);
  }
  const sent = traffic.heard.filter(({ method, body }) => method !== "GET" || body.length);
  expect(sent.map(({ method, url }) => `${method} ${url}`)).toEqual([
    "POST /numbers",
    "POST /compare",
    "POST /compare",
  ]);
  const fields = [
    ["csrf_token", null],
    ["worn", null],
    ["camera_distance", null],
    ["camera_height", null],
    ["front", "image/png"],
    ["profile", "image/png"],
  ];
  const [first, second] = sent.slice(1).map(partsOf);
  const kinds = (parts) => parts.map(({ name, type }) => [name, type]);
  expect(kinds(first)).toEqual(fields);
  expect(kinds(second)).toEqual([...fields, ["refine", null]]);
  const worn = (parts) => parts.find(({ name }) => name === "worn").content.toString();
  expect([worn(first), worn(second)]).toEqual(["", "tight"]);
  for (const { content, type } of [...first, ...second]) {
    if (!type) {
      expect(content.length).toBeLessThan(200);
      continue;
    }
    const { data } = await pixels(page, content);
    const colours = new Set();
    for (let i = 0; i < data.length; i += 4) {
      const [red, green, blue, alpha] = data.subarray(i, i + 4);
      colours.add(red === green && green === blue && alpha === 255 ? red : "coloured");
    }
    // Halved for looking at, an edge may be grey, but never has a hue.
    expect(colours).not.toContain("coloured");
    expect([...colours]).toEqual(expect.arrayContaining([0, 255]));
    expect(content.length).toBeLessThan(30_000);
    expect(content.includes("Exif")).toBe(false);
  }
  expect(traffic.heard.filter(({ url }) => /[?&](?!v=)/.test(url))).toEqual([]);
});

test("a photo that lay on its side is turned, and another one is suggested with the reasons", async ({
  page,
  request,
  complaints,
}) => {
  await open(page, complaints);
  // The person stands upright in the pixels; the camera says that it was held on its side.
  await choose(page, lyingOnItsSide(await composed(page, request)));
  await found(page);
  const canvas = card(page).locator("canvas");
  expect(await canvas.evaluate(({ width, height }) => [width, height])).toEqual([900, 600]);
  await expect(card(page).getByText("Another photo would give a better outline:")).toBeVisible();
  expect(await card(page).locator("[data-finding]").count()).toBeGreaterThan(0);
});

test("a WebP photo becomes an outline too", async ({ page, request, complaints }) => {
  const photo = await composed(page, request, { type: "image/webp" });
  expect(photo.toString("latin1", 8, 12)).toBe("WEBP");
  await open(page, complaints);
  await choose(page, photo, "front", "image/webp");
  await found(page);
  await expect(status(page)).toHaveText(/This is your outline/);
});

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

test("files that cannot be used, and outlines that are nobody's, are answered kindly", async ({
  page,
  complaints,
}) => {
  complaints.expect(/status of 422/);
  await open(page, complaints);
  const heic = Buffer.from("\0\0\0\x18ftypheic\0\0\0\0mif1heic", "latin1");
  await choose(page, heic, "front", "image/heic");
  await expect(status(page)).toHaveText(/HEIC photo, which this browser cannot read/);
  await choose(page, Buffer.from("<svg xmlns='http://www.w3.org/2000/svg'/>"), "front", "image/svg+xml");
  await expect(status(page)).toHaveText(/choose a JPEG, PNG or WebP/);
  const { buffer } = await boxes(page, [0, 0, 9, 9]);
  await choose(page, buffer.subarray(0, 60));
  await expect(status(page)).toHaveText(/seems to be damaged/);
  await page.locator("#front-outline").setInputFiles(await boxes(page, [0, 0, 300, 600]));
  await expect(status(page)).toHaveText(/nobody in that picture/);
  await expect(card(page).locator(".sight")).toBeHidden();

  const standing = [[100, 60, 100, 480], [130, 20, 40, 40]]; // prettier-ignore
  for (const [drawn, words] of [
    [[[20, 20, 60, 500], [220, 20, 60, 500]], /more than one person/],
    [[[100, 0, 100, 600]], /not all in the picture/],
    [[[140, 300, 20, 60]], /too small/],
    [[[10, 200, 280, 260]], /no outline of a standing person/],
  ]) { // prettier-ignore
    await page.locator("#profile-outline").setInputFiles(await boxes(page, ...drawn));
    await found(page, "profile");
    await compare(page);
    await expect(status(page, "profile")).toHaveText(words);
    await expect(status(page, "profile")).toHaveClass(/fault/);
    await expect(page.locator(".result")).toHaveCount(0);
  }
  await page.locator("#profile-outline").setInputFiles(await boxes(page, ...standing));
  await page.locator("#camera-distance").fill("near");
  await compare(page);
  await expect(page.locator("#camera-distance-fault")).toHaveText(/could not read this as a number/);
});

/** The photo is shown, nothing of it is the person's yet, and the brush paints. */
async function brushAlone(page) {
  await expect(status(page)).toHaveText(/Paint over yourself with the brush/, SLOWLY);
  await found(page);
  await expect(card(page).locator("[data-tool=add]")).toHaveAttribute("aria-pressed", "true");
  expect(await uncovered(page)).toBe(0);
  await card(page).locator("canvas").click();
  await expect.poll(() => uncovered(page)).toBeGreaterThan(0);
}

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

for (const [policy, words] of [
  [true, "page and worker can ask no other site"],
  [false, "but for their policy, page and worker could ask another site"],
]) {
  test(words, async ({ page, request, traffic, complaints }) => {
    complaints.expect(/another origin|Content Security Policy|Failed to load|ERR_|StartGraph/);
    traffic.policy = policy;
    const other = await elsewhere();
    const photo = await composed(page, request);
    await open(page, complaints);
    await page.locator("#comparison").evaluate((form, url) => {
      form.dataset.model = url; // the worker asks for its network there
    }, `${other.url}/worker`);
    await choose(page, photo);
    await brushAlone(page);
    const asked = (url) => fetch(url).then(({ status }) => status, () => "refused"); // prettier-ignore
    expect(await page.evaluate(asked, `${other.url}/page`)).toBe(policy ? "refused" : 204);
    expect(other.heard).toEqual(policy ? [] : ["/worker", "/page"]);
    await other.close();
  });
}

test.describe("without scripts", () => {
  test.use({ javaScriptEnabled: false });

  test("an outline made elsewhere is compared all the same", async ({ page, request }) => {
    await enter(page);
    const outline = await request.post("/api/v1/avatars/front.png", {
      data: { body: "female", measurements: { stature: 168, waist_girth: 82 }, silhouette: true },
    });
    await page.goto("/compare");
    await expect(page.locator(".ways").first()).toBeHidden();
    await page.locator("#front-outline").setInputFiles({
      name: "outline.png",
      mimeType: "image/png",
      buffer: await outline.body(),
    });
    await compare(page);
    await expect(page.locator(".result img:visible")).toHaveCount(3);
    await expect(page.locator("tr[data-measurement=waist_girth] td").first()).toHaveText(/^\d+\.\d$/);
  });
});

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
