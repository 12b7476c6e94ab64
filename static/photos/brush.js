/**
 * An outline that is painted on: strokes that add or erase, taken back one by one. No page.
 *
 * Places are pixels of the mask, from its top left corner.
 */

/** Strokes that can be taken back. */
const REMEMBERED = 60;

export class Painting {
  /** @param {{width: number, height: number, data: Uint8Array}} mask as found; kept for `reset` */
  constructor(mask) {
    this.found = mask.data.slice();
    this.mask = { ...mask, data: mask.data.slice() };
    this.past = [];
  }

  /** Whether there is something to take back. */
  get painted() {
    return this.past.length > 0;
  }

  /** A stroke begins: all that is drawn until the next one is taken back together. */
  begin() {
    this.past.push([]);
    if (this.past.length > REMEMBERED) this.past.shift();
  }

  /**
   * Draws with a round brush along a line.
   *
   * @param {{x: number, y: number}} from
   * @param {{x: number, y: number}} to
   * @param {number} radius pixels
   * @param {0 | 1} value 1 adds to the person, 0 erases
   */
  draw(from, to, radius, value) {
    const { width, height, data } = this.mask;
    const changed = this.past.at(-1);
    const [left, right] = range(from.x, to.x, radius, width);
    const [top, bottom] = range(from.y, to.y, radius, height);
    const [dx, dy] = [to.x - from.x, to.y - from.y];
    const length = dx * dx + dy * dy;
    for (let y = top; y < bottom; y += 1) {
      for (let x = left; x < right; x += 1) {
        const pixel = y * width + x;
        if (data[pixel] === value) continue;
        const [px, py] = [x + 0.5 - from.x, y + 0.5 - from.y];
        const along = length ? Math.min(1, Math.max(0, (px * dx + py * dy) / length)) : 0;
        const [ax, ay] = [px - along * dx, py - along * dy];
        if (ax * ax + ay * ay > radius * radius) continue;
        data[pixel] = value;
        changed.push(pixel);
      }
    }
  }

  /** Takes the last stroke back. Strokes that changed nothing are passed over. */
  undo() {
    while (this.past.length) {
      const changed = this.past.pop();
      for (const pixel of changed) this.mask.data[pixel] ^= 1;
      if (changed.length) return;
    }
  }

  /** The outline as it was found; this too can be taken back. */
  reset() {
    this.begin();
    const { data } = this.mask;
    for (let pixel = 0; pixel < data.length; pixel += 1) {
      if (data[pixel] === this.found[pixel]) continue;
      data[pixel] ^= 1;
      this.past.at(-1).push(pixel);
    }
  }
}

/** The pixels that a brush may touch, along one axis: first, and one after the last. */
function range(from, to, radius, size) {
  return [
    Math.max(0, Math.floor(Math.min(from, to) - radius)),
    Math.min(size, Math.ceil(Math.max(from, to) + radius)),
  ];
}
