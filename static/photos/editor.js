/** A photo with its outline drawn over it, and the brush that mends the outline. */

import { Painting } from "./brush.js";

/** The veil over what is not the person, and the line around it: red, green, blue, alpha. */
const VEIL = [16, 22, 24, 150];
const LINE = [255, 214, 64, 255];
const BACKDROP = "#5b6468";
/** How far an arrow key moves the brush, as a share of its size. */
const STEP = 0.5;

/**
 * @param {HTMLElement} element holds a canvas, buttons with `data-tool`, `data-undo` and
 *   `data-reset`, and a range input with `data-size`
 * @param {() => void} changed called after each change of the outline
 */
export function createEditor(element, changed) {
  const canvas = element.querySelector("canvas");
  const context = canvas.getContext("2d");
  const cover = document.createElement("canvas");
  const tools = [...element.querySelectorAll("[data-tool]")];
  const [undo, reset] = ["undo", "reset"].map((name) => element.querySelector(`[data-${name}]`));
  const size = element.querySelector("[data-size]");
  let photo = null;
  let painting = null;
  let tool = "look";
  let pen = null; // where the brush is, in pixels of the photo; null when it is away
  let drawing = false;
  let due = 0;

  const radius = () => (Number(size.value) / 1000) * painting.mask.height;

  function choose(name) {
    tool = name;
    for (const button of tools) {
      button.setAttribute("aria-pressed", String(button.dataset.tool === name));
    }
    // With a brush in the hand a finger paints; two fingers still enlarge the page.
    canvas.dataset.brush = name;
    draw();
  }

  function draw() {
    due ||= requestAnimationFrame(() => {
      due = 0;
      if (painting) paint();
    });
  }

  function paint() {
    const { width, height } = canvas;
    if (photo) context.drawImage(photo, 0, 0);
    else {
      context.fillStyle = BACKDROP;
      context.fillRect(0, 0, width, height);
    }
    context.drawImage(cover, 0, 0);
    if (!pen || tool === "look") return;
    context.beginPath();
    context.arc(pen.x, pen.y, radius(), 0, 2 * Math.PI);
    const thin = Math.max(1, width / 400);
    for (const [colour, line] of [["#101618", 3 * thin], ["#ffffff", thin]]) {
      context.strokeStyle = colour;
      context.lineWidth = line;
      context.stroke();
    }
  }

  /** The veil and the line anew, within a part of the picture. */
  function veil(left = 0, top = 0, right = canvas.width, bottom = canvas.height) {
    const { mask } = painting;
    const thick = Math.max(1, Math.round(mask.height / 500));
    const box = {
      left: Math.max(0, Math.floor(left) - thick),
      top: Math.max(0, Math.floor(top) - thick),
      right: Math.min(mask.width, Math.ceil(right) + thick),
      bottom: Math.min(mask.height, Math.ceil(bottom) + thick),
    };
    if (box.right <= box.left || box.bottom <= box.top) return;
    const part = new ImageData(box.right - box.left, box.bottom - box.top);
    const inside = (x, y) =>
      x >= 0 && y >= 0 && x < mask.width && y < mask.height && mask.data[y * mask.width + x];
    for (let y = box.top, at = 0; y < box.bottom; y += 1) {
      for (let x = box.left; x < box.right; x += 1, at += 4) {
        if (!inside(x, y)) part.data.set(VEIL, at);
        else if (
          !inside(x - thick, y) ||
          !inside(x + thick, y) ||
          !inside(x, y - thick) ||
          !inside(x, y + thick)
        ) {
          part.data.set(LINE, at);
        }
      }
    }
    cover.getContext("2d").putImageData(part, box.left, box.top);
    undo.disabled = !painting.painted;
    draw();
  }

  function stroke(from, to) {
    painting.draw(from, to, radius(), tool === "add" ? 1 : 0);
    veil(
      Math.min(from.x, to.x) - radius(),
      Math.min(from.y, to.y) - radius(),
      Math.max(from.x, to.x) + radius(),
      Math.max(from.y, to.y) + radius(),
    );
  }

  function place({ clientX, clientY }) {
    const shown = canvas.getBoundingClientRect();
    return {
      x: ((clientX - shown.left) / shown.width) * canvas.width,
      y: ((clientY - shown.top) / shown.height) * canvas.height,
    };
  }

  canvas.addEventListener("pointerdown", (event) => {
    if (!painting || tool === "look" || !event.isPrimary || event.button > 0) return;
    canvas.setPointerCapture(event.pointerId);
    drawing = true;
    pen = place(event);
    painting.begin();
    stroke(pen, pen);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!painting || tool === "look" || !event.isPrimary) return;
    const before = pen;
    pen = place(event);
    if (drawing) stroke(before ?? pen, pen);
    draw();
  });
  for (const end of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(end, () => {
      if (drawing) changed();
      drawing = false;
    });
  }
  canvas.addEventListener("pointerleave", () => {
    if (!drawing) pen = null;
    draw();
  });

  // By keyboard: arrows move the brush, space or enter dabs, and arrows with shift draw.
  canvas.addEventListener("keydown", (event) => {
    if (!painting || tool === "look") return;
    const from = pen ?? { x: canvas.width / 2, y: canvas.height / 2 };
    const [x, y] =
      { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key] ??
      [];
    if (x !== undefined) {
      const step = STEP * radius();
      pen = {
        x: Math.min(canvas.width, Math.max(0, from.x + x * step)),
        y: Math.min(canvas.height, Math.max(0, from.y + y * step)),
      };
      if (event.shiftKey) dab(from, pen);
    } else if (event.key === " " || event.key === "Enter") {
      pen = from;
      dab(pen, pen);
    } else return;
    event.preventDefault();
    draw();
  });

  function dab(from, to) {
    painting.begin();
    stroke(from, to);
    changed();
  }

  for (const button of tools) button.addEventListener("click", () => choose(button.dataset.tool));
  undo.addEventListener("click", () => {
    painting.undo();
    veil();
    changed();
  });
  reset.addEventListener("click", () => {
    painting.reset();
    veil();
    changed();
  });
  size.addEventListener("input", draw);

  return {
    /** Shows a photo (or none) with an outline over it. */
    open(picture, mask, firstTool = "look") {
      photo?.close?.();
      photo = picture;
      painting = new Painting(mask);
      for (const each of [canvas, cover]) {
        each.width = mask.width;
        each.height = mask.height;
      }
      pen = null;
      veil();
      choose(firstTool);
    },
    close() {
      photo?.close?.();
      photo = null;
      painting = null;
    },
    /** The outline as it is now; null when nothing is open. */
    get mask() {
      return painting?.mask ?? null;
    },
    get photo() {
      return photo;
    },
  };
}
