/** The tapes that are shown on a body: bands that lie on the skin and go with it as it bends. */

import { BufferAttribute, BufferGeometry, Mesh } from "three";

import { band, outwards, smoothed } from "./bands.js";
import { taped } from "./materials.js";
import { nearest } from "./surface.js";

const WIDTH = 0.011; // metres, as in the guide's pictures
const EDGE = [1, 0.992, 0.98];
/** sRGB: what was entered, and what was not. */
const ENTERED = [0.69, 0.227, 0.149];
const ESTIMATED = [0.06, 0.373, 0.4];

/**
 * One tape on the body.
 *
 * @typedef {object} Laid
 * @property {string} name
 * @property {string} kind girth, length, height or mass
 * @property {number[][]} points where it runs now, in metres
 * @property {number[][]} normals the way that the skin faces there
 */

export class Tapes {
  mesh = new Mesh(corners([], []), taped());
  /** @type {Laid[]} */
  laid = [];
  #paths = []; // of each tape, on the body that it was laid on
  #points = []; // of each, the body's points that it goes with
  #served = new Float32Array(); // the points of the body that they were laid on
  #corners = new Float32Array(); // of the bands, on that body
  #owners = new Uint32Array(); // of each corner, where the point that it goes with begins

  constructor() {
    this.mesh.frustumCulled = false;
    this.mesh.visible = false;
  }

  /**
   * Show the tapes of some rows of the API's answer, in place of those before.
   *
   * @param {{name: string, kind: string, asked: number|null, path: number[][]}[]} rows
   * @param {import("./shape.js").Shape} shape the body that the rows are of
   */
  lay(rows, shape) {
    const find = rows.length ? nearest(shape.served) : null;
    this.#points = rows.map(({ path }) => path.map((point) => find(...point)));
    this.#paths = rows.map(({ path }) => path);
    this.laid = rows.map(({ name, kind, path }, i) => {
      const normals =
        kind === "girth"
          ? outwards(path)
          : smoothed(this.#points[i].map((v) => Array.from(shape.normals.subarray(3 * v, 3 * v + 3))));
      return { name, kind, normals, points: path.map((point) => [...point]) };
    });
    this.#served = shape.served; // another body may come before its tapes do
    this.#build(rows);
    this.follow(shape);
  }

  /** Go with the body: what lies on it moves as the point beneath does. */
  follow({ positions }) {
    const attribute = this.mesh.geometry.getAttribute("position");
    const { array } = attribute;
    const [own, owners, served] = [this.#corners, this.#owners, this.#served];
    for (let at = 0, corner = 0; corner < owners.length; corner += 1) {
      for (let k = owners[corner]; k < owners[corner] + 3; k += 1, at += 1) {
        array[at] = own[at] + positions[k] - served[k];
      }
    }
    attribute.needsUpdate = true;
    this.laid.forEach(({ points }, tape) => {
      const [path, beneath] = [this.#paths[tape], this.#points[tape]];
      for (let i = 0; i < points.length; i += 1) {
        for (let k = 0; k < 3; k += 1) {
          const at = 3 * beneath[i] + k;
          points[i][k] = path[i][k] + positions[at] - served[at];
        }
      }
    });
  }

  dispose() {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
  }

  /** The bands of the tapes: heights are drawn beside the body, and weight nowhere. */
  #build(rows) {
    this.mesh.geometry.dispose();
    const [positions, tints, index, owners] = [[], [], [], []];
    this.laid.forEach(({ kind, points, normals }, tape) => {
      if (kind !== "girth" && kind !== "length") return;
      const laid = band(points, kind === "girth", normals, WIDTH);
      const colour = rows[tape].asked === null ? ESTIMATED : ENTERED;
      const first = positions.length / 3;
      const each = laid.edges.length / points.length;
      positions.push(...laid.positions);
      for (const edge of laid.edges) tints.push(...(edge ? EDGE : colour));
      for (const corner of laid.index) index.push(first + corner);
      for (const point of this.#points[tape]) owners.push(...Array(each).fill(3 * point));
    });
    this.#corners = Float32Array.from(positions);
    this.#owners = Uint32Array.from(owners);
    this.mesh.visible = index.length > 0;
    this.mesh.geometry = corners(positions, tints);
    this.mesh.geometry.setIndex(index);
  }
}

/** A geometry of corners with their colours, three numbers each. */
function corners(positions, tints) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(positions), 3));
  geometry.setAttribute("tint", new BufferAttribute(new Float32Array(tints), 3));
  return geometry;
}
