/** The avatar's page: starts the viewer and hands it the page's buttons. */

import { createViewer } from "./viewer.js";

const BUTTON_ZOOM = 1.3;

const MESSAGES = {
  loading: "Your avatar in 3D is loading.",
  ready: "Your avatar is here in 3D: buttons below turn it and bring it closer.",
  failed: "The 3D view is not available here. The pictures show the same body.",
};

const element = document.querySelector("#viewer");
if (element) start(element);

async function start(element) {
  announce(element);
  try {
    const viewer = createViewer(element);
    element.viewer = viewer; // for what else the page may do with it
    connectButtons(element, viewer);
    await viewer.load(element.dataset.glb);
  } catch (error) {
    // The still picture stays where it is, and so do the two others and the download.
    element.dataset.state = "failed";
    console.warn(error.message);
  }
}

/** A line that is read out when the state changes, also later: a graphics driver may give up. */
function announce(element) {
  const line = document.createElement("p");
  line.className = "viewer-status";
  line.setAttribute("role", "status");
  element.after(line);
  const observer = new MutationObserver(() => {
    line.textContent = MESSAGES[element.dataset.state] ?? "";
  });
  observer.observe(element, { attributeFilter: ["data-state"] });
}

function connectButtons(element, viewer) {
  const views = [...document.querySelectorAll("button[data-view]")];
  for (const button of views) {
    button.addEventListener("click", () => viewer.show(button.dataset.view));
  }
  element.addEventListener("viewchange", ({ detail: view }) => {
    for (const button of views) {
      button.setAttribute("aria-pressed", String(button.dataset.view === view));
    }
  });
  for (const button of document.querySelectorAll("button[data-zoom]")) {
    const factor = button.dataset.zoom === "in" ? BUTTON_ZOOM : 1 / BUTTON_ZOOM;
    button.addEventListener("click", () => viewer.zoom(factor));
  }
}
