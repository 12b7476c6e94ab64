/**
 * Arithmetic on outlines of a person in a picture. No page, no browser: tested as it is.
 *
 * A picture's values lie row by row from its top left corner. A *mask* is `{width, height, data}`
 * with 1 in `data` (Uint8Array) where the person is and 0 elsewhere; a *confidence* has numbers
 * from 0 to 1 (Float32Array) in their place.
 */

/** The values of a picture whose left and right are exchanged. */
export function mirrored({ width, height, data }) {
  const turned = new data.constructor(data.length);
  for (let row = 0; row < height; row += 1) {
    turned.set(data.subarray(row * width, (row + 1) * width).toReversed(), row * width);
  }
  return { width, height, data: turned };
}

/** The mean of two confidences of the same picture. */
export function averaged(one, other) {
  const data = new Float32Array(one.data.length);
  for (let i = 0; i < data.length; i += 1) data[i] = (one.data[i] + other.data[i]) / 2;
  return { ...one, data };
}

/** Where a confidence is at least a half. */
export function thresholded({ width, height, data }, least = 0.5) {
  const inside = new Uint8Array(data.length);
  for (let i = 0; i < data.length; i += 1) inside[i] = data[i] >= least ? 1 : 0;
  return { width, height, data: inside };
}

/** How far two masks agree: what both cover as a share of what either covers; 0 for none. */
export function overlap(one, other) {
  let both = 0;
  let either = 0;
  for (let i = 0; i < one.data.length; i += 1) {
    both += one.data[i] & other.data[i];
    either += one.data[i] | other.data[i];
  }
  return either ? both / either : 0;
}

/** How many pixels the person covers. */
export function area({ data }) {
  let sum = 0;
  for (let i = 0; i < data.length; i += 1) sum += data[i];
  return sum;
}

/**
 * The smallest box around the person, in pixels: `{left, top, right, bottom}`, the last two
 * outside; null where there is none.
 */
export function bounds({ width, height, data }) {
  let [left, top, right, bottom] = [width, height, 0, 0];
  for (let row = 0; row < height; row += 1) {
    const line = data.subarray(row * width, (row + 1) * width);
    const first = line.indexOf(1);
    if (first < 0) continue;
    top = Math.min(top, row);
    bottom = row + 1;
    left = Math.min(left, first);
    right = Math.max(right, line.lastIndexOf(1) + 1);
  }
  return right ? { left, top, right, bottom } : null;
}

/**
 * Regions of pixels with one value that touch at their sides.
 *
 * @returns {{labels: Int32Array, regions: {area: number, atRim: boolean}[]}} for each pixel the
 *   place of its region in `regions`, or -1 where its value is another
 */
function regionsOf({ width, height, data }, value) {
  const labels = new Int32Array(data.length).fill(-1);
  const regions = [];
  const waiting = new Int32Array(data.length);
  for (let seed = 0; seed < data.length; seed += 1) {
    if (data[seed] !== value || labels[seed] >= 0) continue;
    const region = { area: 0, atRim: false };
    const label = regions.push(region) - 1;
    let ahead = 0;
    let found = 1;
    waiting[0] = seed;
    labels[seed] = label;
    const visit = (pixel) => {
      if (data[pixel] !== value || labels[pixel] >= 0) return;
      labels[pixel] = label;
      waiting[found] = pixel;
      found += 1;
    };
    while (ahead < found) {
      const pixel = waiting[ahead];
      ahead += 1;
      const column = pixel % width;
      const row = (pixel - column) / width;
      if (column === 0 || row === 0 || column === width - 1 || row === height - 1) {
        region.atRim = true;
      }
      if (column > 0) visit(pixel - 1);
      if (column < width - 1) visit(pixel + 1);
      if (row > 0) visit(pixel - width);
      if (row < height - 1) visit(pixel + width);
    }
    region.area = found;
  }
  return { labels, regions };
}

/** The mask's largest region alone: specks and bystanders' hands go. */
export function largestRegion(mask) {
  const { labels, regions } = regionsOf(mask, 1);
  const largest = regions.reduce((best, region, i) => (region.area > regions[best].area ? i : best), 0);
  const data = new Uint8Array(labels.length);
  for (let i = 0; i < data.length; i += 1) data[i] = labels[i] === largest ? 1 : 0;
  return { ...mask, data };
}

