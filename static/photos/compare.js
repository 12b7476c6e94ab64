/**
 * The page of photos: from a photo to its outline, and from outlines to their comparison.
 *
 * Of a photo nothing is sent but the black and white outline that `outlines` makes from the mask.
 */

import { createCamera } from "./camera.js";
import { createEditor } from "./editor.js";
import { canFind, createFinder } from "./finder.js";
import { area, blackAndWhite, bounds, cut, grown, silhouetteIn } from "./mask.js";
import { Unusable, fitted, pixelsOf, readPicture, toPng } from "./picture.js";
import { enliven } from "./results.js";
import { doubts } from "./stance.js";

const form = document.getElementById("comparison");
const results = document.getElementById("results");
const words = JSON.parse(document.getElementById("words").textContent);
const camera = createCamera(document.getElementById("camera"), words.camera);

/** Pixels of black around the person in the picture that is sent. */
const AROUND = 16;

let finder = null;

/** The finder of people, made when first needed; null where this browser cannot have one. */
async function findPeople() {
  if (!canFind()) return null;
  const { worker, loader, binary, model } = form.dataset;
  finder ??= createFinder({ worker, loader, binary, model });
  try {
    await finder.ready;
  } catch (error) {
    console.warn(error.message);
    giveUp();
    return null;
  }
  return finder;
}

/** A finder that failed is no use any more: the next photo asks for another. */
function giveUp() {
  finder?.stop();
  finder = null;
}

/** One of the two photos: its card on the page, and what is known of it. */
class View {
  constructor(card) {
    this.name = card.dataset.view;
    this.card = card;
    this.sight = card.querySelector(".sight");
    this.retake = card.querySelector("[data-retake]");
    this.status = card.querySelector(".view-status");
    this.editor = createEditor(this.sight, () => {
      this.measure();
      this.say(words.edited);
    });
    this.turn = 0; // told apart, so that the last choice wins

    const photo = card.querySelector(`#${this.name}-photo`);
    photo.addEventListener("change", () => this.choose(photo, (file) => this.fromPhoto(file)));
    const outline = card.querySelector(`#${this.name}-outline`);
    outline.addEventListener("change", () => this.choose(outline, (file) => this.fromOutline(file)));
    card.querySelector("[data-camera]").addEventListener("click", () => this.fromCamera());
    card.querySelector("[data-remove]").addEventListener("click", () => {
      this.remove();
      this.say(words.removed);
      photo.focus();
    });
    for (const element of card.querySelectorAll("[data-scripted]")) element.hidden = false;
  }

  say(text, isFault = false) {
    this.status.textContent = text;
    this.status.classList.toggle("fault", isFault);
  }

  /** What is chosen is read and let go: the form itself never holds a photo. */
  choose(input, read) {
    const [file] = input.files;
    input.value = "";
    if (file) this.attempt(() => read(file));
  }

  async attempt(work) {
    this.card.setAttribute("aria-busy", "true");
    try {
      await work();
    } catch (error) {
      if (!(error instanceof Unusable)) console.warn(error);
      this.say(error instanceof Unusable ? words.files[error.code] : words.failed, true);
    } finally {
      this.card.removeAttribute("aria-busy");
    }
  }

  async fromPhoto(file) {
    this.say(words.reading);
    await this.outline(await readPicture(file));
  }

  async fromCamera() {
    camera.greet();
    await this.attempt(async () => {
      let photo;
      try {
        photo = await camera.take(this.name, await this.ready());
      } catch (error) {
        console.warn(error.message);
        this.say(words.no_camera, true);
        return;
      }
      if (photo) await this.outline(await fitted(photo));
      else this.say("");
    });
  }

  async fromOutline(file) {
    const mask = silhouetteIn(pixelsOf(await readPicture(file)));
    const share = area(mask) / mask.data.length;
    if (share === 0 || share === 1) throw new Unusable("empty");
    this.show(null, mask, []);
    this.say(words.file_found);
  }

  async ready() {
    this.say(words.loading);
    const people = await findPeople();
    this.say("");
    return people;
  }

