/**
 * What is written over the view in 3D: the names and numbers of the tapes with lines to them,
 * heights beside the body, and a ruler. Hidden from screen readers, which have the page's tables.
 */

import { words } from "./numbers.js";
import { column, sides } from "./labels.js";
import { marks } from "./ruler.js";

const SVG = "http://www.w3.org/2000/svg";
const EDGE = 8; // pixels that stay free around
const RULER = 46; // the ruler's width
const NARROW = 480; // pixels of width in which the ruler's marks lie under the labels
const NEAR_MIDDLE = 0.04; // of the width: what points there may stand on either side
const SEEN = 0.05; // how far a surface must be turned towards the reader to be seen

export class Overlay {
  #viewer;
  #layer = document.createElement("div");
  #drawing = document.createElementNS(SVG, "svg");
  #lines;
  #scale;
  #scaleMarks;
  #scaleTexts = [];
  #labels = new Map(); // name to {element, value, note, side, its width and height within a width of the view}
  #rows = [];
  #ruler = null; // {units, text} where it is shown

  constructor(element, viewer) {
    this.#viewer = viewer;
    this.#layer.className = "overlay";
    this.#layer.setAttribute("aria-hidden", "true");
    this.#scale = svg("g", { class: "ruler" });
    this.#scaleMarks = svg("path", {});
    this.#scale.append(this.#scaleMarks);
    this.#lines = svg("g", {});
    this.#drawing.append(this.#scale, this.#lines);
    this.#layer.append(this.#drawing);
    element.append(this.#layer);
    element.addEventListener("frame", () => this.update());
    element.addEventListener("rest", () => this.#settle());
  }

  /** Name the tapes of some rows of the API's answer, in place of those before. */
  name(rows) {
    for (const { element } of this.#labels.values()) element.remove();
    this.#labels.clear();
    this.#lines.replaceChildren();
    for (const row of rows) {
      const [element, name, value, note] = ["div", "strong", "span", "span"].map((tag) =>
        document.createElement(tag),
      );
      element.className = row.asked === null ? "tape-label" : "tape-label of-entered";
      element.dataset.tape = row.name;
      name.textContent = row.label;
      value.className = "tape-value";
      note.className = "tape-note";
      element.append(name, value, note);
      this.#layer.append(element);
      this.#labels.set(row.name, { element, value, note, ...this.#drawn(row) });
    }
    this.tell(rows);
    this.#settle();
  }

  /** New numbers for the tapes that are named. */
  tell(rows) {
    this.#rows = rows;
    for (const row of rows) {
      const label = this.#labels.get(row.name);
      if (!label) continue;
      const { value, note } = words(row);
      // Figures are all of one width: only more or fewer of them make a label another size.
      const written = `${value.length} ${note.length}`;
      if (written !== label.written) label.width = 0;
      label.written = written;
      label.value.textContent = value;
      label.note.textContent = note;
    }
  }

  /** Show a ruler, or none. */
  measure(ruler) {
    this.#ruler = ruler;
    this.#settle();
  }

  /** Follow the camera and the body. */
  update() {
    const { width, height } = this.#viewer.size;
    this.#updateRuler(width, height);
    if (!this.#labels.size && !this.#ruler) return;
    // All sizes before anything is written: each reading after that would lay the page out anew.
    for (const label of this.#labels.values()) {
      if (label.within !== width) [label.within, label.width] = [width, 0];
      if (label.width) continue;
      label.width = label.element.offsetWidth;
      label.height = label.element.offsetHeight;
    }
    this.#drawing.setAttribute("viewBox", `0 0 ${width} ${height}`);
    const seen = this.#see(width);
    for (const side of ["left", "right"]) this.#place(side, seen, width, height);
  }

  // ---- labels ----

  /** Deal the labels to the two sides anew, once the view has come to rest. */
  #settle() {
    const { width } = this.#viewer.size;
    const seen = [...this.#see(width).entries()].sort(([, a], [, b]) => a.y - b.y);
    const across = seen.map(([, { x }]) => x);
    sides(across, width / 2, NEAR_MIDDLE * width).forEach((side, i) => {
      this.#labels.get(seen[i][0]).side = side;
    });
    this.update();
  }

  /** Where each tape is on the screen: its middle, the points of it that are seen, or its ends. */
  #see(width) {
    const result = new Map();
    for (const { name, kind, points, normals } of this.#viewer.laid) {
      if (!this.#labels.has(name)) continue;
      if (kind === "height") {
        const ends = points.map(([, y]) => this.#viewer.see([0, y, 0]));
        result.set(name, { ends, x: width / 2, y: (ends[0].y + ends[1].y) / 2, hidden: false });
        continue;
      }
      const all = points.map((point, i) => this.#viewer.see(point, normals[i]));
      const shown = all.filter(({ front }) => front > SEEN);
      const points2d = shown.length ? shown : all;
      const mean = (axis) =>
        points2d.reduce((sum, point) => sum + point[axis], 0) / Math.max(points2d.length, 1);
      result.set(name, { points: points2d, x: mean("x"), y: mean("y"), hidden: !shown.length });
    }
    // What has no tape, as weight, is told at the feet.
    for (const name of this.#labels.keys()) {
      if (!result.get(name)?.points?.length && !result.get(name)?.ends) {
        const { x, y } = this.#viewer.see([0, 0, 0]);
        result.set(name, { points: [], x, y, hidden: false });
      }
    }
    return result;
  }

  #place(side, seen, width, height) {
    const own = [...seen].filter(([name]) => this.#labels.get(name).side === side);
    const wanted = own.map(([name, { y }]) => ({ wanted: y, height: this.#labels.get(name).height }));
    const middles = column(wanted, EDGE, height - EDGE);
    const inset = EDGE + (side === "left" && this.#ruler && width > NARROW ? RULER : 0);
    let heights = 0;
    own.forEach(([name, { points, ends, hidden }], i) => {
      const { element, line, guide, width: wide, height: tall } = this.#labels.get(name);
      const left = side === "left" ? inset : width - inset - wide;
      element.style.transform = `translate(${left}px, ${Math.round(middles[i] - tall / 2)}px)`;
      element.classList.toggle("behind", hidden);
      line.classList.toggle("behind", hidden);
      const start = side === "left" ? left + wide : left;
      const inwards = side === "left" ? 1 : -1;
      if (ends) {
        heights += 1;
        const x = start + inwards * (6 + 7 * heights);
        line.setAttribute("d", dimension(start, middles[i], x, ends));
        guide.setAttribute("d", ends.map(({ y }) => `M${x} ${y}L${width / 2} ${y}`).join(""));
        return;
      }
      const target = points.reduce(
        (best, point) => (best && inwards * (best.x - point.x) <= 0 ? best : point),
        null,
      );
      line.setAttribute("d", target ? `M${start} ${middles[i]}L${target.x} ${target.y}` : "");
    });
  }

  /** The lines of a label: to its tape, and from a height to the body. */
  #drawn({ asked }) {
    const name = asked === null ? "leader" : "leader of-entered";
    const [guide, line] = [svg("path", { class: `${name} guide` }), svg("path", { class: name })];
    this.#lines.append(guide, line);
    return { guide, line };
  }

  // ---- the ruler ----

  #updateRuler(width, height) {
    this.#scale.style.display = this.#ruler ? "" : "none";
    if (!this.#ruler) return;
    const { units, top, text } = this.#ruler;
    const shown = marks(units, top + 0.1);
    const at = (y) => this.#viewer.see([0, y, 0]).y;
    const crown = at(top);
    const written = crown < 16 ? crown + 10 : crown - 10; // beside its line, within the view
    let path = "";
    const texts = [];
    for (const { height: y, long, label } of shown) {
      const place = at(y);
      if (place < 0 || place > height) continue;
      path += `M0 ${place}h${long ? 14 : 7}`;
      if (long && Math.abs(place - written) > 14) texts.push([18, place, label, ""]);
    }
    path += `M0 ${crown}h${width / 2}`;
    texts.push([18, written, text, "crown"]);
    this.#scaleMarks.setAttribute("d", path);
    while (this.#scaleTexts.length < texts.length) {
      const element = svg("text", {});
      this.#scaleTexts.push(element);
      this.#scale.append(element);
    }
    this.#scaleTexts.forEach((element, i) => {
      const [x, y, words, name] = texts[i] ?? [0, 0, "", ""];
      element.setAttribute("x", x);
      element.setAttribute("y", y);
      element.setAttribute("class", name);
      if (element.textContent !== words) element.textContent = words;
    });
  }
}

/** A height beside the body: a line with a tick at each end, led to from its label. */
function dimension(start, middle, x, [top, bottom]) {
  const ticks = [top, bottom].map(({ y }) => `M${x - 4} ${y}h8`).join("");
  return `M${start} ${middle}L${x} ${(top.y + bottom.y) / 2}M${x} ${top.y}V${bottom.y}${ticks}`;
}

function svg(name, attributes) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  return element;
}
