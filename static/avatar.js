/**
 * The avatar's page. What can be read stands there without this script; it brings the fields to
 * life at once, and the body in 3D at the reader's first touch, or, where a graphics processor draws
 * it, when the page has been at rest.
 */

import { Editor } from "./editor.js";
import { fillTables } from "./table.js";
import { preview, toSi } from "./numbers.js";
import { Sender } from "./server.js";
import { WORDS, fill } from "./words.js";

const NAMED = 3; // of the values that the body has not, as on the server
const MET = { metres: 0.001, kilograms: 0.1 }; // a value this near to the body's is met, as on the server
const GHOST_STAYS = 2500; // milliseconds after the last change
const TABLES_WAIT = 100; // milliseconds for which changed numbers are gathered
const REST = 2000; // milliseconds without a touch, after which the body in 3D comes by itself
const TOUCHES = ["pointerdown", "pointermove", "touchstart", "wheel", "scroll", "keydown", "focusin"];

async function start(element) {
  announce(element);
  const page = new Page(element);
  // The still picture first, which shows the same: what draws in 3D would hold a telephone up.
  const touch = touched();
  await painted();
  const rest = new Promise((resolve) => setTimeout(resolve, REST));
  const fast = rest.then(() => drawsFast(element.dataset.renderer));
  await Promise.race([touch, fast.then((draws) => (draws ? null : touch))]);
  await idle();
  await page.open();
}

/** When the page's own pictures are there and the browser has time. */
async function painted() {
  if (document.readyState !== "complete") {
    await new Promise((resolve) => window.addEventListener("load", resolve, { once: true }));
  }
  await idle();
}

/** Whether a graphics processor draws: without one the first picture in 3D takes seconds. */
function drawsFast(script) {
  return new Promise((resolve) => {
    const worker = new Worker(script);
    const answer = (fast) => {
      worker.terminate();
      resolve(fast);
    };
    worker.addEventListener("message", ({ data }) => answer(data));
    worker.addEventListener("error", () => answer(false));
  });
}

/** When the reader does anything at all. */
function touched() {
  return new Promise((resolve) => {
    const over = new AbortController();
    const heard = () => {
      over.abort();
      resolve();
    };
    const options = { signal: over.signal, capture: true, passive: true };
    for (const touch of TOUCHES) window.addEventListener(touch, heard, options);
  });
}

function idle() {
  return new Promise((resolve) => {
    if ("requestIdleCallback" in window) window.requestIdleCallback(resolve, { timeout: 1000 });
    else setTimeout(resolve, 50);
  });
}

class Page {
  #element;
  #viewer = null;
  #makeStage = null; // once the buttons' part of the page is fetched
  #stage = null; // that part, once there is a body to turn
  #extras = null; // what the body's file says of its targets
  #rows = []; // of the last answer
  #typed = {}; // texts typed so far, by name
  #asked = {}; // numbers typed since the last answer, by name, in the page's unit
  #editor;
  #sender;
  #status;
  #ghostTimer = 0;
  #tablesDue = 0; // a timer, once the numbers have changed
  #version = 0;
  #learning = null; // a promise, from when there is a body that may bend
  #turnedTo; // when the reader has first turned to a field

