/** The front end: page scripts with what they import, small, into static/build/. */

import { build } from "esbuild";

await build({
  entryPoints: ["static/avatar.js"],
  outdir: "static/build",
  bundle: true,
  format: "esm",
  target: ["es2022"],
  minify: true,
  legalComments: "linked",
  logLevel: "warning",
});
