/**
 * The comparison, made livelier: the photo itself, which the server has not, is put where its
 * outline stands, and a slider leads from it to the body.
 */

import { cutOut } from "./mask.js";

/**
 * The photo on the sheet on which both outlines lie, without what is not the person.
 *
 * @param {ImageBitmap} photo
 * @param {{width: number, height: number, data: Uint8Array}} mask
 * @param {{left: number, top: number, scale: number}} place a pixel (x, y) of the sheet lies at
 *   left + scale x, top + scale y of the photo
 */
function onSheet(photo, mask, { left, top, scale }, { width, height }, backdrop) {
  const person = document.createElement("canvas");
  person.width = mask.width;
  person.height = mask.height;
  const context = person.getContext("2d");
  context.drawImage(photo, 0, 0);
  const pixels = context.getImageData(0, 0, mask.width, mask.height);
  cutOut(pixels.data, mask);
  context.putImageData(pixels, 0, 0);
  const sheet = document.createElement("canvas");
  sheet.width = width;
  sheet.height = height;
  const drawing = sheet.getContext("2d");
  drawing.fillStyle = backdrop;
  drawing.fillRect(0, 0, width, height);
  drawing.setTransform(1 / scale, 0, 0, 1 / scale, -left / scale, -top / scale);
  drawing.imageSmoothingQuality = "high";
  drawing.drawImage(person, 0, 0);
  return sheet;
}

async function loaded(image) {
  await image.decode();
  return image;
}

/**
 * @param {HTMLElement} element one comparison, as the server wrote it
 * @param {{photo: ImageBitmap | null, mask: object, frame: {left: number, top: number}}} sent what
 *   the outline was made from, and where on the photo its picture began
 */
export async function enliven(element, { photo, mask, frame }) {
  const picture = (name) => element.querySelector(`[data-picture="${name}"]`);
  const { left, top, scale } = element.dataset;
  const avatar = await loaded(picture("avatar"));
  let mine = await loaded(picture("photo"));
  const { naturalWidth: width, naturalHeight: height } = avatar;
  if (photo) {
    const place = {
      left: Number(left) + frame.left,
      top: Number(top) + frame.top,
      scale: Number(scale),
    };
    const backdrop = getComputedStyle(mine).backgroundColor;
    const sheet = onSheet(photo, mask, place, { width, height }, backdrop);
    sheet.setAttribute("role", "img");
    sheet.setAttribute("aria-label", mine.alt);
    sheet.dataset.picture = "photo";
    mine.replaceWith(sheet);
    mine = sheet;
  }
  const blend = element.querySelector(".blend");
  const canvas = blend.querySelector("canvas");
  const slider = blend.querySelector("input");
  const context = canvas.getContext("2d");
  [canvas.width, canvas.height] = [width, height];
  function draw() {
    context.globalAlpha = 1;
    context.drawImage(mine, 0, 0);
    context.globalAlpha = Number(slider.value) / 100;
    context.drawImage(avatar, 0, 0);
  }
  slider.addEventListener("input", draw);
  draw();
  blend.hidden = false;
}
