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
 * loading, ready or failed; until it is ready, and if it fails, the still picture inside stays.
 * Events: `viewchange` names the view that is shown, `frame` follows every picture that is drawn,
 * `rest` the last for now. It draws only when something has changed; `stats` counts what that costs.
 */

import { Scene, WebGLRenderer } from "three";

import { ViewerError, fetchBody } from "./body_file.js";
import { Camera } from "./camera.js";
import { Figure } from "./figure.js";
import { followHands } from "./hands.js";
import { Tapes } from "./tapes.js";

export { ViewerError };

const MOST_PIXELS_PER_POINT = 2;

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
  #camera;
  #figure;
  #tapes = new Tapes();
  #resizes;
  #size = { width: 1, height: 1 };
  #calm = window.matchMedia("(prefers-reduced-motion: reduce)");
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
    this.#figure = new Figure(this.#scene, this.#calm);
    this.#scene.add(this.#tapes.mesh);
    this.#camera = new Camera(this.#canvas, this.#figure, this.#calm, {
      draw: () => this.#draw(),
      turned: () => this.#tell(""),
    });
    this.#listen();
    this.#resizes = new ResizeObserver(() => this.#resize());
    this.#resizes.observe(element);
  }

  // ---- the body ----

  /**
   * Show the body of a GLB file; one shown before goes over into it. A later call wins over an
   * earlier one still under way.
   *
   * @param {string|Request} url
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
    this.#figure.replace(body, changes());
    if (first) {
      this.#camera.begin();
      this.#tell("front");
    } else this.#camera.fitAgain();
    this.#draw();
    if (first) await this.#prepare([this.#figure.ground, this.#figure.skin]);
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
    this.#figure.learn(targets, changes());
    this.#draw();
    return extras;
  }

  /** Change entered values, by name: by how much each differs from the body that was loaded, SI. */
  bend(changes) {
    if (!this.#shape) return;
    this.#figure.bend(changes);
    this.stats.bends += 1;
    this.#draw();
  }

  get #shape() {
    return this.#figure.shape;
  }

  /** The points of the body as it is shown, three numbers each, in metres. */
  get vertices() {
    return this.#shape?.positions ?? new Float32Array();
  }

  /** Keep the outline of the body as it is now, to be seen beside what it becomes. */
  keepGhost() {
    if (!this.#shape) return;
    this.#figure.keepGhost();
    this.#draw();
  }

  /** Let the outline of the body before fade. */
  fadeGhost() {
    if (this.#figure.fadeGhost()) this.#draw();
  }

  get hasGhost() {
    return this.#figure.hasGhost;
  }

  /** Give the skin another colour, sRGB from 0 to 1. */
  paint(colour) {
    this.#figure.paint(colour);
    this.#draw();
  }

  /** Lay the tapes of some rows of the API's answer on the body, in place of those before. */
  lay(rows) {
    if (!this.#shape) return;
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
    this.#camera.show(name);
    this.#tell(name);
  }

  /**
   * Come so near that some points, and not much else, are seen, from an azimuth. `wide` is the
   * share of the frame's width that they may fill.
   */
  showPart(points, azimuth, wide = 0.8) {
    this.#camera.showPart(points, azimuth, wide);
    this.#tell("");
  }

  /** Come nearer by a factor; below 1, go away. */
  zoom(factor) {
    this.#camera.zoom(factor);
  }

  /**
   * Where a point is seen, in CSS pixels from the upper left corner, and how near to straight on
   * a surface there that faces a direction: from 1 to -1, below 0 from behind.
   */
  see(point, facing = null) {
    return this.#camera.see(point, facing, this.#size);
  }

  /** The view's width and height in CSS pixels, without having the page laid out to know them. */
  get size() {
    return this.#size;
  }

  /** Give back everything that was taken: memory, listeners, the graphics context. */
  dispose() {
    this.#request?.abort();
    cancelAnimationFrame(this.#frame);
    this.#listeners.abort();
    this.#resizes.disconnect();
    this.#camera.dispose();
    this.#figure.dispose();
    this.#tapes.dispose();
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

  // ---- getting ready ----

  /** Make programs ready one by one, and leave the page its turn between them. */
  async #prepare(meshes) {
    const aside = this.#renderer.extensions.has("KHR_parallel_shader_compile");
    for (const mesh of meshes) {
      await pause();
      if (aside) await this.#renderer.compileAsync(mesh, this.#camera.lens, this.#scene);
      else this.#renderer.compile(mesh, this.#camera.lens, this.#scene);
    }
    await pause();
  }

  /** The programs of tapes and ghosts, before anyone waits for them: a first use stands still. */
  async #prepareRest() {
    const { ghostModel, attributes } = this.#figure;
    const { opacity } = ghostModel.material.uniforms;
    for (const [name, attribute] of Object.entries(attributes)) {
      ghostModel.geometry.setAttribute(name, attribute);
    }
    ghostModel.geometry.setIndex([0, 0, 0]);
    for (const mesh of [ghostModel, this.#tapes.mesh]) {
      await this.#prepare([mesh]);
      if (this.#listeners.signal.aborted) return;
      const shown = mesh.visible;
      mesh.visible = true;
      opacity.value = 0;
      this.#render();
      mesh.visible = shown;
    }
    opacity.value = 1;
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
    if (this.#figure.move(now)) this.#draw();
    const bent = this.#figure.update();
    if (bent) this.#tapes.follow(this.#shape);
    this.#camera.move(now, bent);
    this.#render();
    this.#element.dispatchEvent(new CustomEvent("frame"));
    if (!this.#frame) this.#element.dispatchEvent(new CustomEvent("rest"));
    const took = performance.now() - began; // what is written over the picture belongs to it
    this.stats.script = took;
    this.stats.slowest = Math.max(this.stats.slowest, took);
  }

  #render() {
    const { info } = this.#renderer;
    info.reset();
    this.#renderer.render(this.#scene, this.#camera.lens);
    this.stats.frames += 1;
    this.stats.drawCalls = info.render.calls;
    this.stats.triangles = info.render.triangles;
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.#element;
    if (!width || !height || !this.#shape) return;
    this.#size = { width, height };
    this.#renderer.setPixelRatio(Math.min(window.devicePixelRatio, MOST_PIXELS_PER_POINT));
    this.#renderer.setSize(width, height);
    this.#camera.reshape(width / height);
    this.#render(); // at once: a resized canvas is blank
    this.#element.dispatchEvent(new CustomEvent("frame"));
  }

  // ---- what happens to it ----

  #listen() {
    const { signal } = this.#listeners;
    followHands(
      this.#canvas,
      {
        show: (name) => this.show(name),
        zoom: (factor) => this.zoom(factor),
        turn: (azimuth, polar) => {
          this.#tell("");
          this.#camera.turn(azimuth, polar);
        },
        slide: (by) => {
          this.#tell("");
          this.#camera.slide(by);
        },
      },
      signal,
    );
    const hear = (target, event, action) => target.addEventListener(event, action, { signal });
    hear(this.#calm, "change", () => this.#camera.heedCalm());
    hear(this.#canvas, "webglcontextlost", () => {
      this.#uncover(false);
      this.#element.dataset.state = "failed";
    });
    hear(this.#canvas, "webglcontextrestored", () => this.#uncover(true));
  }
}

/** Let the page do what else it has to. */
function pause() {
  return new Promise((resolve) => setTimeout(resolve, 0));
}
