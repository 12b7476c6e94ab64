/**
 * The body as three.js's scene holds it: its skin and cloth, the shadow under its feet, and the
 * outline of the body before. Two bodies go over into one another, an outline fades.
 */

import { BufferAttribute, BufferGeometry, CircleGeometry, Mesh } from "three";

import { GARMENT, faint, lit, paint, shaded } from "./materials.js";
import { ease } from "./orbit.js";
import { Shape } from "./shape.js";
import { feet, highest } from "./surface.js";
import { SKIN_TONES } from "./tones.js";

const BLEND_MILLISECONDS = 350;
const GHOST_MILLISECONDS = 900;
const SHADOW = 0.31; // its radius, of the body's height

export class Figure {
  /** What is shown, as numbers: null until there is a body. */
  shape = null;
  /** The shadow; and what a ghost is drawn with, never seen itself. */
  ground = new Mesh(new CircleGeometry(1, 48), shaded());
  ghostModel = new Mesh(new BufferGeometry(), faint());
  #scene;
  #calm;
  #geometry = null; // the shape, for the graphics card
  #meshes = [];
  #ghost = []; // the meshes of the body before
  #tone = SKIN_TONES.mannequin;
  #blend = null; // when the body began to go over into another
  #fading = null; // when the ghost began to fade
  #bent = false; // whether the shape has changed since the last frame

  /**
   * @param {import("three").Scene} scene
   * @param {MediaQueryList} calm whether the reader wants little motion
   */
  constructor(scene, calm) {
    this.#scene = scene;
    this.#calm = calm;
    this.ground.rotation.x = -Math.PI / 2;
    this.ground.renderOrder = -1;
    this.ghostModel.visible = false;
    scene.add(this.ground, this.ghostModel);
  }

  /** The points where they will be once the body has gone over into the newest, in metres. */
  get coming() {
    return this.shape.moving ? this.shape.served : this.shape.positions;
  }

  /** Metres from the floor to the highest point. */
  get height() {
    return highest(this.shape.positions);
  }

  /** The attributes of its points, by name, and its first mesh: the skin. */
  get attributes() {
    return this.#geometry;
  }

  get skin() {
    return this.#meshes[0];
  }

  /** Show a body; where one like it is shown, that one goes over into it. */
  replace(body, changes) {
    if (this.shape && body.positions.length === this.shape.positions.length) {
      this.shape.replace(body, changes);
      if (this.#calm.matches) this.shape.approach(1);
      else this.#blend = performance.now();
    } else {
      this.#dropBody();
      this.shape = new Shape(body);
      this.shape.bend(changes);
      this.#build(body);
    }
    this.#bent = true;
  }

  learn(targets, changes) {
    this.shape.learn(targets, changes);
    this.#bent = true;
  }

  bend(changes) {
    this.shape.bend(changes);
    this.#bent = true;
  }

  paint(colour) {
    this.#tone = colour;
    if (this.skin) paint(this.skin.material, colour);
  }

  /** Go on to how it is at a time; whether it will have changed again by the next frame. */
  move(now) {
    let again = false;
    if (this.#blend !== null) {
      const share = (now - this.#blend) / BLEND_MILLISECONDS;
      this.shape.approach(ease(share));
      this.#bent = true;
      if (share >= 1) this.#blend = null;
      else again = true;
    }
    if (this.#fading !== null) {
      const share = (now - this.#fading) / GHOST_MILLISECONDS;
      if (share >= 1) this.#dropGhost();
      else {
        this.ghostModel.material.uniforms.opacity.value = 1 - ease(share);
        again = true;
      }
    }
    return again;
  }

  /** Have the points sent to the graphics card, if they moved since the last frame; whether. */
  update() {
    if (!this.#bent) return false;
    this.#bent = false;
    this.#standOn();
    for (const attribute of Object.values(this.#geometry)) attribute.needsUpdate = true;
    return true;
  }

  // ---- the body before ----

  /** Whether one is kept: not while it fades, for another may then be kept. */
  get hasGhost() {
    return this.#ghost.length > 0 && this.#fading === null;
  }

  keepGhost() {
    this.#dropGhost();
    const position = new BufferAttribute(this.shape.positions.slice(), 3);
    const normal = new BufferAttribute(this.shape.normals.slice(), 3);
    const { material } = this.ghostModel;
    material.uniforms.opacity.value = 1;
    this.#ghost = this.#meshes.map((mesh) => {
      const part = new BufferGeometry();
      part.setAttribute("position", position);
      part.setAttribute("normal", normal);
      part.setIndex(mesh.geometry.index.clone());
      const ghost = new Mesh(part, material);
      ghost.frustumCulled = false;
      ghost.renderOrder = 2;
      return ghost;
    });
    this.#scene.add(...this.#ghost);
  }

  /** Let it fade; whether there was anything to do. */
  fadeGhost() {
    if (!this.#ghost.length || this.#fading !== null) return false;
    if (this.#calm.matches) this.#dropGhost();
    else this.#fading = performance.now();
    return true;
  }

  dispose() {
    this.#dropGhost();
    this.#dropBody();
    for (const { geometry, material } of [this.ghostModel, this.ground]) {
      geometry.dispose();
      material.dispose();
    }
  }

  #build({ parts }) {
    this.#geometry = {
      position: new BufferAttribute(this.shape.positions, 3),
      normal: new BufferAttribute(this.shape.normals, 3),
    };
    this.#meshes = parts.map(({ index }, part) => {
      const geometry = new BufferGeometry();
      for (const [name, attribute] of Object.entries(this.#geometry)) {
        geometry.setAttribute(name, attribute);
      }
      geometry.setIndex(new BufferAttribute(index, 1));
      const mesh = new Mesh(geometry, lit(part === 0 ? this.#tone : GARMENT));
      mesh.frustumCulled = false; // its bounds change as it bends, and it is always in sight
      return mesh;
    });
    this.#scene.add(...this.#meshes);
    this.#standOn();
  }

  /** Lay the shadow under the feet. */
  #standOn() {
    const { apart, back } = feet(this.shape.positions);
    const size = SHADOW * this.height;
    this.ground.position.z = back;
    this.ground.scale.setScalar(size);
    this.ground.material.uniforms.feet.value = apart / size;
  }

  #dropBody() {
    for (const { material } of this.#meshes) material.dispose();
    release(this.#meshes);
    this.#meshes = [];
  }

  #dropGhost() {
    release(this.#ghost);
    this.#ghost = [];
    this.#fading = null;
  }
}

/** Give back the graphics memory of meshes, and take them out of the scene. */
function release(meshes) {
  for (const mesh of meshes) {
    mesh.removeFromParent();
    mesh.geometry.dispose();
  }
}
