/** The buttons around the body in 3D, and what they show: views, tapes, ruler, skin, the body before. */

import { toSi, words } from "./numbers.js";
import { Overlay } from "./overlay.js";
import { REGIONS } from "./regions.js";
import { SKIN_TONES } from "./tones.js";
import { WORDS } from "./words.js";

export { createViewer } from "./viewer.js";

const BUTTON_ZOOM = 1.3;
const LABEL = 110; // pixels that a name and its number take
/** From where a region is seen best, as the azimuths of orbit.js: limbs are measured at the left. */
const AZIMUTHS = { head: Math.PI / 5, around: 0, along: 0, arms: 1.3, legs: Math.PI / 8 };

export class Stage {
  #element;
  #viewer;
  #overlay;
  #units;
  #rows = []; // as shown
  #served = []; // of the body that the server made, whose tapes these are
  #region = "";
  #inHand = "";
  #keepGhost = false;
  #rulerShown = false;

  constructor(element, viewer, units) {
    this.#element = element;
    this.#viewer = viewer;
    this.#units = units;
    this.#overlay = new Overlay(element, viewer);
    this.#views();
    this.#regions();
    this.#switches();
    this.#tones();
    this.#readTable();
  }

  /** New numbers; `served` where they come with another body, whose tapes run elsewhere. */
  tell(rows, served = null) {
    this.#rows = rows;
    if (served) {
      this.#served = served;
      this.#lay();
    }
    this.#overlay.tell(this.#picked(rows));
    this.#measure();
  }

  /** Show the tape of the measurement that the reader turns to, if no region is chosen. */
  take(name) {
    if (this.#region || this.#inHand === name) return;
    this.#inHand = name;
    this.#markRow();
    this.#lay();
    this.#name();
  }

  /** Let the body before fade, unless the reader has asked to see it. */
  letGhostGo() {
    if (!this.#keepGhost) this.#viewer.fadeGhost();
  }

  // ---- tapes ----

  #picked(rows) {
    const names = this.#region ? REGIONS[this.#region] : [this.#inHand];
    return rows.filter(({ name }) => names.includes(name));
  }

  #lay() {
    this.#viewer.lay(this.#picked(this.#served));
  }

  #name() {
    this.#overlay.name(this.#picked(this.#rows));
  }

  #regions() {
    const group = document.querySelector("#tape-regions");
    for (const region of ["", ...Object.keys(REGIONS)]) {
      const button = document.createElement("button");
      button.type = "button";
      button.dataset.region = region;
      button.textContent = WORDS.regions[region || "none"];
      button.setAttribute("aria-pressed", String(region === ""));
      button.addEventListener("click", () => this.#choose(region));
      group.append(button);
    }
  }

  #choose(region) {
    this.#region = region;
    this.#inHand = "";
    this.#markRow();
    for (const button of document.querySelectorAll("button[data-region]")) {
      button.setAttribute("aria-pressed", String(button.dataset.region === region));
    }
    this.#lay();
    this.#name();
    const points = this.#viewer.laid.flatMap(({ points }) => points);
    // Names and numbers stand on both sides.
    const wide = Math.max(0.45, 1 - (2 * LABEL) / this.#element.clientWidth);
    if (points.length) this.#viewer.showPart(points, AZIMUTHS[region], wide);
    else this.#viewer.show("front");
  }

  /** A row of the tables shows its tape when its name is pressed. */
  #readTable() {
    for (const row of document.querySelectorAll("tr[data-measurement]")) {
      const head = row.querySelector("th");
      const button = document.createElement("button");
      button.type = "button";
      button.className = "row-tape";
      button.setAttribute("aria-pressed", "false");
      button.append(...[...head.childNodes].filter((node) => node.nodeType === Node.TEXT_NODE));
      button.title = WORDS.show_tape;
      head.prepend(button);
      button.addEventListener("click", () => {
        const { measurement } = row.dataset;
        if (this.#region) this.#choose("");
        this.take(this.#inHand === measurement ? "" : measurement);
      });
    }
  }

  #markRow() {
    for (const row of document.querySelectorAll("tr[data-measurement]")) {
      const pressed = row.dataset.measurement === this.#inHand;
      row.querySelector(".row-tape")?.setAttribute("aria-pressed", String(pressed));
    }
  }

  // ---- views, switches, skin ----

  #views() {
    const views = [...document.querySelectorAll("button[data-view]")];
    for (const button of views) {
      button.addEventListener("click", () => this.#viewer.show(button.dataset.view));
    }
    const mark = (view) => {
      // Where there is room for one picture beside the body, it is the one of the same camera.
      document.querySelector(".mirror").dataset.picture = view === "side" ? "profile" : "front";
      for (const button of views) {
        button.setAttribute("aria-pressed", String(button.dataset.view === view));
      }
    };
    mark("front");
    this.#element.addEventListener("viewchange", ({ detail: view }) => {
      mark(view);
    });
    for (const button of document.querySelectorAll("button[data-zoom]")) {
      const factor = button.dataset.zoom === "in" ? BUTTON_ZOOM : 1 / BUTTON_ZOOM;
      button.addEventListener("click", () => this.#viewer.zoom(factor));
    }
  }

  #switches() {
    const actions = {
      ruler: (on) => {
        this.#rulerShown = on;
        this.#measure();
      },
      before: (on) => {
        this.#keepGhost = on;
        if (on && !this.#viewer.hasGhost) this.#viewer.keepGhost();
        if (!on) this.#viewer.fadeGhost();
      },
      beside: (on) => {
        document.querySelector(".mirror").classList.toggle("beside", on);
        this.#viewer.show("front");
        this.#element.scrollIntoView({ block: "nearest" });
      },
    };
    for (const [name, action] of Object.entries(actions)) {
      const button = document.querySelector(`button[data-switch="${name}"]`);
      button?.addEventListener("click", () => {
        const on = button.getAttribute("aria-pressed") !== "true";
        button.setAttribute("aria-pressed", String(on));
        action(on);
      });
    }
  }

  #measure() {
    const stature = this.#rows.find(({ name }) => name === "stature");
    if (!this.#rulerShown || !stature) {
      this.#overlay.measure(null);
      return;
    }
    const top = toSi(stature.taken, stature.unit);
    const text = words(stature).value;
    this.#overlay.measure({ units: this.#units, top, text });
  }

  #tones() {
    const group = document.querySelector("#tones");
    for (const [name, colour] of Object.entries(SKIN_TONES)) {
      const label = WORDS.tones[name];
      const [choice, input, swatch] = ["label", "input", "span"].map((tag) =>
        document.createElement(tag),
      );
      input.type = "radio";
      input.name = "tone";
      input.value = name;
      input.checked = name === "mannequin";
      input.setAttribute("aria-label", label);
      swatch.className = "swatch";
      swatch.style.backgroundColor = `rgb(${colour.map((light) => Math.round(255 * light))})`;
      choice.title = label;
      choice.append(input, swatch);
      group.append(choice);
      input.addEventListener("change", () => this.#viewer.paint(colour));
    }
  }
}
