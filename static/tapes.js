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
  #bound = [];

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
    this.#bound = rows.map(({ name, kind, asked, path }) => {
      const points = path.map((point) => find(...point));
      const closed = kind === "girth";
      const normals = closed
        ? outwards(path)
        : smoothed(points.map((v) => Array.from(shape.normals.subarray(3 * v, 3 * v + 3))));
      return { name, kind, closed, path, points, normals, colour: asked === null ? ESTIMATED : ENTERED };
    });
    this.#build(shape);
  }

  /** Go with the body. */
  follow(shape) {
    this.#relay(shape);
    const attribute = this.mesh.geometry.getAttribute("position");
    let at = 0;
    for (const { positions } of this.#bands()) {
      attribute.array.set(positions, at);
      at += positions.length;
    }
    attribute.needsUpdate = true;
  }

  #relay(shape) {
    this.laid = this.#bound.map(({ name, kind, path, points, normals }) => ({
      name,
      kind,
      normals,
      points: path.map((point, i) =>
        point.map((value, k) => {
          const at = 3 * points[i] + k;
          return value + shape.positions[at] - shape.served[at];
        }),
      ),
    }));
  }

  dispose() {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
  }

  /** Heights are drawn beside the body, and weight nowhere. */
  #bands() {
    return this.laid.flatMap(({ kind, points, normals }, i) => {
      if (kind !== "girth" && kind !== "length") return [];
      const { closed, colour } = this.#bound[i];
      return [{ ...band(points, closed, normals, WIDTH), colour }];
    });
  }

  #build(shape) {
    this.mesh.geometry.dispose();
    this.#relay(shape);
    const bands = this.#bands();
    this.mesh.visible = bands.length > 0;
    const [positions, tints, index] = [[], [], []];
    for (const each of bands) {
      const first = positions.length / 3;
      positions.push(...each.positions);
      for (const edge of each.edges) tints.push(...(edge ? EDGE : each.colour));
      for (const corner of each.index) index.push(first + corner);
    }
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
