/**
 * A body in 3D inside an element of the page. The page keeps its buttons and words; the viewer
 * knows a file, a camera and the reader's hands.
 *
 *     const viewer = createViewer(element);
 *     await viewer.load("/avatar.glb");      // the body shown before goes over into it
 *     await viewer.learn("/avatar.glb?live=1");
 *     viewer.bend({waist_girth: 0.02});      // two centimetres more, in the next frame
 *     viewer.show("side");                   // front, quarter, side, back
 *     viewer.zoom(1.25);                     // nearer by a quarter
 *     viewer.lay(rows);                      // tapes of the API's answer
 *     viewer.dispose();
 *
 * The element's `data-label` is what screen readers call it. Its `data-state` says how it stands:
 * loading, ready or failed; until it is ready, and if it fails, the still picture inside stays. Events: `viewchange` names the view that is shown,
 * `frame` follows every picture that is drawn, `rest` the last for now. It draws only when
 * something has changed; `stats` counts what that costs.
 */

import {
  BufferAttribute,
  BufferGeometry,
  CircleGeometry,
  MathUtils,
  Mesh,
  PerspectiveCamera,
  Scene,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

import { readGlb } from "./glb.js";
import { GARMENT, faint, lit, paint, shaded } from "./materials.js";
import {
  DISTANCE,
  VIEWS,
  between,
  clamp,
  ease,
  fitSlope,
  middleSlope,
  orbitOf,
  partDistance,
  position,
} from "./orbit.js";
import { Shape } from "./shape.js";
import { Tapes } from "./tapes.js";
import { SKIN_TONES } from "./tones.js";

const MOST_PIXELS_PER_POINT = 2;
const TURN_MILLISECONDS = 600;
const BLEND_MILLISECONDS = 350;
const GHOST_MILLISECONDS = 900;
const SOLE = 0.02; // metres above the floor that still are sole
const KEY_TURN = Math.PI / 12;
const KEY_ZOOM = 1.2;
const NEAREST = 0.3; // of the distance at which the whole body is seen
const FARTHEST = 1.6;

const KEYS_VIEWS = ["front", "quarter", "side", "back"];

export class ViewerError extends Error {}

/**
 * @param {HTMLElement} element
 * @throws {ViewerError} where the browser cannot draw in 3D
 */
export function createViewer(element) {
  return new Viewer(element);
}

class Viewer {
  /** What drawing has cost so far; times in milliseconds of script, of the last frame and most. */
  stats = { frames: 0, bends: 0, drawCalls: 0, triangles: 0, script: 0, slowest: 0 };

  #element;
  #canvas = document.createElement("canvas");
  #renderer;
  #scene = new Scene();
  #camera = new PerspectiveCamera(30, 1, 0.05, 50);
  #controls;
  #resizes;
  #calm = window.matchMedia("(prefers-reduced-motion: reduce)");
  #ground = new Mesh(new CircleGeometry(1, 48), shaded());
  #tapes = new Tapes();
  #shape = null; // what is shown, as numbers
  #geometry = null; // the same, for the graphics card
  #meshes = [];
  #ghost = []; // the meshes of the body before
  #ghostModel = new Mesh(new BufferGeometry(), faint()); // never seen: its material is ready
  #tone = SKIN_TONES.mannequin;
  #motion = null; // {start, end, since} while the camera is on its way
  #blend = null; // when the body began to go over into another
  #fading = null; // when the ghost began to fade
  #bent = false; // whether the shape has changed since the last frame
  #frame = 0; // the number of the frame asked for, 0 when none is
  #request = null; // what stops the download under way
  #listeners = new AbortController();

  constructor(element) {
    this.#element = element;
    element.dataset.state = "loading";
    this.#canvas.tabIndex = 0;
    this.#canvas.setAttribute("role", "application");
    this.#canvas.setAttribute("aria-label", element.dataset.label);
    this.#uncover(false);
    try {
      this.#renderer = new WebGLRenderer({ canvas: this.#canvas, antialias: true, alpha: true });
    } catch (error) {
      element.dataset.state = "failed";
      throw new ViewerError("This browser cannot show 3D.", { cause: error });
    }
    this.#renderer.info.autoReset = false; // once a frame, however often it renders
    element.append(this.#canvas);
    this.#ground.rotation.x = -Math.PI / 2;
    this.#ground.renderOrder = -1;
    this.#ghostModel.visible = false;
    this.#scene.add(this.#ground, this.#tapes.mesh, this.#ghostModel);
    this.#controls = this.#orbitControls();
    this.#listen();
    this.#resizes = new ResizeObserver(() => this.#resize());
    this.#resizes.observe(element);
  }

  // ---- the body ----

  /**
   * Show the body of a GLB file; one shown before goes over into it. A later call wins over an
   * earlier one still under way.
   *
   * @param {string} url
   * @param {() => Record<string, number>} changes what the entered values differ by from that
   *     body's when it comes, SI
   * @returns {Promise<boolean>} false where a later call won
   */
  async load(url, changes = () => ({})) {
    this.#request?.abort();
    const request = new AbortController();
    this.#request = request;
    if (!this.#shape) this.#element.dataset.state = "loading";
    let body;
    try {
      body = await fetchBody(url, request.signal);
    } catch (error) {
      if (request.signal.aborted) return false;
      if (!this.#shape) this.#element.dataset.state = "failed";
      throw error;
    }
    if (request.signal.aborted) return false;
    const first = this.#shape === null;
    if (first) await pause();
    this.#replace(body, changes());
    if (first) await this.#prepare([this.#ground, this.#meshes[0]]);
    this.#uncover(true);
    if (first) this.#prepareRest();
    return true;
  }

  /**
   * Learn from a file with targets how entered values bend the body that is shown.
   *
   * @returns {Promise<object>} what the file's mesh says of itself
   */
  async learn(url, changes = () => ({})) {
    const { targets, extras } = await fetchBody(url, this.#listeners.signal);
    this.#shape.learn(targets, changes());
    this.#bent = true;
    this.#draw();
    return extras;
  }

  /** Change entered values, by name: by how much each differs from the body that was loaded, SI. */
  bend(changes) {
    if (!this.#shape) return;
    this.#shape.bend(changes);
    this.stats.bends += 1;
    this.#bent = true;
    this.#draw();
  }

  /** The points of the body as it is shown, three numbers each, in metres. */
  get vertices() {
    return this.#shape?.positions ?? new Float32Array();
  }

  /** Keep the outline of the body as it is now, to be seen beside what it becomes. */
  keepGhost() {
    if (!this.#shape) return;
    this.#dropGhost();
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(this.#shape.positions.slice(), 3));
    geometry.setAttribute("normal", new BufferAttribute(this.#shape.normals.slice(), 3));
    const { material } = this.#ghostModel;
    material.uniforms.opacity.value = 1;
    this.#ghost = this.#meshes.map((mesh) => {
      const part = new BufferGeometry();
      part.setAttribute("position", geometry.getAttribute("position"));
      part.setAttribute("normal", geometry.getAttribute("normal"));
      part.setIndex(mesh.geometry.index.clone());
      const ghost = new Mesh(part, material);
      ghost.frustumCulled = false;
      ghost.renderOrder = 2;
      return ghost;
    });
    this.#scene.add(...this.#ghost);
    this.#draw();
  }

  /** Let the outline of the body before fade. */
  fadeGhost() {
    if (!this.#ghost.length || this.#fading !== null) return;
    if (this.#calm.matches) this.#dropGhost();
    else this.#fading = performance.now();
    this.#draw();
  }

  get hasGhost() {
    return this.#ghost.length > 0;
  }

  /** Give the skin another colour, sRGB from 0 to 1. */
  paint(colour) {
    this.#tone = colour;
    if (this.#meshes[0]) paint(this.#meshes[0].material, colour);
    this.#draw();
  }

  /** Lay the tapes of some rows of the API's answer on the body, in place of those before. */
  lay(rows) {
    this.#tapes.lay(rows, this.#shape);
    this.#draw();
  }

  /** The tapes that lie on the body, where they run now. */
  get laid() {
    return this.#tapes.laid;
  }

  // ---- where it is seen from ----

  /** Turn to a named view of the whole body: at once where the reader wants little motion. */
  show(name) {
    this.#goTo(this.#whole(name));
    this.#tell(name);
  }

  /**
   * Come so near that some points, and not much else, are seen, from an azimuth. `wide` is the
   * share of the frame's width that they may fill.
   */
  showPart(points, azimuth, wide = 0.8) {
    const aspect = this.#camera.aspect;
    const heights = points.map(([, y]) => y);
    const [low, high] = [Math.min(...heights) - 0.1, Math.max(...heights) + 0.1];
    const [right, back] = [Math.cos(azimuth), Math.sin(azimuth)];
    const radius = Math.max(...points.map(([x, , z]) => Math.abs(x * right - z * back)));
    const whole = { ...this.#whole("front"), azimuth };
    const distance = partDistance({ low, high, radius }, whole.slope, aspect, { tall: 0.85, wide });
    this.#goTo({ ...whole, height: (low + high) / 2, distance: Math.min(distance, DISTANCE) });
    this.#tell("");
  }

  /** Come nearer by a factor; below 1, go away. */
  zoom(factor) {
    const now = this.#motion?.end ?? this.#orbit();
    this.#goTo({ ...now, distance: now.distance / factor });
  }

  /**
   * Where a point is seen, in CSS pixels from the upper left corner, and how near to straight on
   * a surface there that faces a direction: from 1 to -1, below 0 from behind.
   */
  see([x, y, z], facing = null) {
    const point = new Vector3(x, y, z);
    const towards = facing && this.#camera.position.clone().sub(point).normalize();
    const front = facing ? towards.dot(new Vector3(...facing)) : 1;
    const { x: across, y: up } = point.project(this.#camera);
    const { clientWidth: width, clientHeight: height } = this.#element;
    return { x: ((1 + across) * width) / 2, y: ((1 - up) * height) / 2, front };
  }

  /** Give back everything that was taken: memory, listeners, the graphics context. */
  dispose() {
    this.#request?.abort();
    cancelAnimationFrame(this.#frame);
    this.#listeners.abort();
    this.#resizes.disconnect();
    this.#controls.dispose();
    this.#dropGhost();
    this.#dropBody();
    this.#tapes.dispose();
    this.#ghostModel.geometry.dispose();
    this.#ghostModel.material.dispose();
    this.#ground.geometry.dispose();
    this.#ground.material.dispose();
    this.#renderer.dispose();
    this.#renderer.forceContextLoss();
    this.#uncover(false);
    this.#canvas.remove();
    delete this.#element.dataset.state;
  }

  /** What the graphics card holds for it, as three.js counts it. */
  get memory() {
    return { ...this.#renderer.info.memory, programs: this.#renderer.info.programs.length };
  }

  /** The page may mark the view that is shown, "" once the reader has turned away from it. */
  #tell(view) {
    this.#element.dispatchEvent(new CustomEvent("viewchange", { detail: view }));
  }

  // ---- the scene ----

  #replace(body, changes) {
    const first = this.#shape === null;
    if (!first && body.positions.length === this.#shape.positions.length) {
      this.#shape.replace(body, changes);
      if (this.#calm.matches) this.#shape.approach(1);
      else this.#blend = performance.now();
    } else {
      this.#dropBody();
      this.#shape = new Shape(body);
      this.#shape.bend(changes);
      this.#build(body);
    }
    this.#standOn();
    if (first) {
      this.#stand(this.#whole("front"));
      this.#limit();
      this.#tell("front");
    }
    this.#bent = true;
    this.#draw();
  }

  /** Make programs ready one by one, and leave the page its turn between them. */
  async #prepare(meshes) {
    const aside = this.#renderer.extensions.has("KHR_parallel_shader_compile");
    for (const mesh of meshes) {
      await pause();
      if (aside) await this.#renderer.compileAsync(mesh, this.#camera, this.#scene);
      else this.#renderer.compile(mesh, this.#camera, this.#scene);
    }
    await pause();
  }

  /** The programs of tapes and ghosts, before anyone waits for them: a first use stands still. */
  async #prepareRest() {
    const corner = this.#ghostModel.geometry;
    for (const [name, attribute] of Object.entries(this.#geometry)) {
      corner.setAttribute(name, attribute);
    }
    corner.setIndex([0, 0, 0]);
    for (const mesh of [this.#ghostModel, this.#tapes.mesh]) {
      await this.#prepare([mesh]);
      if (this.#listeners.signal.aborted) return;
      const shown = mesh.visible;
      mesh.visible = true;
      this.#ghostModel.material.uniforms.opacity.value = 0;
      this.#render();
      mesh.visible = shown;
    }
    this.#ghostModel.material.uniforms.opacity.value = 1;
    this.#draw();
  }

  #build({ parts }) {
    this.#geometry = {
      position: new BufferAttribute(this.#shape.positions, 3),
      normal: new BufferAttribute(this.#shape.normals, 3),
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

  /** Lay the shadow under the feet. */
  #standOn() {
    const { positions } = this.#shape;
    let [count, apart, back] = [0, 0, 0];
    for (let i = 0; i < positions.length; i += 3) {
      if (positions[i + 1] > SOLE) continue;
      count += 1;
      apart += Math.abs(positions[i]);
      back += positions[i + 2];
    }
    const size = 0.31 * this.#height();
    this.#ground.position.z = back / Math.max(count, 1);
    this.#ground.scale.setScalar(size);
    this.#ground.material.uniforms.feet.value = apart / Math.max(count, 1) / size;
  }

  #height() {
    const { positions } = this.#shape;
    let highest = 0;
    for (let i = 1; i < positions.length; i += 3) highest = Math.max(highest, positions[i]);
    return highest;
  }

  // ---- the camera ----

  #orbitControls() {
    const controls = new OrbitControls(this.#camera, this.#canvas);
    controls.enableDamping = !this.#calm.matches;
    controls.minPolarAngle = 0.2;
    controls.maxPolarAngle = Math.PI / 2 + 0.25; // a little from below, not from under the floor
    // A thumb that strokes upwards scrolls the page; sideways it turns the body.
    this.#canvas.style.touchAction = "pan-y";
    controls.addEventListener("start", () => {
      this.#motion = null;
      this.#tell("");
    });
    controls.addEventListener("change", () => {
      this.#keepOnAxis();
      this.#draw();
    });
    return controls;
  }

  /** A named view of the whole body: with the camera and the lens of the still pictures. */
  #whole(name) {
    const { positions } = this.#shape;
    const camera = { distance: DISTANCE, height: this.#height() / 2 };
    const slope = fitSlope(positions, this.#camera.aspect, camera);
    const height = camera.height + DISTANCE * middleSlope(positions, VIEWS[name].azimuth, camera);
    return { ...VIEWS[name], distance: DISTANCE, height, slope };
  }

  #limit() {
    this.#controls.minDistance = NEAREST * DISTANCE;
    this.#controls.maxDistance = FARTHEST * DISTANCE;
  }

  /** Panning goes up and down the body only, and not away from it. */
  #keepOnAxis() {
    if (!this.#shape) return;
    const { target } = this.#controls;
    const kept = new Vector3(0, clamp(target.y, 0.05, this.#height()), 0);
    this.#camera.position.add(kept).sub(target);
    target.copy(kept);
  }

  #orbit() {
    const slope = Math.tan(MathUtils.degToRad(this.#camera.fov) / 2);
    return { ...orbitOf(this.#camera.position, this.#controls.target.y), slope };
  }

  #stand(orbit) {
    const { x, y, z } = position(orbit);
    this.#camera.position.set(x, y, z);
    this.#camera.fov = 2 * MathUtils.radToDeg(Math.atan(orbit.slope));
    this.#camera.updateProjectionMatrix();
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

  // ---- drawing ----

  /** Show the canvas in place of the still picture that the element may hold, or the other way. */
  #uncover(drawn) {
    this.#canvas.style.display = drawn ? "block" : "none";
    for (const still of this.#element.querySelectorAll("img")) {
      still.style.visibility = drawn ? "hidden" : "";
    }
    if (!drawn) return;
    this.#resize();
    this.#element.dataset.state = "ready";
  }

  /** Ask for a frame, once however often it is called before that frame. */
  #draw() {
    this.#frame ||= requestAnimationFrame((now) => this.#drawNow(now));
  }

  #drawNow(now) {
    const began = performance.now();
    this.#frame = 0;
    this.#moveBody(now);
    this.#moveCamera(now);
    this.#render();
    const took = performance.now() - began;
    this.stats.script = took;
    this.stats.slowest = Math.max(this.stats.slowest, took);
    this.#element.dispatchEvent(new CustomEvent("frame"));
    if (!this.#frame) this.#element.dispatchEvent(new CustomEvent("rest"));
  }

  #moveBody(now) {
    if (this.#blend !== null) {
      const share = (now - this.#blend) / BLEND_MILLISECONDS;
      this.#shape.approach(ease(share));
      this.#bent = true;
      if (share >= 1) this.#blend = null;
      else this.#draw();
    }
    if (this.#fading !== null) {
      const share = (now - this.#fading) / GHOST_MILLISECONDS;
      if (share >= 1) this.#dropGhost();
      else {
        this.#ghostModel.material.uniforms.opacity.value = 1 - ease(share);
        this.#draw();
      }
    }
    if (!this.#bent) return;
    this.#bent = false;
    for (const attribute of Object.values(this.#geometry)) attribute.needsUpdate = true;
    this.#tapes.follow(this.#shape);
  }

  #moveCamera(now) {
    if (!this.#motion) {
      this.#controls.update(); // where damping goes on, this asks for the next frame
      return;
    }
    const { start, end, since } = this.#motion;
    const share = (now - since) / TURN_MILLISECONDS;
    if (share >= 1) this.#motion = null;
    this.#stand(between(start, end, ease(share)));
  }

  #render() {
    const { info } = this.#renderer;
    info.reset();
    this.#renderer.render(this.#scene, this.#camera);
    this.stats.frames += 1;
    this.stats.drawCalls = info.render.calls;
    this.stats.triangles = info.render.triangles;
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.#element;
    if (!width || !height || !this.#shape) return;
    const before = this.#whole("front").slope;
    this.#renderer.setPixelRatio(Math.min(window.devicePixelRatio, MOST_PIXELS_PER_POINT));
    this.#renderer.setSize(width, height);
    this.#camera.aspect = width / height;
    // As much of the body stays in the frame as was.
    const orbit = this.#orbit();
    const slope = (orbit.slope / before) * this.#whole("front").slope;
    if (this.#motion) this.#motion.end.slope *= slope / orbit.slope;
    this.#stand({ ...orbit, slope });
    this.#render(); // at once: a resized canvas is blank
    this.#element.dispatchEvent(new CustomEvent("frame"));
  }

  // ---- the reader's hands ----

  #listen() {
    const { signal } = this.#listeners;
    this.#canvas.addEventListener("keydown", (event) => this.#press(event), { signal });
    // The wheel scrolls the page, unless the reader has chosen the body.
    this.#canvas.addEventListener(
      "wheel",
      (event) => {
        if (document.activeElement !== this.#canvas && !event.ctrlKey) {
          event.stopImmediatePropagation();
        }
      },
      { signal, capture: true },
    );
    this.#calm.addEventListener(
      "change",
      () => {
        this.#controls.enableDamping = !this.#calm.matches;
      },
      { signal },
    );
    this.#canvas.addEventListener(
      "webglcontextlost",
      () => {
        this.#uncover(false);
        this.#element.dataset.state = "failed";
      },
      { signal },
    );
    this.#canvas.addEventListener(
      "webglcontextrestored",
      () => {
        this.#uncover(true);
      },
      { signal },
    );
  }

  #press(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const turn = (azimuth, polar) => {
      this.#tell("");
      const now = this.#motion?.end ?? this.#orbit();
      const { minPolarAngle, maxPolarAngle } = this.#controls;
      this.#goTo({
        ...now,
        azimuth: now.azimuth + azimuth,
        polar: clamp(now.polar + polar, minPolarAngle, maxPolarAngle),
      });
    };
    const actions = {
      ArrowLeft: () => turn(-KEY_TURN, 0),
      ArrowRight: () => turn(KEY_TURN, 0),
      ArrowUp: () => turn(0, -KEY_TURN / 2),
      ArrowDown: () => turn(0, KEY_TURN / 2),
      "+": () => this.zoom(KEY_ZOOM),
      "=": () => this.zoom(KEY_ZOOM),
      "-": () => this.zoom(1 / KEY_ZOOM),
    };
    KEYS_VIEWS.forEach((name, i) => {
      actions[i + 1] = () => this.show(name);
    });
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }
}

/** Let the page do what else it has to. */
function pause() {
  return new Promise((resolve) => setTimeout(resolve, 0));
}

async function fetchBody(url, signal) {
  try {
    const response = await fetch(url, { signal });
    if (!response.ok) throw new ViewerError(`The avatar's file: status ${response.status}.`);
    return readGlb(await response.arrayBuffer());
  } catch (error) {
    if (error instanceof ViewerError) throw error;
    throw new ViewerError("The avatar's file could not be shown.", { cause: error });
  }
}

/** Give back the graphics memory of meshes, and take them out of the scene. */
function release(meshes) {
  for (const mesh of meshes) {
    mesh.removeFromParent();
    mesh.geometry.dispose();
  }
}
