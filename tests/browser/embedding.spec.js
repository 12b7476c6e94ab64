/** The fitting room on a shop's page: two origins, of two sites to the browser. */

import { spawn } from "node:child_process";
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import path from "node:path";
import { fileURLToPath } from "node:url";

import { test as base, expect } from "@playwright/test";

import { ready } from "./site.js";

const root = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "../..");
const TYPES = { html: "text/html", css: "text/css", js: "text/javascript" };

/** The example of docs/embedding, and a fitting room that lets it in; `shop.home`, `shop.page`. */
const test = base.extend({
  shop: [
    async ({}, use) => {
      const [room, port] = [await freePort(), await freePort()];
      const home = `http://127.0.0.1:${room}`;
      const shop = createServer((request, response) => {
        const name = path.basename(request.url);
        const file = path.join(root, "docs/embedding", name);
        response.setHeader("Content-Type", TYPES[name.split(".").pop()] ?? "text/plain");
        try {
          response.end(readFileSync(file, "utf8").replaceAll("http://127.0.0.1:8000", home));
        } catch {
          response.writeHead(404).end();
        }
      }).listen(port);
      const server = spawn("gunicorn", ["--config", "webapp/server.py", "webapp:create_app()"], {
        cwd: root,
        stdio: "ignore",
        env: {
          ...process.env,
          PATH: [path.join(root, ".venv/bin"), process.env.PATH].join(path.delimiter),
          HOST: "127.0.0.1",
          PORT: String(room),
          WEB_CONCURRENCY: "1",
          FITTING_ROOM_LOCAL: "1",
          EMBED_ORIGINS: `http://localhost:${port}`,
        },
      });
      await expect
        .poll(() => fetch(`${home}/healthz`).then((answer) => answer.ok, () => false), {
          timeout: 60_000,
        })
        .toBe(true);
      await use({ home, page: `http://localhost:${port}/example.html`, port });
      server.kill();
      shop.close();
    },
    { scope: "worker", timeout: 90_000 },
  ],
});

async function freePort() {
  const server = createServer().listen(0);
  const { port } = server.address();
  await new Promise((done) => server.close(done));
  return port;
}

test("a shopper sees their body on the shop's page, which learns nothing of it", async ({
  page,
  context,
  shop,
}) => {
  const heard = [];
  await page.exposeFunction("heard", (message) => heard.push(message));
  await page.addInitScript(() => {
    if (window.top !== window) return;
    window.addEventListener("message", ({ data }) => window.heard(JSON.stringify(data)));
  });
  const refused = [];
  page.on("console", (message) => {
    if (/Content Security Policy/.test(message.text())) refused.push(message.text());
  });

  await page.goto(shop.page);
  await expect(page.locator("#where")).toHaveText("You are entering measurements.");
  const frame = page.frameLocator("iframe");
  // By key: Chromium loses clicks on what it has just scrolled to in another process's frame.
  await frame.locator('a[href="/numbers"]').first().press("Enter");
  await expect(frame.locator('input[name="stature"]')).toBeVisible();
  await frame.locator('input[name="body"][value="female"]').check();
  await frame.locator('input[name="stature"]').fill("168");
  await frame.locator('input[name="hip_girth"]').fill("100.5");
  await frame.locator("main form button.button[type=submit]").press("Enter");
  await ready(frame);
  await expect(page.locator("#where")).toHaveText("You are looking at your body.");

  const said = [...new Set(heard)].map((text) => JSON.parse(text));
  expect(said.every(({ from, event }) => from === "fitting-room" && event === "page")).toBe(true);
  expect(heard.join()).not.toMatch(/168|100/);
  expect(refused).toEqual([]);
  const [cookie] = await context.cookies(shop.home);
  expect(cookie).toMatchObject({ secure: true, httpOnly: true, sameSite: "None" });
  expect(cookie.partitionKey).toContain("localhost");
  // Elsewhere there is another jar: the same browser is a stranger to the fitting room itself.
  const alone = await context.newPage();
  await alone.goto(`${shop.home}/numbers`);
  await expect(alone.locator('input[name="stature"]')).toHaveValue("");
});

test("a page that is not on the list gets a link in place of a frame", async ({ page, shop }) => {
  await page.goto(`http://127.0.0.1:${shop.port}/example.html`);
  const link = page.getByRole("link", { name: "Open the fitting room" });
  await expect(link).toHaveAttribute("href", `${shop.home}/`);
  await expect(page.locator("fitting-room iframe")).toBeHidden();
  await expect(page.locator("#where")).toBeEmpty();
});
