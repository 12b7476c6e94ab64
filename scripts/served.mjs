/** The site as it is deployed, for scripts that measure it in a browser; and a shopper on it. */

import { spawn } from "node:child_process";
import { readFileSync } from "node:fs";
import { createServer } from "node:net";
import path from "node:path";
import { fileURLToPath } from "node:url";

const PERSON = {
  body: "female",
  units: "metric",
  stature: "168",
  weight: "64",
  bust_girth: "92",
  waist_girth: "74",
  hip_girth: "100",
};

const root = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "..");

/** The deployed server on a free port, and how to stop it. */
export async function serve() {
  if (process.env.BASE_URL) return { base: process.env.BASE_URL, stop: () => {} };
  const port = await freePort();
  const command = readFileSync(path.join(root, "Procfile"), "utf8").match(/^web: (.+)$/m)[1];
  const server = spawn("sh", ["-c", `exec ${command}`], {
    cwd: root,
    stdio: ["ignore", "ignore", "inherit"],
    env: {
      ...process.env,
      PATH: [path.join(root, ".venv/bin"), process.env.PATH].join(path.delimiter),
      HOST: "127.0.0.1",
      PORT: String(port),
      FITTING_ROOM_LOCAL: "1",
      RATELIMIT_ENABLED: "0",
      SECRET_KEY: "only-for-measuring",
      GUNICORN_CMD_ARGS: "--log-level warning",
    },
  });
  const base = `http://127.0.0.1:${port}`;
  for (let tries = 0; ; tries += 1) {
    const answer = await fetch(`${base}/healthz`).catch(() => null);
    if (answer?.ok) break;
    if (tries > 240) throw new Error("The site does not start.");
    await new Promise((resolve) => setTimeout(resolve, 500));
  }
  return { base, stop: () => server.kill("SIGTERM") };
}

function freePort() {
  return new Promise((resolve) => {
    const probe = createServer().listen(0, "127.0.0.1", () => {
      const { port } = probe.address();
      probe.close(() => resolve(port));
    });
  });
}

/** The cookie of a shopper who has filled in the form. */
export async function fillIn(base) {
  const jar = new Map();
  const take = (response) => {
    for (const line of response.headers.getSetCookie()) {
      const [pair] = line.split(";");
      jar.set(pair.slice(0, pair.indexOf("=")), pair);
    }
    return response;
  };
  const cookie = () => [...jar.values()].join("; ");
  const page = await take(await fetch(`${base}/numbers`)).text();
  const token = page.match(/name="csrf_token" value="([^"]+)"/)[1];
  const body = new URLSearchParams({ csrf_token: token, ...PERSON });
  const headers = { Cookie: cookie(), Referer: `${base}/` };
  take(await fetch(`${base}/numbers`, { method: "POST", body, headers, redirect: "manual" }));
  const avatar = await fetch(`${base}/avatar`, { headers: { Cookie: cookie() }, redirect: "manual" });
  if (avatar.status !== 200) throw new Error(`The avatar's page: status ${avatar.status}.`);
  return cookie();
}
