/**
 * How long the wizard takes by a model of reading and typing, for nobody was timed: what stands on
 * each page above its field, or above the button of a page without one, is read once, the tape is
 * laid, the number is typed. Who also reads what links and buttons say, and pages without a field to
 * their end, takes longer (so it was counted at first); so does who reads on to each button, what is
 * said of the number with it; longest who reads every page to its end, all that is folded opened.
 *
 *     node scripts/minutes.mjs                                  the site of this folder
 *     node scripts/minutes.mjs pt-PT                            in Portuguese
 *     BASE_URL=http://127.0.0.1:8000 node scripts/minutes.mjs   a site that is already running
 *
 * Seconds: 238 words are read a minute (M. Brysbaert, Journal of Memory and Language 109, 2019); a
 * key, to point and to make up one's mind take 0.28, 1.1 and 1.35 (S. Card, T. Moran and A. Newell,
 * Communications of the ACM 23(7), 1980, average typist). To make up one's mind is to see what there is
 * to press, so that the words of links and buttons are counted by the second way alone.
 * How long a tape takes is our assumption.
 */

import { chromium } from "@playwright/test";

import { launchOptions } from "../tests/browser/chromium.js";
import { METRIC, NEXT, begin, walk } from "../tests/browser/wizard.js";
import { serve } from "./served.mjs";

const [WORD, KEY, POINT, MIND] = [60 / 238, 0.28, 1.1, 1.35];
const TAPE = 15; // seconds to lay a tape around and read it; other things:
const TAKING = { stature: 40, weight: 10, inseam_height: 30 };

const locale = process.argv[2] ?? "en-GB";

const { base, stop } = await serve();
const browser = await chromium.launch(launchOptions());
const page = await browser.newPage({ baseURL: base, locale, viewport: { width: 360, height: 740 } });
page.setDefaultTimeout(180_000); // the machine may be busy

/** The words above the field, those with links and buttons, above the button, and of all the page. */
async function words(name) {
  await page.waitForTimeout(1500); // what is said of a number comes after a pause
  return page.evaluate(
    ([name, next, LINKED, ALL]) => {
      for (const folded of document.querySelectorAll("main details")) folded.open = true;
      const button = document.querySelector(next);
      const field = document.getElementById(name);
      const ends = [field ?? button, field, button, null];
      const counts = ends.map(() => 0);
      const seen = document.createTreeWalker(document.querySelector("main"), NodeFilter.SHOW_TEXT);
      for (let text = seen.nextNode(); text; text = seen.nextNode()) {
        const parent = text.parentElement;
        if (!parent.checkVisibility()) continue;
        const pressed = parent.closest(".unseen, a, button, summary");
        const folded = parent.closest("details") && !parent.closest("summary");
        const many = text.data.match(/[\p{L}\p{N}]\S*/gu)?.length ?? 0;
        ends.forEach((end, at) => {
          const passed = end && text.compareDocumentPosition(end) & Node.DOCUMENT_POSITION_PRECEDING;
          if (passed || (pressed && at !== LINKED) || (folded && at !== ALL)) return;
          counts[at] += many;
        });
      }
      return counts;
    },
    [name, NEXT, LINKED, ALL],
  );
}

const typed = (value) => MIND + POINT + KEY * value.length;
const press = MIND + POINT;
const COLUMNS = ["words", "with links", "to button", "all words", "reading", "taking", "typing"];
const [LINKED, ALL] = [1, 3];
const total = COLUMNS.map(() => 0);

/** Prints a page's words and seconds, and adds them. */
function tell(name, counts, taking, typing) {
  const row = [...counts, WORD * counts[0], taking, typing];
  print(name, row.map((number) => number.toFixed(0)));
  row.forEach((number, at) => (total[at] += number));
}

const print = (name, cells) =>
  console.log(name.padEnd(16) + cells.map((cell) => cell.padStart(11)).join(""));

try {
  print("", COLUMNS);
  await begin(page, "metric", async () => tell("start", await words(null), 0, 3 * press));
  await walk(page, METRIC, async (name) => {
    tell(name, await words(name), TAKING[name] ?? TAPE, typed(METRIC[name]) + press);
  });
  tell("review", await words(null), 0, press);
  print("", total.map((number) => number.toFixed(0)));
  const [above, linked, on, all, , taking, typing] = total;
  const minutes = (count) => ((WORD * count + taking + typing) / 60).toFixed(1);
  console.log(`
With a tape at hand, what stands above each field being read once: ${minutes(above)} minutes
The words of links and buttons, and of the start and review to their ends, too: ${minutes(linked)} minutes
What stands above each button, without those, on every page anew: ${minutes(on)} minutes
All words of all pages, the folded ones too: ${minutes(all)} minutes`);

  const form = Object.values(METRIC).reduce((sum, value) => sum + typed(value), 3 * press);
  console.log(`One who knows ${Object.keys(METRIC).length} numbers, on the one form: ${(form / 60).toFixed(1)} minutes`);
} finally {
  await browser.close();
  stop();
}
