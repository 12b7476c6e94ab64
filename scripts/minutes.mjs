/**
 * How long the wizard takes by a model of reading and typing, for nobody was timed: what stands on
 * each page up to its field is read once, the tape is laid, the number is typed.
 *
 *     node scripts/minutes.mjs                                  the site of this folder
 *     BASE_URL=http://127.0.0.1:8000 node scripts/minutes.mjs   a site that is already running
 *
 * Seconds: 238 words are read a minute (M. Brysbaert, Journal of Memory and Language 109, 2019); a
 * key, to point and to make up one's mind take 0.28, 1.1 and 1.35 (S. Card, T. Moran and A. Newell,
 * Communications of the ACM 23(7), 1980, average typist). How long a tape takes is our assumption.
 */

import { chromium } from "@playwright/test";

import { launchOptions } from "../tests/browser/chromium.js";
import { METRIC, begin, walk } from "../tests/browser/wizard.js";
import { serve } from "./served.mjs";

const [WORD, KEY, POINT, MIND] = [60 / 238, 0.28, 1.1, 1.35];
const TAPE = 15; // seconds to lay a tape around and read it; other things:
const TAKING = { stature: 40, weight: 10, inseam_height: 30 };

const { base, stop } = await serve();
const browser = await chromium.launch(launchOptions());
const page = await browser.newPage({ baseURL: base, locale: "en-GB", viewport: { width: 360, height: 740 } });

/** The words that are seen before the field, or on the whole of a page without one. */
const words = (name) =>
  page.evaluate((name) => {
    const field = name && document.getElementById(name);
    const seen = document.createTreeWalker(document.querySelector("main"), NodeFilter.SHOW_TEXT);
    let count = 0;
    for (let text = seen.nextNode(); text; text = seen.nextNode()) {
      if (field && text.compareDocumentPosition(field) & Node.DOCUMENT_POSITION_PRECEDING) break;
      if (!text.parentElement.checkVisibility()) continue;
      count += text.data.split(/\s+/).filter(Boolean).length;
    }
    return count;
  }, name);

const typed = (value) => MIND + POINT + KEY * value.length;
const press = MIND + POINT;
const total = { reading: 0, taking: 0, typing: 0 };

/** Prints a page's seconds, and adds them. */
function tell(name, reading, taking, typing) {
  console.log(name.padEnd(20) + [reading, taking, typing].map((s) => s.toFixed(0).padStart(9)).join(""));
  total.reading += reading;
  total.taking += taking;
  total.typing += typing;
}

try {
  console.log("seconds".padEnd(20) + ["reading", "taking", "typing"].map((w) => w.padStart(9)).join(""));
  await begin(page, "metric", async () => tell("start", WORD * (await words(null)), 0, 3 * press));
  await walk(page, METRIC, async (name) => {
    tell(name, WORD * (await words(name)), TAKING[name] ?? TAPE, typed(METRIC[name]) + press);
  });
  tell("review", WORD * (await words(null)), 0, press);
  const sum = total.reading + total.taking + total.typing;
  console.log(`\nWith a tape at hand: ${(sum / 60).toFixed(1)} minutes`);

  const form = Object.values(METRIC).reduce((sum, value) => sum + typed(value), 3 * press);
  console.log(`One who knows ${Object.keys(METRIC).length} numbers, on the one form: ${(form / 60).toFixed(1)} minutes`);
} finally {
  await browser.close();
  stop();
}
