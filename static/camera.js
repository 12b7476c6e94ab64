/** The camera of the view in 3D: named views, eased ways between them, and the reader's pointer. */

import { MathUtils, PerspectiveCamera, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

import {
  DISTANCE,
  VIEWS,
  between,
  clamp,
  ease,
  extent,
  fitSlope,
  middleSlope,
  orbitOf,
  partDistance,
  position,
  reach,
} from "./orbit.js";
import { highest } from "./surface.js";

const TURN_MILLISECONDS = 600;
const NEAREST = 0.3; // of the distance at which the whole body is seen
const FARTHEST = 1.6;
const EDGE = 0.01; // of the frame that stays free around a body that grows towards it

export class Camera {
  /** three.js's own, to draw with. */
  lens = new PerspectiveCamera(30, 1, 0.05, 50);
  #controls;
  #figure;
  #calm;
  #draw;
  #view = ""; // the named view that it shows or goes to, "" once the reader has left it
  #motion = null; // {start, end, since} while it is on its way
  #entire = false; // whether all of the body was in the last picture
  #seen = new Vector3(); // for `see`, which is asked hundreds of times a picture
  #towards = new Vector3();

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {import("./figure.js").Figure} figure that it looks at
   * @param {MediaQueryList} calm whether the reader wants little motion
   * @param {{draw: () => void, turned: () => void}} heard what to do where it moves, and where the
   *     reader takes hold of the body
   */
  constructor(canvas, figure, calm, { draw, turned }) {
    this.#figure = figure;
    this.#calm = calm;
    this.#draw = draw;
    const controls = new OrbitControls(this.lens, canvas);
    controls.enableDamping = !calm.matches;
    controls.minPolarAngle = 0.2;
    controls.maxPolarAngle = Math.PI / 2 + 0.25; // a little from below, not from under the floor
    // A thumb that strokes upwards scrolls the page; sideways it turns the body.
    canvas.style.touchAction = "pan-y";
    controls.addEventListener("start", () => {
      this.#motion = null;
      this.#view = "";
      turned();
    });
    controls.addEventListener("change", () => {
      this.#keepOnAxis();
      draw();
    });
    this.#controls = controls;
  }

  /** A body is there: stand before it, and come no nearer or farther than it needs. */
  begin() {
    this.#view = "front";
    this.#stand(this.#whole("front"));
    this.#controls.minDistance = NEAREST * DISTANCE;
    this.#controls.maxDistance = FARTHEST * DISTANCE;
  }

  /** Go to a named view of the whole body. */
  show(name) {
    this.#view = name;
    this.#goTo(this.#whole(name));
  }

  /** Another body is there: a named view has all of it in its frame, as the one before. */
  fitAgain() {
    if (this.#view) this.#goTo(this.#whole(this.#view));
  }

  /** Come so near that some points, and not much else, are seen from an azimuth. */
  showPart(points, azimuth, wide) {
    const whole = { ...this.#whole("front"), azimuth };
    const part = extent(points, azimuth);
    const distance = partDistance(part, whole.slope, this.lens.aspect, { tall: 0.85, wide });
    const height = (part.low + part.high) / 2;
    this.#view = "";
    this.#goTo({ ...whole, height, distance: Math.min(distance, DISTANCE) });
  }

  /** Come nearer by a factor; below 1, go away. */
  zoom(factor) {
    const now = this.#leave();
    this.#goTo({ ...now, distance: now.distance / factor });
  }

  /** Turn by angles from where it stands or will stand. */
  turn(azimuth, polar) {
    const now = this.#leave();
    const { minPolarAngle, maxPolarAngle } = this.#controls;
    this.#goTo({
      ...now,
      azimuth: now.azimuth + azimuth,
      polar: clamp(now.polar + polar, minPolarAngle, maxPolarAngle),
    });
  }

  /** Slide up the body by metres, from where it stands or will stand. */
  slide(by) {
    const now = this.#leave();
    this.#goTo({ ...now, height: this.#onBody(now.height + by) });
  }

  /** Where a point is seen in a frame of some size, and how near to straight on. */
  see([x, y, z], facing, { width, height }) {
    const point = this.#seen.set(x, y, z);
    const towards = facing && this.#towards.copy(this.lens.position).sub(point).normalize();
    const front = facing ? towards.x * facing[0] + towards.y * facing[1] + towards.z * facing[2] : 1;
    const { x: across, y: up } = point.project(this.lens);
    return { x: ((1 + across) * width) / 2, y: ((1 - up) * height) / 2, front };
  }

  /** The frame has another shape: as much of the body stays in it as was. */
  reshape(aspect) {
    const before = this.#whole("front").slope;
    this.lens.aspect = aspect;
    const orbit = this.#orbit();
    const slope = (orbit.slope / before) * this.#whole("front").slope;
    if (this.#motion) this.#motion.end.slope *= slope / orbit.slope;
    this.#stand({ ...orbit, slope });
  }

  /**
   * Go on to where it is at a time. The frame widens for a body that was in it entirely and grows
   * out of it: `bent` says whether it has changed since the last picture.
   */
  move(now, bent) {
    if (!this.#figure.shape) return;
    let keeps = bent; // a reader who comes nearer wants to see less of it
    if (this.#motion) {
      keeps = this.#view !== "";
      if (keeps && bent) this.#motion.end = this.#whole(this.#view);
      const { start, end, since } = this.#motion;
      const share = (now - since) / TURN_MILLISECONDS;
      if (share >= 1) this.#motion = null;
      this.#stand(between(start, end, ease(share)));
    } else this.#controls.update(); // where damping goes on, this asks for the next frame
    const orbit = this.#orbit();
    const needed = reach(this.#figure.shape.positions, orbit, this.lens.aspect);
    const slope = (1 + EDGE) * needed;
    if (!this.#entire || !keeps) this.#entire = needed <= orbit.slope;
    else if (slope > orbit.slope) this.#stand({ ...orbit, slope });
  }

  /** The reader wants more or less motion than before. */
  heedCalm() {
    this.#controls.enableDamping = !this.#calm.matches;
  }

  dispose() {
    this.#controls.dispose();
  }

  /**
   * A named view of the whole body: from as far away and as large as in the still pictures. Those
   * are taken from 0.9 m above the floor and their frame is shifted; here the camera stands before
   * the body's middle, which is near it.
   */
  #whole(name) {
    const positions = this.#figure.coming;
    const camera = { distance: DISTANCE, height: highest(positions) / 2 };
    const slope = fitSlope(positions, this.lens.aspect, camera);
    const middle = middleSlope(positions, VIEWS[name].azimuth, camera);
    return { ...VIEWS[name], distance: DISTANCE, height: camera.height + DISTANCE * middle, slope };
  }

  /** Panning goes up and down the body only, and not away from it. */
  #keepOnAxis() {
    if (!this.#figure.shape) return;
    const { target } = this.#controls;
    const kept = new Vector3(0, this.#onBody(target.y), 0);
    this.lens.position.add(kept).sub(target);
    target.copy(kept);
  }

  /** A height that lies between the body's soles and its crown. */
  #onBody(height) {
    return clamp(height, 0.05, this.#figure.height);
  }

  /** Where it stands or will stand, from where the reader goes on to a view without a name. */
  #leave() {
    this.#view = "";
    return this.#motion?.end ?? this.#orbit();
  }

  #orbit() {
    const slope = Math.tan(MathUtils.degToRad(this.lens.fov) / 2);
    return { ...orbitOf(this.lens.position, this.#controls.target.y), slope };
  }

  #stand(orbit) {
    const { x, y, z } = position(orbit);
    this.lens.position.set(x, y, z);
    this.lens.fov = 2 * MathUtils.radToDeg(Math.atan(orbit.slope));
    this.lens.updateProjectionMatrix();
    this.#controls.target.set(0, orbit.height, 0);
    this.#controls.update();
    this.#draw();
  }

  #goTo(orbit) {
    const { minDistance, maxDistance } = this.#controls;
    const end = { ...orbit, distance: clamp(orbit.distance, minDistance, maxDistance) };
    if (this.#calm.matches) {
      this.#stand(end);
      return;
    }
    this.#motion = { start: this.#orbit(), end, since: performance.now() };
    this.#draw();
  }
}