  constructor(element) {
    this.#element = element;
    const form = document.querySelector("#editor");
    this.#status = form.querySelector("[role=status]");
    this.#editor = new Editor(
      form,
      (name, text, value) => this.#change(name, text, value),
      (name) => this.#stage?.take(name),
    );
    this.#turnedTo = new Promise((resolve) => {
      form.addEventListener("focusin", resolve, { once: true });
    });
    const token = form.querySelector("[name=csrf_token]").value;
    this.#sender = new Sender(element.dataset.numbers, token, (answer, sent) =>
      this.#hear(answer, sent),
    );
  }

  async open() {
    try {
      const [{ Stage, createViewer }, numbers] = await Promise.all([
        import("./stage.js"),
        fetch(this.#element.dataset.numbers).then((response) => response.json()),
      ]);
      // What was typed meanwhile may have been answered already.
      if (!this.#rows.length) this.#rows = numbers.measurements;
      await idle();
      const viewer = createViewer(this.#element);
      this.#element.viewer = viewer; // for what else the page may do with it
      this.#viewer = viewer;
      this.#makeStage = () => new Stage(this.#element, viewer, numbers.units);
      await this.#load();
    } catch (error) {
      // The still picture stays where it is, and so do the two others and the download.
      if (!this.#stage) this.#element.dataset.state = "failed";
      console.warn(error.message);
    }
  }

  /**
   * Show the body of the numbers as the server has them. A change may have come before the first
   * body did, or that one may have failed: with whichever comes first the page comes to life.
   *
   * @param {() => void} arrived what to do at the moment when it is shown
   */
  async #load(arrived = () => {}) {
    const shown = await this.#viewer.load(this.#element.dataset.glb, () => {
      arrived();
      return this.#changes();
    });
    if (!shown) return; // a later call won
    const first = this.#stage === null;
    if (first) this.#stage = this.#makeStage();
    this.#stage.tell(this.#shown(), this.#rows);
    if (first) this.#stage.take(this.#editor.inHand);
    this.#learning ??= this.#learn().catch((error) => {
      this.#learning = null; // the next body tries again
      console.warn(error.message);
    });
  }

  /** How the body bends: larger than the body itself, so it comes when there is time for it. */
  async #learn() {
    await (navigator.connection?.saveData ? this.#turnedTo : idle());
    this.#extras = await this.#viewer.learn(this.#element.dataset.live, () => this.#changes());
    this.#element.dataset.learned = "true";
    this.#tell();
  }

  /** Something was typed: the body follows in the next frame, the server a moment later. */
  #change(name, text, value) {
    this.#editor.say(name, "");
    this.#sender.change(name, text);
    this.#typed[name] = text;
    if (value === null) return;
    this.#asked[name] = value;
    if (!this.#viewer) return;
    if (!this.#viewer.hasGhost) this.#viewer.keepGhost();
    clearTimeout(this.#ghostTimer);
    this.#ghostTimer = 0;
    this.#viewer.bend(this.#changes());
    this.#tell();
  }

  /** How far the entered values are from those of the body that was loaded, SI. */
  #changes() {
    const before = new Map(this.#rows.map((row) => [row.name, row]));
    return Object.fromEntries(
      Object.entries(this.#asked).map(([name, value]) => {
        const row = before.get(name);
        return [name, row ? toSi(value - row.asked, row.unit) : 0];
      }),
    );
  }

  /** The rows as they stand now, nearly, until the server says how they are. */
  #shown() {
    if (!Object.keys(this.#asked).length || !this.#extras) return this.#rows;
    return preview(this.#rows, this.#asked, this.#extras);
  }

  #tell() {
    this.#stage?.tell(this.#shown());
    // Nobody reads sixty tables a second, and each would have the page laid out anew.
    this.#tablesDue ||= setTimeout(() => {
      this.#tablesDue = 0;
      fillTables(this.#shown());
    }, TABLES_WAIT);
  }

  async #hear({ status, document: answer }, sent) {
    if (status === 200) await this.#accepted(answer, sent);
    else this.#refused(status, answer, sent);
    // Not anew with each of the answers to one change: without a server they would never end.
    this.#ghostTimer ||= setTimeout(() => {
      this.#ghostTimer = 0;
      this.#stage?.letGhostGo();
    }, GHOST_STAYS);
  }

  async #accepted(answer, sent) {
    if (this.#viewer) await this.#replace(answer, sent);
    else this.#take(answer, sent);
    for (const name of this.#editor.names) {
      const warning = answer.warnings.find(({ measurement }) => measurement === name);
      this.#editor.say(name, warning?.message ?? "");
    }
    this.#sayBody();
    document.querySelector(".refined")?.remove(); // its body is left with the first change
    this.#refreshPictures();
  }

  /** The body of the answer, and its numbers, in place of the preview: together. */
  async #replace(answer, sent) {
    try {
      await this.#load(() => this.#take(answer, sent));
    } catch (error) {
      this.#status.textContent = WORDS.unreached;
      console.warn(error.message);
    }
  }

  /** Take an answer's rows; what was typed since stays typed. */
  #take(answer, sent) {
    this.#rows = answer.measurements;
    for (const [name, text] of Object.entries(sent)) {
      if (this.#typed[name] === text) delete this.#asked[name];
    }
    this.#tell();
  }

  #refused(status, problem, sent) {
    for (const { field, message } of problem?.errors ?? []) this.#editor.say(field, message, true);
    if (problem?.errors?.length) this.#status.textContent = problem.errors[0].message;
    else this.#status.textContent = WORDS[status === 0 || status >= 500 ? "unreached" : "ended"];
    if (status === 0) for (const [name, text] of Object.entries(sent)) this.#sender.change(name, text);
  }

  #sayBody() {
    const apart = ({ asked, taken }) => Math.abs(asked / taken - 1);
    const unmet = this.#rows
      .filter(
        ({ asked, taken, unit, kind }) =>
          asked !== null && Math.abs(toSi(asked - taken, unit)) > MET[kind === "mass" ? "kilograms" : "metres"],
      )
      .sort((one, other) => apart(other) - apart(one));
    const names = unmet
      .slice(0, NAMED)
      .map(({ label }) => label)
      .join(", ");
    const place = document.querySelector("#verdict");
    const verdict = unmet.length ? fill(WORDS.unmet, { names }) : WORDS.met;
    this.#status.textContent = verdict;
    place.textContent = verdict;
    document.querySelector("#verdict-more").textContent = WORDS[unmet.length ? "differ" : "rest"];
  }

  #refreshPictures() {
    this.#version += 1;
    for (const picture of document.querySelectorAll("img[data-side]")) {
      const [address] = picture.getAttribute("src").split("?");
      picture.src = `${address}?v=${this.#version}`;
    }
  }
}

/** A line that is read out when the state changes, also later: a graphics driver may give up. */
function announce(element) {
  const line = document.createElement("p");
  line.className = "viewer-status";
  line.setAttribute("role", "status");
  element.after(line);
  const observer = new MutationObserver(() => {
    line.textContent = WORDS.states[element.dataset.state] ?? "";
  });
  observer.observe(element, { attributeFilter: ["data-state"] });
}

const element = document.querySelector("#viewer");
if (element) start(element);
