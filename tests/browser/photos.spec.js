/** Photos: from a file to an outline, compared, and never sent. */

import { composed, elsewhere, lyingOnItsSide, partsOf } from "./photos.js";
import { SLOWLY, boxes, brushAlone, card, choose, compare, found, open, status, test } from "./photos_page.js";
import { axe, enter, expect, pixels } from "./site.js";

test.setTimeout(300_000);

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
  await expect(page.locator(".result .blend")).toHaveCount(2, SLOWLY);
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

  const standing = [[100, 60, 100, 480], [130, 20, 40, 40]];
  for (const [drawn, words] of [
    [[[20, 20, 60, 500], [220, 20, 60, 500]], /more than one person/],
    [[[100, 0, 100, 600]], /not all in the picture/],
    [[[140, 300, 20, 60]], /too small/],
    [[[10, 200, 280, 260]], /no outline of a standing person/],
  ]) {
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
    const asked = (url) => fetch(url).then(({ status }) => status, () => "refused");
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
