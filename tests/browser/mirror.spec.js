/** The body that follows the numbers: at once from the page, exactly from the server. */

import { readGlb } from "../../static/glb.js";
import { REGIONS } from "../../static/regions.js";
import { WOMAN, difference, enter, expect, look, openAvatar, pixels, ready, test } from "./site.js";

test.use({ viewport: { width: 700, height: 560 } });

const field = (page, name) => page.locator(`#edit-${name}`);
const say = (page) => page.locator("#editor [role=status]");

/** The avatar's page, once it knows how the body bends. */
async function openLive(page, person = WOMAN) {
  await openAvatar(page, person);
  await expect(page.locator("#viewer[data-learned]")).toHaveCount(1, { timeout: 30_000 });
}

/** Do something with the viewer in the page. */
async function inViewer(page, work, given) {
  const viewer = await page.evaluateHandle(() => document.querySelector("#viewer").viewer);
  return viewer.evaluate(work, given);
}

const vertices = (page) => inViewer(page, (viewer) => Array.from(viewer.vertices));

function farthest(one, other) {
  let most = 0;
  for (let i = 0; i < one.length; i += 3) {
    const apart = Math.hypot(...[0, 1, 2].map((k) => one[i + k] - other[i + k]));
    most = Math.max(most, apart);
  }
  return most;
}

const changed = (page, name, value) =>
  Promise.all([
    page.waitForResponse((answer) => answer.request().method() === "POST" && answer.ok()),
    page.waitForResponse((answer) => answer.url().endsWith("/avatar.glb")),
    field(page, name).fill(value),
  ]);

test("a change shows at once, is kept, and the page tells what the API tells", async ({ page }) => {
  await openLive(page);
  const before = await look(page);
  await changed(page, "waist_girth", "84");
  await expect(say(page)).toHaveText("It measures what you typed.");
  await expect.poll(() => inViewer(page, (viewer) => viewer.hasGhost), { timeout: 20_000 }).toBe(false);
  await page.locator("#editor-title").click();
  expect(difference(before, await look(page))).toBeGreaterThan(0.005);

  const { measurements } = await page.evaluate(() => fetch("/avatar.json").then((a) => a.json()));
  expect(measurements.find(({ name }) => name === "waist_girth").asked).toBe(84);
  const rows = await page.locator("tr[data-measurement]").evaluateAll((all) =>
    all.map((row) => [
      row.dataset.measurement,
      [...row.querySelectorAll("td")].map((cell) => cell.textContent.trim()),
    ]),
  );
  expect(rows).toHaveLength(measurements.length);
  for (const [name, texts] of rows) {
    const { asked, taken, low, high } = measurements.find((row) => row.name === name);
    const tenth = (value) => value.toFixed(1);
    if (asked === null) expect(texts).toEqual([tenth(taken), `${tenth(low)} to ${tenth(high)}`]);
    else expect(texts.slice(0, 2)).toEqual([tenth(asked), tenth(taken)]);
  }
  await page.reload();
  await expect(page.locator('tr[data-measurement="waist_girth"] td').first()).toHaveText("84.0");
});

test("the preview is the linear law, to half a millimetre", async ({ page, request }) => {
  await openLive(page);
  const before = await vertices(page);
  const change = { stature: 0.03, waist_girth: 0.06, bust_girth: -0.02 };
  await inViewer(page, (viewer, given) => viewer.bend(given), change);
  await expect.poll(async () => farthest(await vertices(page), before)).toBeGreaterThan(0.005);
  const after = await vertices(page);

  const { body, ...typed } = WOMAN;
  const linear = async (changes) => {
    const measurements = Object.fromEntries(
      Object.entries(typed).map(([name, text]) => [name, Number(text) + 100 * (changes[name] ?? 0)]),
    );
    const answer = await request.post("/api/v1/avatars.glb", {
      data: { body, measurements, fit: "linear" },
    });
    const file = await answer.body();
    return readGlb(file.buffer.slice(file.byteOffset, file.byteOffset + file.length)).positions;
  };
  const [from, to] = [await linear({}), await linear(change)];
  const moved = to.map((value, i) => value - from[i]);
  const shown = after.map((value, i) => value - before[i]);
  expect(farthest(shown, moved)).toBeLessThan(0.0005);
});

test("the server's body takes over without a jump, and is then shown to the last bit", async ({
  page,
  request,
}) => {
  await openLive(page);
  // The largest move of a point between two frames, while the body goes over.
  await inViewer(page, (viewer) => {
    window.jumps = [];
    let last = viewer.vertices.slice();
    document.querySelector("#viewer").addEventListener("frame", () => {
      const now = viewer.vertices;
      let most = 0;
      for (let i = 0; i < now.length; i += 1) most = Math.max(most, Math.abs(now[i] - last[i]));
      window.jumps.push(most);
      last = now.slice();
    });
  });
  await changed(page, "waist_girth", "80");
  await expect(say(page)).not.toHaveText("");
  await page.waitForTimeout(1000);
  const jumps = await page.evaluate(() => window.jumps);
  const [bend, ...rest] = jumps.filter((jump) => jump > 0);
  expect(bend).toBeGreaterThan(0.003);
  for (const jump of rest) expect(jump).toBeLessThan(0.5 * bend);

  const file = await page.evaluate(async () => {
    const answer = await fetch("/avatar.glb");
    return Array.from(new Uint8Array(await answer.arrayBuffer()));
  });
  const served = readGlb(Uint8Array.from(file).buffer).positions;
  expect(farthest(await vertices(page), served)).toBeLessThan(1e-6);
  await request.dispose();
});