/** The mask without holes smaller than `most` pixels: the gap between arm and waist stays. */
export function withoutPinholes(mask, most) {
  const { labels, regions } = regionsOf(mask, 0);
  const filled = regions.map((region) => !region.atRim && region.area <= most);
  const data = mask.data.slice();
  for (let i = 0; i < data.length; i += 1) if (labels[i] >= 0 && filled[labels[i]]) data[i] = 1;
  return { ...mask, data };
}

/**
 * Sums over squares of `2 radius + 1` pixels, cut at the picture's rim.
 *
 * Each row, then each column, is run over once, whatever the radius.
 */
function boxSums(values, width, height, radius) {
  const across = new Float64Array(values.length);
  for (let row = 0; row < height; row += 1) {
    const at = row * width;
    let sum = 0;
    for (let column = 0; column < Math.min(radius, width); column += 1) sum += values[at + column];
    for (let column = 0; column < width; column += 1) {
      if (column + radius < width) sum += values[at + column + radius];
      if (column - radius > 0) sum -= values[at + column - radius - 1];
      across[at + column] = sum;
    }
  }
  const sums = new Float64Array(values.length);
  const running = new Float64Array(width);
  for (let row = -radius; row < height; row += 1) {
    const entering = row + radius;
    const leaving = row - radius - 1;
    for (let column = 0; column < width; column += 1) {
      if (entering < height) running[column] += across[entering * width + column];
      if (leaving >= 0) running[column] -= across[leaving * width + column];
      if (row >= 0) sums[row * width + column] = running[column];
    }
  }
  return sums;
}

/**
 * A confidence whose edge follows the edges of the photo's colours.
 *
 * The guided filter of K. He, J. Sun and X. Tang, "Guided image filtering", IEEE Transactions on
 * Pattern Analysis and Machine Intelligence 35 (2013) 1397-1409, with a colour guide (their
 * equations 14 to 16): within every square the confidence is a linear function of the colours.
 *
 * @param {{width: number, height: number, data: Float32Array}} confidence
 * @param {Uint8ClampedArray} colours red, green, blue and alpha of each pixel, 0 to 255
 * @param {number} radius of the square, pixels
 * @param {number} smoothness how much colours must differ to count, on a scale of 0 to 1, squared
 */
export function guided({ width, height, data }, colours, radius = 6, smoothness = 1e-4) {
  const count = data.length;
  const channel = (offset) => {
    const values = new Float32Array(count);
    for (let i = 0; i < count; i += 1) values[i] = colours[4 * i + offset] / 255;
    return values;
  };
  const product = (one, other) => {
    const values = new Float32Array(count);
    for (let i = 0; i < count; i += 1) values[i] = one[i] * other[i];
    return values;
  };
  const cover = boxSums(new Float32Array(count).fill(1), width, height, radius);
  const mean = (values) => {
    const sums = boxSums(values, width, height, radius);
    for (let i = 0; i < count; i += 1) sums[i] /= cover[i];
    return sums;
  };
  const [r, g, b] = [channel(0), channel(1), channel(2)];
  const [mr, mg, mb, mp] = [mean(r), mean(g), mean(b), mean(data)];
  const [rr, rg, rb] = [mean(product(r, r)), mean(product(r, g)), mean(product(r, b))];
  const [gg, gb, bb] = [mean(product(g, g)), mean(product(g, b)), mean(product(b, b))];
  const [pr, pg, pb] = [mean(product(r, data)), mean(product(g, data)), mean(product(b, data))];
  for (let i = 0; i < count; i += 1) {
    // The covariance matrix of the colours, symmetric, and its inverse by cofactors.
    const xx = rr[i] - mr[i] * mr[i] + smoothness;
    const xy = rg[i] - mr[i] * mg[i];
    const xz = rb[i] - mr[i] * mb[i];
    const yy = gg[i] - mg[i] * mg[i] + smoothness;
    const yz = gb[i] - mg[i] * mb[i];
    const zz = bb[i] - mb[i] * mb[i] + smoothness;
    const [cx, cy, cz] = [yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy];
    const determinant = xx * cx + xy * cy + xz * cz;
    const u = pr[i] - mr[i] * mp[i];
    const v = pg[i] - mg[i] * mp[i];
    const w = pb[i] - mb[i] * mp[i];
    const ar = (cx * u + cy * v + cz * w) / determinant;
    const ag = (cy * u + (xx * zz - xz * xz) * v + (xy * xz - xx * yz) * w) / determinant;
    const ab = (cz * u + (xy * xz - xx * yz) * v + (xx * yy - xy * xy) * w) / determinant;
    mp[i] -= ar * mr[i] + ag * mg[i] + ab * mb[i];
    [pr[i], pg[i], pb[i]] = [ar, ag, ab];
  }
  const [ar, ag, ab, rest] = [mean(pr), mean(pg), mean(pb), mean(mp)];
  const tidy = new Float32Array(count);
  for (let i = 0; i < count; i += 1) {
    tidy[i] = Math.min(1, Math.max(0, ar[i] * r[i] + ag[i] * g[i] + ab[i] * b[i] + rest[i]));
  }
  return { width, height, data: tidy };
}

