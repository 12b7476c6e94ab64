/**
 * A step of the wizard in 3D: the person's own estimated body with the tape on it, as it would be
 * with what stands in the form. What draws it is fetched when it is asked for.
 */

const PAUSE = 600; // milliseconds after the last key
const element = document.getElementById("preview");
if (element) start(element);

function start(element) {
  const form = document.getElementById("measurements");
  const button = element.querySelector("button");
  const status = element.querySelector("[role=status]");
  const place = element.querySelector(".viewer");
  let opening = null; // a promise of what draws it, once it is asked for
  let viewer = null;
  let overlay = null;
  let waiting = 0;
  let asked = 0;

  const ask = (address) =>
    new Request(address, { method: "POST", body: new URLSearchParams(new FormData(form)) });

  /** The body and the tape of the numbers as they stand; a later call wins. */
  async function show() {
    asked += 1;
    const own = asked;
    const [tape, body] = [ask(element.dataset.tape), ask(element.dataset.body)];
    const row = fetch(tape).then((response) => (response.ok ? response.json() : null));
    if (!(await viewer.load(body)) || own !== asked) return;
    const rows = [await row].filter((found) => found && element.dataset.kind !== "mass");
    if (own !== asked) return;
    viewer.lay(rows);
    overlay.name(rows);
    const points = viewer.laid.flatMap((laid) => laid.points);
    const azimuth = (Number(element.dataset.azimuth) * Math.PI) / 180;
    if (points.length && element.dataset.kind !== "height") viewer.showPart(points, azimuth, 0.5);
    else viewer.show("front");
    status.textContent = element.dataset.ready;
  }

  function fail() {
    status.textContent = element.dataset.failed;
    if (!viewer || place.dataset.state === "failed") place.hidden = true;
  }

  async function open() {
    place.hidden = false;
    button.setAttribute("aria-expanded", "true");
    status.textContent = element.dataset.waiting;
    opening ??= create().catch((error) => {
      opening = null; // the next press tries again
      throw error;
    });
    await opening;
    if (!place.hidden) await show();
  }

  async function create() {
    const [{ createViewer }, { Overlay }] = await Promise.all([
      import("./stage.js"),
      import("./overlay.js"),
      dress(element.dataset.style),
    ]);
    viewer = createViewer(place);
    overlay = new Overlay(place, viewer);
  }

  /** Fetches the view's style sheet, whose rules count from then on. */
  function dress(address) {
    const link = Object.assign(document.createElement("link"), { rel: "stylesheet", href: address });
    document.head.append(link);
    return new Promise((resolve, reject) => {
      link.addEventListener("load", resolve);
      link.addEventListener("error", () => reject(new Error(`No style sheet at ${address}`)));
    });
  }

  function close() {
    place.hidden = true;
    button.setAttribute("aria-expanded", "false");
    status.textContent = "";
  }

  element.hidden = false;
  button.addEventListener("click", () => {
    if (place.hidden) open().catch(fail);
    else close();
  });
  form.addEventListener("input", () => {
    if (!viewer || place.hidden) return;
    clearTimeout(waiting);
    waiting = setTimeout(() => show().catch(fail), PAUSE);
  });
}
