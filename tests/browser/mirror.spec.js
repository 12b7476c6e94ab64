/** The body that follows the numbers: at once from the page, exactly from the server. */

import { readGlb } from "../../static/glb.js";
import { REGIONS } from "../../static/regions.js";
import {
  WOMAN,
  changed,
  difference,
  enter,
  expect,
  field,
  inViewer,
  look,
  openAvatar,
  ready,
  test,
} from "./site.js";

// As in viewer.spec.js; a test of what moves says so.
test.use({ viewport: { width: 700, height: 560 }, contextOptions: { reducedMotion: "reduce" } });

const withMotion = (page) => page.emulateMedia({ reducedMotion: "no-preference" });

const say = (page) => page.locator("#editor [role=status]");

/** The avatar's page, once it knows how the body bends. */
async function openLive(page, person = WOMAN) {
  await openAvatar(page, person);
  await expect(page.locator("#viewer[data-learned]")).toHaveCount(1, { timeout: 30_000 });
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

test("a change shows at once, is kept, and the page tells what the API tells", async ({ page }) => {
  await openLive(page);
  const before = await look(page);
  await changed(page, "waist_girth", "84");
  await expect(say(page)).toHaveText("It measures what you typed.");
  await expect.poll(() => inViewer(page, (viewer) => viewer.hasGhost), { timeout: 20_000 }).toBe(false);
  // Without a tape or words over it, what differs is the body.
  await page.locator('button[data-region=""]').click();
  await expect(page.locator(".tape-label")).toHaveCount(0);
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

test("a value typed while the first body is on its way bends it once it is there", async ({ page }) => {
  const warnings = [];
  page.on("console", (message) => warnings.push(message.text()));
  await enter(page);
  let asked = 0;
  const first = new Promise((resolve) => {
    page.route("**/avatar.glb", async (route) => {
      asked += 1;
      if (asked === 1) await new Promise((release) => resolve(release));
      await route.continue().catch(() => {}); // by then nobody waits for the first
    });
  });
  await expect(async () => {
    await page.locator("#viewer").dispatchEvent("pointermove");
    expect(asked).toBe(1);
  }).toPass();
  await changed(page, "waist_girth", "84");
  await expect(page.locator("#viewer[data-learned]")).toHaveCount(1, { timeout: 30_000 });
  (await first)();
  await expect(page.locator('.tape-label[data-tape="waist_girth"]')).toContainText("84.0 cm");
  const before = await vertices(page);
  await field(page, "waist_girth").fill("74");
  await expect.poll(async () => farthest(await vertices(page), before)).toBeGreaterThan(0.003);
  await expectStage(page);
  expect(warnings.filter((text) => /null|undefined/.test(text))).toEqual([]);
});

test("where the first body did not come, the one of the next change brings the page to life", async ({
  page,
  complaints,
}) => {
  complaints.expect(/status of 503/);
  await page.route("**/avatar.glb", (route) => route.fulfill({ status: 503, body: "" }), { times: 1 });
  await enter(page);
  await ready(page, "failed");
  await changed(page, "waist_girth", "84");
  await expect(page.locator("#viewer[data-learned]")).toHaveCount(1, { timeout: 30_000 });
  await expectStage(page);
});

/** The buttons around the body do what they say. */
async function expectStage(page) {
  await page.locator('[data-view="back"]').click();
  await expect(page.locator('[data-view="back"]')).toHaveAttribute("aria-pressed", "true");
  await page.locator('button[data-region="legs"]').click();
  await expect(page.locator(".tape-label")).toHaveCount(REGIONS.legs.length);
}

test("the first touch may be a field: its tape is shown with the body", async ({ page }) => {
  await enter(page);
  await expect(field(page, "hip_girth")).toBeVisible();
  await expect(async () => {
    await field(page, "hip_girth").blur();
    await field(page, "hip_girth").focus();
    await expect(page.locator("#viewer")).toHaveAttribute("data-state", "ready", { timeout: 5000 });
  }).toPass({ timeout: 60_000 });
  await expect(page.locator(".tape-label")).toHaveAttribute("data-tape", "hip_girth");
  // While a region is shown, a field brings no tape, and marks no row as if it had.
  await page.locator('button[data-region="arms"]').click();
  await field(page, "waist_girth").focus();
  await expect(page.locator(".tape-label")).toHaveCount(REGIONS.arms.length);
  await expect(page.locator('.row-tape[aria-pressed="true"]')).toHaveCount(0);
});

test("the outline of the body before is seen, and goes however a change is answered", async ({
  page,
  complaints,
}) => {
  await withMotion(page);
  await openLive(page);
  const hasGhost = () => inViewer(page, (viewer) => viewer.hasGhost);
  const type = (...texts) =>
    field(page, "waist_girth").evaluate((input, all) => {
      for (const text of all) {
        input.value = text;
        input.dispatchEvent(new Event("input", { bubbles: true }));
      }
    }, texts);
  const goes = async () => {
    expect(await hasGhost()).toBe(true);
    await expect.poll(hasGhost, { timeout: 20_000 }).toBe(false);
  };
  // Wanted, it stays; and while it fades, another change keeps another.
  await page.locator('[data-switch="before"]').click();
  await changed(page, "waist_girth", "84");
  const beside = await look(page);
  await page.locator('[data-switch="before"]').click();
  expect(difference(beside, await look(page))).toBeGreaterThan(0.003);
  await inViewer(page, (viewer) => viewer.keepGhost());
  await inViewer(page, (viewer) => viewer.fadeGhost());
  await type("80");
  await page.waitForTimeout(1200);
  await goes();
  // Refused, or not answered at all.
  complaints.expect(/422|ERR_FAILED/);
  await type("84", "400");
  await goes();
  await page.route("**/avatar.json", (route) => route.abort());
  await type("82");
  await goes();
});

test("what is said over the body is of the body that is shown", async ({ page }) => {
  await openLive(page);
  const more = page.locator('.opening a[href="#numbers"]');
  await expect(more).toHaveText("The numbers tell the rest.");
  await changed(page, "waist_girth", "130");
  await expect(page.locator("#verdict")).toContainText("does not seem to go together");
  await expect(more).toHaveText("The numbers say by how much they differ.");
  await changed(page, "waist_girth", "74");
  await expect(more).toHaveText("The numbers tell the rest.");
});

test("what is said of an outline goes with the first change, as its say does", async ({ page }) => {
  await enter(page);
  const { body, ...typed } = WOMAN;
  const measurements = Object.fromEntries(
    Object.entries(typed).map(([name, text]) => [name, Number(text)]),
  );
  const outline = await page.request.post("/api/v1/avatars/front.png", {
    data: { body, measurements: { ...measurements, waist_girth: 82 }, silhouette: true },
  });
  const csrf_token = await page.locator("#editor [name=csrf_token]").inputValue();
  const front = { name: "front.png", mimeType: "image/png", buffer: await outline.body() };
  const answer = await page.request.post("/compare", {
    headers: { Accept: "application/json" },
    multipart: { csrf_token, front, refine: "1" },
  });
  const { refinement } = await answer.json();
  await page.request.post("/compare/body", { form: { csrf_token, refined: refinement.take } });
  await page.reload();
  await ready(page);
  await expect(page.locator(".refined")).toBeVisible();
  await changed(page, "waist_girth", "76");
  await expect(page.locator(".refined")).toHaveCount(0);
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

test("the server's body takes over without a jump, and is then shown to the last bit", async ({ page }) => {
  await withMotion(page);
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
  expect(rest).not.toHaveLength(0);
  for (const jump of rest) expect(jump).toBeLessThan(0.5 * bend);

  const file = await page.evaluate(async () => {
    const answer = await fetch("/avatar.glb");
    return Array.from(new Uint8Array(await answer.arrayBuffer()));
  });
  const served = readGlb(Uint8Array.from(file).buffer).positions;
  expect(farthest(await vertices(page), served)).toBeLessThan(1e-6);
});

test("a body that grows stays in the frame before the server's comes", async ({ page }) => {
  await openLive(page);
  let held = null; // while a height is dragged, what the server is told waits
  await page.route("**/avatar.json", async (route) => {
    await held;
    await route.continue();
  });
  /** Of each picture of a drag from 168 cm to 200: where crown and soles are seen. */
  const drag = async () => {
    let release;
    held = new Promise((resolve) => {
      release = resolve;
    });
    const seen = await inViewer(page, async (viewer) => {
      const element = document.querySelector("#viewer");
      const input = document.querySelector("#edit-stature");
      const pictures = [];
      for (let stature = 168; stature <= 200; stature += 2) {
        const drawn = new Promise((resolve) => {
          element.addEventListener("frame", resolve, { once: true });
        });
        input.value = String(stature);
        input.dispatchEvent(new Event("input", { bubbles: true }));
        await drawn;
        const heights = viewer.vertices.filter((_, i) => i % 3 === 1);
        const [crown, soles] = [Math.max(...heights), Math.min(...heights)];
        pictures.push([crown, soles].map((y) => viewer.see([0, y, 0]).y));
      }
      return pictures;
    });
    const answered = page.waitForResponse((answer) => answer.url().endsWith("/avatar.glb"));
    release();
    await answered;
    return seen;
  };
  const bottom = await page.locator("#viewer").evaluate(({ clientHeight }) => clientHeight);
  const expectInside = (seen) => {
    seen.forEach(([crown, soles], i) => {
      expect(crown).toBeGreaterThan(0);
      expect(soles).toBeLessThan(bottom);
      const before = seen[Math.max(0, i - 1)];
      expect(Math.abs(crown - before[0])).toBeLessThan(0.015 * bottom);
      expect(Math.abs(soles - before[1])).toBeLessThan(0.015 * bottom);
    });
  };
  expectInside(await drag());
  await changed(page, "stature", "168");
  await page.locator("#viewer canvas").press("ArrowRight"); // from where no button stands
  await look(page);
  expectInside(await drag());
  // Who has come nearer keeps what is looked at.
  await changed(page, "stature", "168");
  await page.locator('[data-view="front"]').click();
  await page.locator('[data-zoom="in"]').click();
  await look(page);
  const near = await drag();
  expect(near.at(-1)[0]).toBeLessThan(-0.1 * bottom);
  expect(near.at(-1)[1]).toBeCloseTo(near[0][1], 0);
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
  await page.locator('button[data-region="around"]').click();
  const devtools = await page.context().newCDPSession(page);
  const heap = async () => {
    await devtools.send("HeapProfiler.collectGarbage");
    return (await devtools.send("Runtime.getHeapUsage")).usedSize;
  };
  const change = (count) =>
    inViewer(
      page,
      async (viewer, times) => {
        const element = document.querySelector("#viewer");
        const { measurements } = await fetch("/avatar.json").then((answer) => answer.json());
        const rows = measurements.filter(({ kind }) => kind === "girth");
        const drawn = () =>
          new Promise((resolve) => element.addEventListener("frame", resolve, { once: true }));
        for (let i = 0; i < times; i += 1) {
          if (i % 20 === 0) {
            viewer.fadeGhost();
            viewer.keepGhost();
          }
          if (i % 50 === 49) await viewer.load("/avatar.glb");
          if (i % 10 === 9) {
            viewer.lay(rows.slice(i % 3)); // drawn, each takes memory of its own
            await drawn();
          }
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
