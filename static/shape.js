/**
 * A body that bends: the one that the server made, and how entered values change it from there.
 * Arithmetic only, on plain arrays; metres and SI units.
 *
 *     shown = served + what is left of the way to it + Σ change of a value · its target
 *
 * The second term is there after another body came from the server: it shrinks to nothing, so that
 * the body on screen goes over into the new one without a jump, whatever is changed meanwhile.
 */

import { unit, vertexNormals } from "./surface.js";

export class Shape {
  positions;
  normals;
  #faces;
  #served; // positions, normals and raw normals of the server's body
  #targets = [];
  #changes = [];
  #left = null; // positions less the served ones, when it came
  #share = 0; // how much of that is still shown
  #bent = null; // the normals that the faces give it as it is bent, from when it first is

  /** @param {ReturnType<import("./glb.js").readGlb>} body with or without targets */
  constructor(body) {
    this.#faces = body.parts.map(({ index }) => index);
    this.positions = Float32Array.from(body.positions);
    this.normals = Float32Array.from(body.normals);
    this.#take(body);
    this.learn(body.targets);
  }

  /** Whether it stands on its way between two bodies of the server. */
  get moving() {
    return this.#left !== null;
  }

  /** The server's body, without any change. */
  get served() {
    return this.#served.positions;
  }

  /**
   * Change entered values: by how much each differs from the served body's, by name. A name that
   * has no target bends nothing.
   */
  bend(changes) {
    this.#changes = this.#targets.map(({ name }) => changes[name] ?? 0);
    this.#reckon();
  }

  /** Learn how entered values bend it: the targets of a file of this body or of one like it. */
  learn(targets, changes = {}) {
    this.#targets = targets;
    this.bend(changes);
  }

  /**
   * Another body from the server, of changed values: nothing moves until `approach`. Its targets
   * are those of the body before: the law is linear, so that they are the same.
   */
  replace(body, changes = {}) {
    const before = this.positions.slice();
    this.#take(body);
    this.#changes = this.#targets.map(({ name }) => changes[name] ?? 0);
    this.#share = 0;
    this.#reckon();
    for (let i = 0; i < before.length; i += 1) before[i] -= this.positions[i];
    this.#left = before;
    this.approach(0);
  }

  /** Go a share of the way to the newest body, from 0 to 1. */
  approach(share) {
    this.#share = 1 - share;
    if (share >= 1) this.#left = null;
    this.#reckon();
  }

  #take({ positions, normals }) {
    if (positions.length !== this.positions.length) {
      throw new RangeError(`${positions.length / 3} points, not ${this.positions.length / 3}`);
    }
    this.#served = { positions, normals, raw: null };
  }

  #reckon() {
    const { positions: served, normals: smooth } = this.#served;
    const { positions, normals } = this;
    positions.set(served);
    const terms = this.#targets.map(({ moves, step }, i) => [this.#changes[i] / step, moves]);
    if (this.#left) terms.push([this.#share, this.#left]);
    const used = terms.filter(([amount]) => amount !== 0);
    for (const [amount, moves] of used) {
      for (let i = 0; i < positions.length; i += 1) positions[i] += amount * moves[i];
    }
    normals.set(smooth);
    if (used.length === 0) return;
    stand(positions);
    // The served normals are smoothed under the cloth: what bends is added to them.
    const raw = this.#rawNormals();
    this.#bent ??= new Float32Array(positions.length);
    const bent = vertexNormals(positions, this.#faces, this.#bent);
    for (let i = 0; i < normals.length; i += 1) normals[i] += bent[i] - raw[i];
    unit(normals);
  }

  /** The served body's normals as its faces give them, reckoned when it first bends. */
  #rawNormals() {
    const { positions } = this.#served;
    return (this.#served.raw ??= vertexNormals(
      positions,
      this.#faces,
      new Float32Array(positions.length),
    ));
  }
}

/** Put points on the floor: another of them may have come to be the lowest. */
function stand(positions) {
  let lowest = Infinity;
  for (let i = 1; i < positions.length; i += 3) lowest = Math.min(lowest, positions[i]);
  for (let i = 1; i < positions.length; i += 3) positions[i] -= lowest;
}