  /** Finds the person in a photo; where nothing can, or nobody is found, the brush is at hand. */
  async outline(photo) {
    this.turn += 1;
    const mine = this.turn;
    const { width, height } = photo;
    const blank = { width, height, data: new Uint8Array(width * height) };
    const people = await this.ready();
    if (mine !== this.turn) return;
    let found = null;
    if (people) {
      this.say(words.finding);
      found = await people.outline(photo).catch((error) => {
        console.warn(error.message);
        giveUp();
        return null;
      });
    }
    if (mine !== this.turn) return;
    const mask = found?.data ? { width, height, data: found.data } : blank;
    this.show(photo, mask, found ? doubts(found, this.name, photo) : [], found?.data ? "look" : "add");
    if (!found) this.say(words.brush_only);
    else this.say(found.data ? words.found : "");
  }

  show(photo, mask, codes, tool) {
    this.retake.hidden = !codes.length;
    this.retake.querySelector("p").textContent = words.retake;
    this.retake.querySelector("ul").replaceChildren(
      ...codes.map((code) => {
        const item = document.createElement("li");
        item.dataset.finding = code;
        item.textContent = words.findings[code];
        return item;
      }),
    );
    this.sight.hidden = false;
    this.card.dataset.state = "open";
    this.editor.open(photo, mask, tool);
    this.measure();
  }

  /** How many pixels the person covers, for whoever reads the page without seeing it. */
  measure() {
    this.sight.dataset.pixels = area(this.editor.mask);
  }

  remove() {
    this.turn += 1;
    this.editor.close();
    this.sight.hidden = true;
    delete this.card.dataset.state;
  }

  /** The outline to send; null where there is none. */
  get mask() {
    const { mask } = this.editor;
    return mask && area(mask) ? mask : null;
  }
}

/** All that is sent: the outlines in black and white, what is worn, the camera's place, the token. */
async function outlines(chosen) {
  const body = new FormData();
  for (const field of ["csrf_token", "worn", "camera_distance", "camera_height"]) {
    body.set(field, form.elements[field].value);
  }
  for (const { name, mask, frame } of chosen) {
    const part = cut(mask, frame);
    body.set(name, await toPng(blackAndWhite(part), part.width, part.height), `${name}.png`);
  }
  return body;
}

const views = [...form.querySelectorAll(".view")].map((card) => new View(card));
const status = form.querySelector(".form-status");

function say(text, isFault = false) {
  status.textContent = text;
  status.classList.toggle("fault", isFault);
}

/** Takes over what the server says at the photos and at the fields, and goes to the first. */
function takeOver(page) {
  const selectors = [
    ...views.map(({ name }) => `.view[data-view="${name}"] .view-status`),
    ...[...form.querySelectorAll(".setup [id$=-fault]")].map(({ id }) => `#${id}`),
  ];
  let first = null;
  for (const selector of selectors) {
    const [here, there] = [document, page].map((where) => where.querySelector(selector));
    const text = there?.textContent ?? "";
    here.textContent = text;
    here.classList.toggle("fault", Boolean(text));
    if (text) first ??= here;
  }
  first?.scrollIntoView({ block: "center" });
  return Boolean(first);
}

async function compare(refine) {
  const chosen = views
    .filter(({ mask }) => mask)
    .map(({ name, mask, editor: { photo } }) => ({
      name,
      photo,
      mask,
      // A little around the person, but what is cut by the photo's rim stays cut.
      frame: grown(bounds(mask), AROUND, mask),
    }));
  if (!chosen.length) {
    say(words.nothing, true);
    return;
  }
  say(words.comparing);
  const body = await outlines(chosen);
  if (refine) body.set("refine", "1");
  const response = await fetch(form.action, {
    method: "POST",
    body,
    headers: { Accept: "text/html" },
  });
  const page = new DOMParser().parseFromString(await response.text(), "text/html");
  if (takeOver(page) || !response.ok) {
    say(response.ok || response.status < 500 ? "" : words.failed, true);
    return;
  }
  say("");
  results.replaceChildren(...page.getElementById("results").childNodes);
  for (const element of results.querySelectorAll(".result")) {
    await enliven(
      element,
      chosen.find(({ name }) => name === element.dataset.view),
    );
  }
  for (const element of results.querySelectorAll("[data-scripted]")) element.hidden = false;
  (results.querySelector(".changes") ?? results).scrollIntoView();
  results.focus({ preventScroll: true });
}

form.addEventListener("submit", async (event) => {
  event.preventDefault();
  const button = event.submitter ?? form.querySelector("[type=submit]");
  button.disabled = true;
  try {
    await compare(button.name === "refine");
  } catch (error) {
    console.warn(error);
    say(words.failed, true);
  } finally {
    button.disabled = false;
  }
});