/** A part of a picture with so many values a pixel. */
export function cut({ width, data }, { left, top, right, bottom }, values = 1) {
  const across = (right - left) * values;
  const part = new data.constructor(across * (bottom - top));
  for (let row = top; row < bottom; row += 1) {
    const from = (row * width + left) * values;
    part.set(data.subarray(from, from + across), (row - top) * across);
  }
  return { width: right - left, height: bottom - top, data: part };
}

/** The picture with a part laid over it at the box's corner. */
export function pasted(picture, part, { left, top }) {
  const data = picture.data.slice();
  for (let row = 0; row < part.height; row += 1) {
    const line = part.data.subarray(row * part.width, (row + 1) * part.width);
    data.set(line, (top + row) * picture.width + left);
  }
  return { ...picture, data };
}

/** A box grown by a margin on all sides, within a picture. */
export function grown({ left, top, right, bottom }, margin, { width, height }) {
  return {
    left: Math.max(0, left - margin),
    top: Math.max(0, top - margin),
    right: Math.min(width, right + margin),
    bottom: Math.min(height, bottom + margin),
  };
}

/** The radius of the filter's square, as a share of the figure's height. */
const EDGE = 0.006;
/** Confidences between this and its rest to one are the edge. */
const UNSURE = 0.02;
/** Holes smaller than this share of the figure are noise of the network. */
const PINHOLE = 0.0004;

/**
 * The outline of one person: the largest region of a confidence, tidied along the photo's edges.
 *
 * @param {{width: number, height: number, data: Float32Array}} confidence
 * @param {Uint8ClampedArray} colours of the photo, four values a pixel
 */
export function outlined(confidence, colours) {
  const rough = largestRegion(thresholded(confidence));
  const box = bounds(rough);
  if (!box) return rough;
  const radius = Math.max(3, Math.round(EDGE * (box.bottom - box.top)));
  const frame = grown(box, 4 * radius, confidence);
  const near = cut(confidence, frame);
  const colour = cut({ ...confidence, data: colours }, frame, 4);
  const tidy = guided(near, colour.data, radius);
  // Only the edge is the filter's: what the network is sure of stays as it is.
  const data = near.data.slice();
  for (let i = 0; i < data.length; i += 1) {
    if (data[i] > UNSURE && data[i] < 1 - UNSURE) data[i] = tidy.data[i];
  }
  const blank = { ...confidence, data: new Float32Array(confidence.data.length) };
  const person = largestRegion(thresholded(pasted(blank, { ...near, data }, frame)));
  return withoutPinholes(person, PINHOLE * area(person));
}

/**
 * A person's mask in the pixels of a silhouette file: what is light, or, where the file has
 * transparent parts, what is not transparent.
 *
 * @param {{width: number, height: number, data: Uint8ClampedArray}} picture four values a pixel
 */
export function silhouetteIn({ width, height, data: colours }) {
  const data = new Uint8Array(width * height);
  let clear = false;
  for (let i = 3; i < colours.length && !clear; i += 4) clear = colours[i] < 128;
  for (let i = 0; i < data.length; i += 1) {
    // The weights of ITU-R BT.601.
    const light = 0.299 * colours[4 * i] + 0.587 * colours[4 * i + 1] + 0.114 * colours[4 * i + 2];
    data[i] = (clear ? colours[4 * i + 3] : light) >= 128 ? 1 : 0;
  }
  return { width, height, data };
}

/** White where the person is, black elsewhere: four values a pixel. */
export function blackAndWhite({ width, height, data }) {
  const colours = new Uint8ClampedArray(4 * width * height);
  for (let i = 0; i < data.length; i += 1) {
    colours.fill(data[i] ? 255 : 0, 4 * i, 4 * i + 3);
    colours[4 * i + 3] = 255;
  }
  return colours;
}

/** Makes what is not the person transparent, in four values a pixel. */
export function cutOut(colours, { data }) {
  for (let i = 0; i < data.length; i += 1) if (!data[i]) colours[4 * i + 3] = 0;
}
