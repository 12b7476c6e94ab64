/** The reader's hands on the view in 3D, besides those that three.js's controls follow. */

const KEY_TURN = Math.PI / 12;
const KEY_ZOOM = 1.2;
const KEY_SLIDE = 0.15; // metres
const KEYS_VIEWS = ["front", "quarter", "side", "back"];

/**
 * What a key does; undefined where it does nothing.
 *
 * @param {string} key as events name it
 * @param {object} verbs
 * @param {(name: string) => void} verbs.show
 * @param {(factor: number) => void} verbs.zoom
 * @param {(azimuth: number, polar: number) => void} verbs.turn by radians
 * @param {(by: number) => void} verbs.slide up the body, by metres
 * @returns {(() => void)|undefined}
 */
export function actionOf(key, { show, zoom, turn, slide }) {
  const actions = {
    ArrowLeft: () => turn(-KEY_TURN, 0),
    ArrowRight: () => turn(KEY_TURN, 0),
    ArrowUp: () => turn(0, -KEY_TURN / 2),
    ArrowDown: () => turn(0, KEY_TURN / 2),
    PageUp: () => slide(KEY_SLIDE),
    PageDown: () => slide(-KEY_SLIDE),
    "+": () => zoom(KEY_ZOOM),
    "=": () => zoom(KEY_ZOOM),
    "-": () => zoom(1 / KEY_ZOOM),
  };
  KEYS_VIEWS.forEach((name, i) => {
    actions[i + 1] = () => show(name);
  });
  return Object.hasOwn(actions, key) ? actions[key] : undefined;
}

/** Follow the keys and the wheel over a canvas, until the signal. */
export function followHands(canvas, verbs, signal) {
  canvas.addEventListener(
    "keydown",
    (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const action = actionOf(event.key, verbs);
      if (!action) return;
      event.preventDefault();
      action();
    },
    { signal },
  );
  // The wheel scrolls the page, unless the reader has chosen the body.
  canvas.addEventListener(
    "wheel",
    (event) => {
      if (document.activeElement !== canvas && !event.ctrlKey) event.stopImmediatePropagation();
    },
    { signal, capture: true },
  );
}
