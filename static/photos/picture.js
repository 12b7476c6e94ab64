/** Photos as the shopper chose them: told apart by their first bytes, upright, not too large. */

/** What a browser is asked to hold of a photo: a person's outline needs no more. Pixels. */
const TALLEST = 1440;
const WIDEST = 1920;

/** Brands of the ISO base media file format (ISO/IEC 23008-12) that telephones write as HEIC. */
const HEIC = new Set(["heic", "heix", "heim", "heis", "hevc", "hevx", "mif1", "msf1"]);

/** A file that cannot be used; `code` is a key of the page's words. */
export class Unusable extends Error {
  constructor(code) {
    super(code);
    this.code = code;
  }
}

/**
 * What a file is by its first bytes: "jpeg", "png", "webp", "heic" or null.
 *
 * @param {Uint8Array} bytes at least the first twelve
 */
function kindOf(bytes) {
  const letters = (from, to) => String.fromCharCode(...bytes.subarray(from, to));
  if (bytes[0] === 0xff && bytes[1] === 0xd8 && bytes[2] === 0xff) return "jpeg";
  if (letters(0, 8) === "\x89PNG\r\n\x1a\n") return "png";
  if (letters(0, 4) === "RIFF" && letters(8, 12) === "WEBP") return "webp";
  if (letters(4, 8) === "ftyp" && HEIC.has(letters(8, 12))) return "heic";
  return null;
}

/** The size, never larger than it was, at which a photo is looked at. */
function fittedSize({ width, height }) {
  const scale = Math.min(1, TALLEST / height, WIDEST / width);
  const [across, down] = [width, height].map((size) => Math.max(1, Math.round(size * scale)));
  return { width: across, height: down };
}

/**
 * A chosen file as a picture, upright as its camera was held.
 *
 * @param {Blob} file
 * @returns {Promise<ImageBitmap>}
 * @throws {Unusable} "wrong_type", "heic" or "unreadable"
 */
export async function readPicture(file) {
  const kind = kindOf(new Uint8Array(await file.slice(0, 12).arrayBuffer()));
  if (!kind) throw new Unusable("wrong_type");
  let whole;
  try {
    whole = await createImageBitmap(file, { imageOrientation: "from-image" });
  } catch {
    throw new Unusable(kind === "heic" ? "heic" : "unreadable");
  }
  return fitted(whole);
}

/** The picture at the size at which it is looked at. */
export async function fitted(picture) {
  const { width, height } = fittedSize(picture);
  if (width === picture.width) return picture;
  const options = { resizeWidth: width, resizeHeight: height, resizeQuality: "high" };
  const smaller = await createImageBitmap(picture, options);
  picture.close();
  return smaller;
}

/** The values of a picture's pixels, four each, as ImageData. */
export function pixelsOf(picture) {
  const canvas = document.createElement("canvas");
  canvas.width = picture.width;
  canvas.height = picture.height;
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.drawImage(picture, 0, 0);
  return context.getImageData(0, 0, picture.width, picture.height);
}

/** Four values a pixel as a PNG file. */
export function toPng(colours, width, height) {
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  canvas.getContext("2d").putImageData(new ImageData(colours, width, height), 0, 0);
  return new Promise((resolve, reject) => {
    canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Unusable("unreadable"))), "image/png");
  });
}
