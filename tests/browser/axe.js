/** What axe finds wrong on a page: for the browser tests, and for the script that sees every page. */

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

/** Asked for besides what axe looks at unasked: WCAG 2.2's size of targets. */
const OPTIONS = { rules: { "target-size": { enabled: true } } };

/** What axe finds wrong, in its words: the rule and where. */
export async function axe(page) {
  await page.evaluate(AXE);
  const { violations } = await page.evaluate((options) => window.axe.run(document, options), OPTIONS);
  return violations.map(({ id, nodes }) => `${id}: ${nodes.map((node) => node.target).join(", ")}`);
}
