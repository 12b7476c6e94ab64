/**
 * The fitting room on a shop's own page, by one script tag:
 *
 *     <script src="https://fitting.shop.example/static/embed.js" defer></script>
 *
 * It defines the element <fitting-room>, and puts one where the script stands if the page has none.
 * The element holds a frame of the fitting room's own origin: the page around it cannot look inside.
 * Where there can be no frame it is a link, in the words of the shop's page: what stands in the
 * element, or in the script's `data-link`.
 * What the two tell one another is in docs/embedding.md.
 */
(() => {
  const script = document.currentScript;
  const home = new URL(script.src).origin;
  const NAME = "The Fitting Room";
  const PATIENCE = 5000; // milliseconds until a frame that does not answer is a link

  const style = new CSSStyleSheet();
  style.replaceSync(`
    :host { display: block; height: 50rem; max-height: 100vh; }
    iframe { width: 100%; height: 100%; border: 0; }
    a { display: inline-block; padding: 1rem; font: inherit; }
    [hidden] { display: none; }
  `);

  class FittingRoom extends HTMLElement {
    #frame = document.createElement("iframe");
    #link = document.createElement("a");
    #hear = (message) => this.#heard(message);
    #waiting = 0;

    constructor() {
      super();
      const frame = this.#frame;
      frame.title = NAME;
      frame.src = `${home}/`;
      frame.allow = `camera ${home}`;
      frame.referrerPolicy = "no-referrer";
      frame.setAttribute(
        "sandbox",
        "allow-scripts allow-same-origin allow-forms allow-downloads allow-modals",
      );
      frame.addEventListener("load", () => this.#greet());
      Object.assign(this.#link, {
        href: `${home}/`,
        target: "_blank",
        rel: "noopener",
        hidden: true,
      });
      const words = document.createElement("slot");
      words.textContent = NAME;
      this.#link.append(words);
      const root = this.attachShadow({ mode: "open" });
      root.adoptedStyleSheets = [style];
      root.append(frame, this.#link);
    }

    connectedCallback() {
      window.addEventListener("message", this.#hear);
    }

    disconnectedCallback() {
      window.removeEventListener("message", this.#hear);
      clearTimeout(this.#waiting);
    }

    /** Every page in the frame is greeted; from a page that may not be here, no answer comes. */
    #greet() {
      clearTimeout(this.#waiting);
      this.#waiting = setTimeout(() => this.#giveUp(), PATIENCE);
      this.#frame.contentWindow.postMessage({ to: "fitting-room", version: 1, event: "hello" }, home);
    }

    #giveUp() {
      this.#frame.hidden = true;
      this.#link.hidden = false;
      this.dispatchEvent(new CustomEvent("fitting-room-unavailable", { bubbles: true }));
    }

    #heard({ source, origin, data }) {
      if (source !== this.#frame.contentWindow || origin !== home) return;
      if (data?.from !== "fitting-room" || data.version !== 1 || data.event !== "page") return;
      clearTimeout(this.#waiting);
      const detail = { page: data.page };
      this.dispatchEvent(new CustomEvent("fitting-room-page", { bubbles: true, detail }));
    }
  }

  customElements.define("fitting-room", FittingRoom);
  const place = () => {
    if (document.querySelector("fitting-room")) return;
    const element = document.createElement("fitting-room");
    if (script.dataset.link) element.append(script.dataset.link);
    script.after(element);
  };
  if (document.readyState === "loading") document.addEventListener("DOMContentLoaded", place);
  else place();
})();
