/**
 * The camera, with an outline to stand in: it says what to do and takes the photo by itself once
 * the person stands well. Pictures of the camera go to the worker on this device and nowhere else.
 */

import { findings } from "./stance.js";

/** Milliseconds. */
const BETWEEN_LOOKS = 200;
const SAME_WORDS = 5000;
const STILL = 1200;
const SECOND = 1000;
/** Counted before the photo, once the person stands well, and when nobody looks. */
const COUNT = 3;
const LONG_COUNT = 10;
/** Pixels of the height of the pictures that are looked at while waiting. */
const LOOKED_AT = 512;

/**
 * @param {HTMLDialogElement} dialog holds a video, `[data-hint]`, `[data-count]` and the buttons
 *   `[data-turn]`, `[data-now]`, `[data-voice]` and `[data-close]`
 * @param {Record<string, string>} words hints by the codes of findings, and the words around them
 */
export function createCamera(dialog, words) {
  const part = (name) => dialog.querySelector(`[data-${name}]`);
  const video = dialog.querySelector("video");
  let facing = "environment";
  let round = 0; // told apart, so that what was begun before closing ends

  function say(text) {
    part("hint").textContent = text;
    speak(text);
  }

  function speak(text) {
    if (part("voice").getAttribute("aria-pressed") !== "true" || !globalThis.speechSynthesis) return;
    const speech = new SpeechSynthesisUtterance(text);
    speech.lang = document.documentElement.lang;
    speechSynthesis.cancel();
    speechSynthesis.speak(speech);
  }

  async function open() {
    const wanted = { facingMode: { ideal: facing }, width: { ideal: 1440 }, height: { ideal: 1440 } };
    const stream = await navigator.mediaDevices.getUserMedia({ video: wanted, audio: false });
    video.srcObject = stream;
    if (!dialog.open) return release(); // closed while the shopper was asked
    await video.play();
    // Who looks at the screen sees themselves as in a mirror; the photo is as it is.
    const [track] = stream.getVideoTracks();
    video.classList.toggle("as-mirror", track.getSettings().facingMode === "user");
    return undefined;
  }

  function release() {
    for (const track of video.srcObject?.getTracks() ?? []) track.stop();
    video.srcObject = null;
    globalThis.speechSynthesis?.cancel();
  }

  const pause = (time) => new Promise((resolve) => setTimeout(resolve, time));

  /** Hints until the person has stood well for a while. */
  async function waitForStance(view, finder, current) {
    let said = "";
    let saidAt = 0;
    let wellSince = null;
    while (current()) {
      const { videoWidth: width, videoHeight: height } = video;
      if (!width) {
        await pause(BETWEEN_LOOKS); // another camera is being opened
        continue;
      }
      const options = { resizeHeight: Math.min(height, LOOKED_AT), resizeQuality: "low" };
      const frame = await createImageBitmap(video, options);
      const now = performance.now();
      const { people } = await finder.watch(frame, now);
      if (!current()) return;
      const [code] = findings(people, view, { width, height });
      dialog.dataset.stance = code ?? "good";
      wellSince = code ? null : (wellSince ?? now);
      if (!code && now - wellSince >= STILL) return;
      const text = words[code ?? "stay"];
      if (text !== said || now - saidAt > SAME_WORDS) {
        say(text);
        said = text;
        saidAt = now;
      }
      await pause(BETWEEN_LOOKS);
    }
  }

  async function count(from, current) {
    for (let left = from; left > 0 && current(); left -= 1) {
      part("count").textContent = left;
      if (left <= COUNT || left === from) say(String(left));
      await pause(SECOND);
    }
    part("count").textContent = "";
  }

  /**
   * Opens the camera and takes one photo.
   *
   * @param {"front" | "profile"} view
   * @param {object | null} finder null where nobody can look: the photo is taken by the clock
   * @returns {Promise<ImageBitmap | null>} null where the shopper closed the camera
   * @throws where there is no camera, or none is allowed
   */
  async function take(view, finder) {
    round += 1;
    const mine = round;
    let hurry = false;
    const current = () => mine === round && dialog.open;
    part("hint").textContent = words.opening;
    dialog.dataset.view = view;
    dialog.showModal();
    const now = () => {
      hurry = true;
    };
    part("now").addEventListener("click", now);
    try {
      await open();
      if (!current()) return null;
      const watching = () => current() && !hurry;
      if (finder) {
        say(words[view]);
        await waitForStance(view, finder, watching);
      } else {
        say(words.by_clock);
        while (watching()) await pause(BETWEEN_LOOKS);
      }
      await count(hurry ? LONG_COUNT : COUNT, current);
      if (!current()) return null;
      const photo = await createImageBitmap(video);
      say(words.taken);
      return photo;
    } finally {
      part("now").removeEventListener("click", now);
      if (mine === round) {
        release();
        if (dialog.open) dialog.close();
      }
    }
  }

  /** To be called within a click: iOS lets a page speak only if it first spoke in one. */
  function greet() {
    speak(words.greeting);
  }

  part("close").addEventListener("click", () => dialog.close());
  dialog.addEventListener("close", () => {
    round += 1;
    release();
  });
  part("turn").addEventListener("click", async () => {
    facing = facing === "user" ? "environment" : "user";
    release(); // telephones open one camera at a time
    await open().catch(() => dialog.close());
  });
  part("voice").addEventListener("click", ({ currentTarget: button }) => {
    const on = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", String(on));
    if (on) greet();
    else globalThis.speechSynthesis?.cancel();
  });

  return { take, greet };
}
