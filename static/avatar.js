/** The avatar's page: starts the viewer and hands it the page's buttons. */

import { createViewer } from "./viewer.js";

const BUTTON_ZOOM = 1.3;

const MESSAGES = {
  loading: "Your avatar in 3D is loading.",
  ready: "Your avatar is here in 3D.",
  failed: "The 3D view is not available here. The pictures show the same body.",
};

const element = document.querySelector("#viewer");
if (element) start(element);

async function start(element) {
  const status = statusLine(element);
  const say = (state) => {
    status.textContent = MESSAGES[state] ?? "";
  };
  // The state may also change later, as when a graphics driver gives up.
  new MutationObserver(() => say(element.dataset.state)).observe(element, {
    attributeFilter: ["data-state"],
  });
  try {
    const viewer = createViewer(element);
    connectButtons(viewer);
    await viewer.load(element.dataset.glb);
  } catch (error) {
    // The picture stays where it is, and so do the other pictures and the download.
    element.dataset.state = "failed";
    console.warn(error.message);
  }
}

function statusLine(element) {
  const line = document.createElement("p");
  line.className = "viewer-status";
  line.setAttribute("role", "status");
  element.append(line);
  return line;
}

function connectButtons(viewer) {
  for (const button of document.querySelectorAll("button[data-view]")) {
    button.addEventListener("click", () => viewer.show(button.dataset.view));
  }
  for (const button of document.querySelectorAll("button[data-zoom]")) {
    const factor = button.dataset.zoom === "in" ? BUTTON_ZOOM : 1 / BUTTON_ZOOM;
    button.addEventListener("click", () => viewer.zoom(factor));
  }
}
