/** The fields beside the body: numbers as people write them, a button for less and one for more. */

import { parse, write } from "./numbers.js";

export class Editor {
  #form;
  #changed;

  /**
   * @param {HTMLFormElement} form
   * @param {(name: string, text: string, value: number|null) => void} changed what was typed, and
   *     the number that it is where the page can read it and it lies within the field's limits
   * @param {(name: string) => void} inHand the measurement that the reader turns to
   */
  constructor(form, changed, inHand) {
    this.#form = form;
    this.#changed = changed;
    form.hidden = false;
    form.addEventListener("submit", (event) => event.preventDefault());
    form.addEventListener("input", ({ target }) => this.#typed(target));
    form.addEventListener("focusin", ({ target }) => {
      const row = target.closest("[data-measurement]");
      if (row) inHand(row.dataset.measurement);
    });
    form.addEventListener("keydown", (event) => {
      const by = { ArrowUp: 1, ArrowDown: -1 }[event.key];
      if (!by || !event.target.matches("[role=spinbutton]")) return;
      event.preventDefault();
      this.#step(event.target, by);
    });
    form.addEventListener("click", ({ target }) => {
      const button = target.closest("[data-step]");
      if (!button) return;
      this.#step(button.parentElement.querySelector("input"), Number(button.dataset.step));
    });
  }

  /** Words at a field: what is wrong with it, or what to look at again; "" for none. */
  say(name, message, wrong = false) {
    const row = this.#form.querySelector(`[data-measurement="${name}"]`);
    if (!row) return;
    const note = row.querySelector(".editor-note");
    if (note.textContent !== message) note.textContent = message;
    row.classList.toggle("editor-wrong", wrong);
    row.querySelector("input").setAttribute("aria-invalid", String(wrong));
  }

  /** The measurement whose field has the focus, "" for none. */
  get inHand() {
    return this.#form.querySelector("[data-measurement]:focus-within")?.dataset.measurement ?? "";
  }

  get names() {
    return [...this.#form.querySelectorAll("[data-measurement]")].map(
      (row) => row.dataset.measurement,
    );
  }

  #step(input, by) {
    const { size, low, high, feet } = input.dataset;
    const value = parse(input.value, Boolean(feet)) || 0;
    // To the next whole step: 74.3 goes to 74.5, not to 74.8.
    const steps = value / Number(size);
    const next = by > 0 ? Math.floor(steps + 1e-6) + 1 : Math.ceil(steps - 1e-6) - 1;
    const kept = Math.min(Math.max(next * Number(size), Number(low)), Number(high));
    input.value = write(kept, Boolean(feet));
    this.#typed(input);
  }

  #typed(input) {
    const { low, high, feet } = input.dataset;
    const value = parse(input.value, Boolean(feet));
    const within = value >= Number(low) && value <= Number(high);
    if (within) input.setAttribute("aria-valuenow", value);
    input.setAttribute("aria-valuetext", input.value);
    this.#changed(input.name, input.value, within ? value : null);
  }
}