test("a value that cannot be is said at its field, and the body stays", async ({
  page,
  complaints,
}) => {
  complaints.expect(/422/);
  await openLive(page);
  const before = await vertices(page);
  await field(page, "waist_girth").fill("400");
  const note = page.locator("#edit-waist_girth-note");
  await expect(note).toContainText("We can work with");
  await expect(field(page, "waist_girth")).toHaveAttribute("aria-invalid", "true");
  expect(farthest(await vertices(page), before)).toBe(0);
  await field(page, "waist_girth").press("ArrowDown"); // back among what can be
  await expect(field(page, "waist_girth")).not.toHaveValue("400");
  await expect(note).not.toContainText("We can work with");
});

test("two hundred changes leave no memory behind", async ({ page }) => {
  await openLive(page);
  const devtools = await page.context().newCDPSession(page);
  const heap = async () => {
    await devtools.send("HeapProfiler.collectGarbage");
    return (await devtools.send("Runtime.getHeapUsage")).usedSize;
  };
  const change = (count) =>
    inViewer(
      page,
      async (viewer, times) => {
        for (let i = 0; i < times; i += 1) {
          if (i % 20 === 0) {
            viewer.fadeGhost();
            viewer.keepGhost();
          }
          if (i % 50 === 49) await viewer.load("/avatar.glb");
          viewer.bend({ waist_girth: ((i % 10) - 5) / 200, stature: (i % 7) / 100 });
          await new Promise((resolve) => setTimeout(resolve, 0));
        }
        viewer.bend({});
      },
      count,
    );
  await change(50);
  await look(page);
  const [memory, bytes] = [await inViewer(page, (viewer) => viewer.memory), await heap()];
  await change(200);
  await look(page);
  expect(await inViewer(page, (viewer) => viewer.memory)).toEqual(memory);
  expect((await heap()) - bytes).toBeLessThan(1e6);
  const { bends, triangles, drawCalls } = await inViewer(page, (viewer) => viewer.stats);
  expect(bends).toBeGreaterThanOrEqual(250);
  expect(triangles).toBeLessThan(2 * 70_000);
  expect(drawCalls).toBeLessThan(10);
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

test("beside the pictures the body has their camera and their scale", async ({ page }) => {
  await page.setViewportSize({ width: 1280, height: 1000 });
  await openAvatar(page);
  await page.locator('[data-switch="beside"]').click();
  for (const [view, side] of [["front", "front"], ["side", "profile"]]) {
    await page.locator(`[data-view="${view}"]`).click();
    const shown = span(await look(page));
    const still = page.locator(`figure img[data-side="${side}"]`);
    await still.scrollIntoViewIfNeeded();
    const picture = span(await pixels(page, await still.screenshot()));
    expect(Math.abs(shown.height / picture.height - 1)).toBeLessThan(0.015);
    expect(Math.abs(shown.width / picture.width - 1)).toBeLessThan(0.03);
  }
});

for (const size of [{ width: 1000, height: 800 }, { width: 360, height: 740 }]) {
  test(`the body in 3D takes the still picture's place unnoticed, ${size.width} wide`, async ({ page }) => {
    await page.setViewportSize(size);
    await enter(page);
    const still = page.locator("#viewer img");
    await expect(still).toBeVisible();
    await expect.poll(() => still.evaluate((image) => image.complete)).toBe(true);
    const before = span(await pixels(page, await page.locator("#viewer").screenshot()));
    await ready(page);
    const after = span(await look(page));
    expect(before.height).toBeGreaterThan(100);
    expect(Math.abs(before.height / after.height - 1)).toBeLessThan(0.03);
    expect(Math.abs(before.width / after.width - 1)).toBeLessThan(0.04);
  });
}

/** How far a picture's body reaches: skin and cloth are far from the greys of the backdrop. */
function span({ width, height, data }) {
  const [rows, columns] = [new Set(), new Set()];
  for (let y = 4; y < height - 4; y += 1) {
    for (let x = 4; x < width - 4; x += 1) {
      const at = 4 * (y * width + x);
      if (Math.abs(data[at] - data[at + 2]) < 14) continue;
      rows.add(y);
      columns.add(x);
    }
  }
  const reach = (set) => Math.max(...set) - Math.min(...set);
  return { height: reach(rows), width: reach(columns) };
}
