/**
 * Browser tests on the real server, which they start on a free port and stop again.
 *
 *     npm run test:browser                                  the site of this folder
 *     BASE_URL=http://127.0.0.1:8000 npm run test:browser   a site that is already running
 *     CHROMIUM=/path/to/chrome npm run test:browser         another browser than chromium
 */

import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import path from "node:path";
import { fileURLToPath } from "node:url";

import { defineConfig } from "@playwright/test";

import { launchOptions } from "./chromium.js";

const root = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "../..");

// This file is read again by every worker: what is set in the environment, all of them share.
process.env.TEST_PORT ??= freePort();
const baseURL = process.env.BASE_URL ?? `http://127.0.0.1:${process.env.TEST_PORT}`;

// The body is drawn without a graphics card; that the page around it is put together so too would
// only take time.
const options = launchOptions();

export default defineConfig({
  testDir: ".",
  testMatch: "*.spec.js",
  outputDir: path.join(root, "test-results"),
  reporter: "list",
  workers: 2,
  // Generous, for a machine that draws without a graphics card and does other things besides.
  timeout: 120_000,
  expect: { timeout: 15_000 },
  forbidOnly: Boolean(process.env.CI),
  // Two browsers that draw without a graphics card may starve one another: such a test is said to
  // be flaky.
  retries: process.env.CI ? 1 : 0,
  use: {
    baseURL,
    browserName: "chromium",
    locale: "en-GB",
    launchOptions: { ...options, args: [...options.args, "--disable-gpu-compositing"] },
  },
  webServer: process.env.BASE_URL
    ? undefined
    : {
        command: serverCommand(),
        cwd: root,
        url: `${baseURL}/healthz`,
        timeout: 60_000,
        gracefulShutdown: { signal: "SIGTERM", timeout: 5_000 },
        env: {
          PATH: [path.join(root, ".venv/bin"), process.env.PATH].join(path.delimiter),
          HOST: "127.0.0.1",
          PORT: process.env.TEST_PORT,
          FITTING_ROOM_LOCAL: "1",
          RATELIMIT_ENABLED: "0",
          SECRET_KEY: "only-for-tests",
          GUNICORN_CMD_ARGS: "--log-level warning",
        },
      },
});

/** What a deployed site runs. */
function serverCommand() {
  const line = readFileSync(path.join(root, "Procfile"), "utf8").match(/^web: (.+)$/m);
  return `exec ${line[1]}`;
}

function freePort() {
  const ask =
    "const s=require('net').createServer().listen(0,'127.0.0.1'," +
    "()=>{process.stdout.write(String(s.address().port));s.close()})";
  return execFileSync(process.execPath, ["-e", ask], { encoding: "utf8" });
}
