/** The Chromium of this machine, and how it is started: without a screen, card or outside world. */

import { existsSync } from "node:fs";
import path from "node:path";

/** @throws {Error} where there is none */
export function launchOptions() {
  return {
    executablePath: chromium(),
    args: [
      "--disable-background-networking",
      "--disable-component-update",
      "--disable-quic",
      "--disable-sync",
      "--no-first-run",
      // Root, as in a container, has no sandbox to enter.
      ...(process.getuid?.() === 0 ? ["--no-sandbox"] : []),
      // WebGL without a graphics card.
      "--enable-unsafe-swiftshader",
      "--use-angle=swiftshader",
    ],
  };
}

function chromium() {
  const folders = process.env.PATH.split(path.delimiter);
  const named = ["chromium", "chromium-browser", "google-chrome"].flatMap((name) =>
    folders.map((folder) => path.join(folder, name)),
  );
  const found = [process.env.CHROMIUM ?? "", ...named].find((file) => file && existsSync(file));
  if (!found) throw new Error("No Chromium: install it, or name one in CHROMIUM.");
  return found;
}
