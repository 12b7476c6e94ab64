/**
 * A body in 3D inside an element of the page. The page keeps its buttons and words; the viewer
 * knows a file, a camera and the reader's hands.
 *
 *     const viewer = createViewer(element);
 *     await viewer.load("/avatar.glb");   // replaces the body shown before
 *     viewer.show("side");                // front, side, back
 *     viewer.zoom(1.25);                  // nearer by a quarter
 *     viewer.dispose();
 *
 * The element's `data-state` says how it stands: loading, ready or failed; until it is ready, and
 * if it fails, the still picture inside stays. An event `viewchange` names the view that is shown.
 * It draws only when something has changed.
 */

import {
  Box3,
  CircleGeometry,
  DataTexture,
  DirectionalLight,
  HemisphereLight,
  MathUtils,
  Mesh,
  MeshBasicMaterial,
  PerspectiveCamera,
  RGBAFormat,
  Scene,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

import { VIEWS, between, clamp, ease, fitDistance, orbitOf, position } from "./orbit.js";
import { radialShade } from "./shade.js";

const FIELD_OF_VIEW = 26; // degrees, as of a portrait lens: little perspective, a calm figure
const MOST_PIXELS_PER_POINT = 2;
const TURN_MILLISECONDS = 600;
const KEY_TURN = Math.PI / 12;
const KEY_ZOOM = 1.2;
const NEAREST = 0.35; // of the distance at which the whole body is seen
const FARTHEST = 1.6;

const KEYS_HELP =
  "Arrow keys turn it, plus and minus zoom, 1, 2 and 3 show front, side and back.";

export class ViewerError extends Error {}

/**
 * @param {HTMLElement} element
 * @throws {ViewerError} where the browser cannot draw in 3D
 */
export function createViewer(element) {
  return new Viewer(element);
}

class Viewer {
  #element;
  #canvas = document.createElement("canvas");
  #renderer;
  #scene = new Scene();
  #camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.05, 50);
  #controls;
  #resizes;
  #calm = window.matchMedia("(prefers-reduced-motion: reduce)");
  #ground = groundShadow();
  #body = null; // what the file held
  #extent = { height: 1.7, radius: 0.5 };
  #motion = null; // {start, end, since} while the camera is on its way
  #frame = 0; // the number of the frame asked for, 0 when none is
  #request = null; // what stops the download under way
  #listeners = new AbortController();

  constructor(element) {
    this.#element = element;
    element.dataset.state = "loading";
    this.#canvas.tabIndex = 0;
    this.#canvas.setAttribute("role", "application");
    this.#canvas.setAttribute("aria-label", `Avatar in 3D. ${KEYS_HELP}`);
    this.#uncover(false);
    try {
      this.#renderer = new WebGLRenderer({ canvas: this.#canvas, antialias: true, alpha: true });
    } catch (error) {
      element.dataset.state = "failed";
      throw new ViewerError("This browser cannot show 3D.", { cause: error });
    }
    element.append(this.#canvas);
    this.#light();
    this.#scene.add(this.#camera, this.#ground);
    this.#controls = this.#orbitControls();
    this.#listen();
    this.#resizes = new ResizeObserver(() => this.#resize());
    this.#resizes.observe(element);
  }

  /** Show the body of a GLB file. A later call wins over an earlier one still under way. */
  async load(url) {
    this.#request?.abort();
    const request = new AbortController();
    this.#request = request;
    this.#element.dataset.state = "loading";
    try {
      const response = await fetch(url, { signal: request.signal });
      if (!response.ok) throw new ViewerError(`The avatar's file: status ${response.status}.`);
      const file = await new GLTFLoader().parseAsync(await response.arrayBuffer(), "");
      if (request.signal.aborted) {
        release(file.scene);
        return;
      }
      this.#replace(file.scene);
    } catch (error) {
      if (request.signal.aborted) return;
      this.#element.dataset.state = "failed";
      throw error instanceof ViewerError
        ? error
        : new ViewerError("The avatar's file could not be shown.", { cause: error });
    }
    this.#uncover(true);
  }

  /** Turn to a named view of the whole body: at once where the reader wants little motion. */
  show(name) {
    this.#goTo(this.#whole(name));
    this.#tell(name);
  }

  /** Come nearer by a factor; below 1, go away. */
  zoom(factor) {
    const now = this.#motion?.end ?? this.#orbit();
    this.#goTo({ ...now, distance: now.distance / factor });
  }

  /** Give back everything that was taken: memory, listeners, the graphics context. */
  dispose() {
    this.#request?.abort();
    cancelAnimationFrame(this.#frame);
    this.#listeners.abort();
    this.#resizes.disconnect();
    this.#controls.dispose();
    if (this.#body) release(this.#body);
    release(this.#ground);
    this.#renderer.dispose();
    this.#renderer.forceContextLoss();
    this.#uncover(false);
    this.#canvas.remove();
    delete this.#element.dataset.state;
  }

  /** The page may mark the view that is shown, "" once the reader has turned away from it. */
  #tell(view) {
    this.#element.dispatchEvent(new CustomEvent("viewchange", { detail: view }));
  }

  // ---- the scene ----

  #light() {
    // The lamps stand by the camera, as in the two pictures: what is looked at is lit.
    for (const [colour, strength, x, y, z] of [
      [0xfff6ea, 2.8, -0.6, 0.55, 0.75],
      [0xe6efff, 0.5, 0.9, 0.1, 0.35],
    ]) {
      const lamp = new DirectionalLight(colour, strength);
      lamp.position.set(x, y, z);
      this.#camera.add(lamp, lamp.target);
    }
    this.#scene.add(new HemisphereLight(0xf4f6fa, 0x8f8578, 1.15));
  }

  #replace(body) {
    if (this.#body) {
      this.#scene.remove(this.#body);
      release(this.#body);
    }
    const first = this.#body === null;
    this.#body = body;
    this.#scene.add(body);

    const box = new Box3().setFromObject(body);
    this.#extent = {
      height: box.max.y,
      radius: Math.hypot(
        Math.max(-box.min.x, box.max.x),
        Math.max(-box.min.z, box.max.z),
      ),
    };
    const middle = box.getCenter(new Vector3());
    this.#ground.position.set(0, 0, middle.z);
    this.#ground.scale.setScalar(0.31 * box.max.y);
    this.#limit();
    if (first) {
      this.#stand(this.#whole("front"));
      this.#tell("front");
    }
    this.#draw();
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

  #wholeDistance() {
    return fitDistance(this.#extent, {
      fieldOfView: MathUtils.degToRad(FIELD_OF_VIEW),
      aspect: this.#camera.aspect,
    });
  }

  /** A named view of the whole body. */
  #whole(name) {
    const { height } = this.#extent;
    return { ...VIEWS[name], distance: this.#wholeDistance(), height: height / 2 };
  }

  #limit() {
    this.#controls.minDistance = NEAREST * this.#wholeDistance();
    this.#controls.maxDistance = FARTHEST * this.#wholeDistance();
  }

  /** Panning goes up and down the body only, and not away from it. */
  #keepOnAxis() {
    const { target } = this.#controls;
    const kept = new Vector3(0, clamp(target.y, 0.05, this.#extent.height), 0);
    this.#camera.position.add(kept).sub(target);
    target.copy(kept);
  }

  #orbit() {
    return orbitOf(this.#camera.position, this.#controls.target.y);
  }

  #stand(orbit) {
    const { x, y, z } = position(orbit);
    this.#camera.position.set(x, y, z);
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
    this.#frame = 0;
    if (this.#motion) {
      const { start, end, since } = this.#motion;
      const share = (now - since) / TURN_MILLISECONDS;
      if (share >= 1) this.#motion = null;
      this.#stand(between(start, end, ease(share)));
    } else {
      this.#controls.update(); // where damping goes on, this asks for the next frame
    }
    this.#renderer.render(this.#scene, this.#camera);
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.#element;
    if (!width || !height) return;
    const whole = this.#wholeDistance();
    this.#renderer.setPixelRatio(Math.min(window.devicePixelRatio, MOST_PIXELS_PER_POINT));
    this.#renderer.setSize(width, height);
    this.#camera.aspect = width / height;
    this.#camera.updateProjectionMatrix();
    // As much of the body stays in the frame as was.
    const orbit = this.#orbit();
    this.#limit();
    this.#stand({ ...orbit, distance: (orbit.distance * this.#wholeDistance()) / whole });
    this.#renderer.render(this.#scene, this.#camera); // at once: a resized canvas is blank
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
      1: () => this.show("front"),
      2: () => this.show("side"),
      3: () => this.show("back"),
    };
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }
}

/** A soft disc on the floor, so that the person stands on something. */
function groundShadow() {
  const side = 64;
  const texture = new DataTexture(radialShade(side), side, side, RGBAFormat);
  texture.needsUpdate = true;
  const material = new MeshBasicMaterial({ map: texture, transparent: true, depthWrite: false });
  const disc = new Mesh(new CircleGeometry(1, 48), material);
  disc.rotation.x = -Math.PI / 2;
  disc.renderOrder = -1;
  return disc;
}

/** Give back the graphics memory of everything in a tree. */
function release(tree) {
  tree.traverse((object) => {
    object.geometry?.dispose();
    for (const material of [object.material ?? []].flat()) {
      material.map?.dispose();
      material.dispose();
    }
  });
}
