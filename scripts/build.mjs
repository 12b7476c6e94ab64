/**
 * The front end: page scripts with what they import, small, into static/build/.
 *
 * What a page imports only when it is asked for lies in pieces of its own, which carry their
 * content's fingerprint in their names.
 */

import { copyFileSync, mkdirSync, rmSync, writeFileSync } from "node:fs";
import path from "node:path";
import { fileURLToPath } from "node:url";

import { build } from "esbuild";

import { poseBundle } from "./pose_bundle.mjs";

const BUILT = "static/build";

rmSync(BUILT, { recursive: true, force: true });
const { metafile } = await build({
  entryPoints: [
    "static/avatar.js",
    "static/preview.js",
    "static/photos/compare.js",
    "static/photos/worker.js",
  ],
  outdir: BUILT,
  outbase: "static",
  bundle: true,
  splitting: true,
  chunkNames: "[name]-[hash]",
  format: "esm",
  target: ["es2022"],
  minify: true,
  legalComments: "linked",
  logLevel: "warning",
  metafile: true,
});

// Which pieces each script imports at once: a page asks for them beside it, not after it.
const pieces = Object.entries(metafile.outputs)
  .filter(([, { entryPoint }]) => entryPoint)
  .map(([name, { imports }]) => [
    path.relative("static", name),
    imports
      .filter(({ kind, external }) => kind === "import-statement" && !external)
      .map((piece) => path.relative("static", piece.path)),
  ]);
writeFileSync(`${BUILT}/pieces.json`, JSON.stringify(Object.fromEntries(pieces)));

// What finds people in photos: the runtime as it comes, and the network as the runtime takes it.
const runtime = new URL(".", import.meta.resolve("@mediapipe/tasks-vision"));
mkdirSync(`${BUILT}/photos`, { recursive: true });
for (const end of ["js", "wasm"]) {
  const file = `wasm/vision_wasm_module_internal.${end}`;
  copyFileSync(new URL(file, runtime), `${BUILT}/photos/vision.${end}`);
}
const networks = fileURLToPath(new URL("../node_modules/@mediapipe/pose", import.meta.url));
writeFileSync(`${BUILT}/photos/pose.task`, poseBundle(networks, "full"));
