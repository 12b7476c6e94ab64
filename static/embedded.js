/**
 * A page of the fitting room in a frame on a shop's page: it answers a greeting by saying which page
 * it is, in one of three words. Of the shopper it says nothing. See docs/embedding.md.
 */

const allowed = document.querySelector("script[data-origins]").dataset.origins.split(" ");

/** @returns {"measurements" | "body" | "photos"} */
function page(path) {
  if (path.startsWith("/avatar")) return "body";
  if (path.startsWith("/compare")) return "photos";
  return "measurements";
}

if (window.parent !== window) {
  window.addEventListener("message", ({ source, origin, data }) => {
    if (source !== window.parent || !allowed.includes(origin)) return;
    if (data?.to !== "fitting-room" || data.version !== 1 || data.event !== "hello") return;
    const answer = { from: "fitting-room", version: 1, event: "page", page: page(location.pathname) };
    source.postMessage(answer, origin);
  });
}
