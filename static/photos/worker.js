/**
 * The worker that finds people in pictures: nothing that it is given leaves this device.
 *
 * It is told `{id, task, ...}` and answers `{id, ...}` or `{id, error}`. Tasks: `start` (where the
 * runtime and the network lie), `outline` (a photo), `watch` (a picture of the camera, and when).
 */

import { PoseLandmarker } from "@mediapipe/tasks-vision";

import { averaged, mirrored, outlined, overlap, thresholded } from "./mask.js";
import { tallestFirst } from "./stance.js";

/** Two, so that a second person is seen. */
const PEOPLE = 2;

let landmarker;
let mode = "IMAGE";

const tasks = { start, outline, watch };
let before = Promise.resolve();

// One after the other: there is one network, which looks at photos or at the camera.
self.onmessage = ({ data }) => {
  before = before.then(() => answer(data));
};

async function answer({ id, task, ...about }) {
  try {
    const answer = await tasks[task](about);
    self.postMessage({ id, ...answer }, answer.data ? [answer.data.buffer] : []);
  } catch (error) {
    self.postMessage({ id, error: String(error?.message ?? error) });
  }
}

/** Loads the runtime and the network, ready for a photo. */
async function start({ loader, binary, model }) {
  const answer = await fetch(model);
  if (!answer.ok) throw new Error(`The network could not be loaded: ${answer.status}`);
  const modelAssetBuffer = new Uint8Array(await answer.arrayBuffer());
  landmarker = await PoseLandmarker.createFromOptions(
    { wasmLoaderPath: loader, wasmBinaryPath: binary },
    {
      baseOptions: { modelAssetBuffer, delegate: "CPU" },
      runningMode: mode,
      numPoses: PEOPLE,
      outputSegmentationMasks: true,
    },
  );
  return {};
}

/** The network as it looks at photos, with masks, or at the camera, without them and faster. */
async function lookingAt(wanted) {
  if (mode !== wanted) {
    const outputSegmentationMasks = wanted === "IMAGE";
    await landmarker.setOptions({ runningMode: wanted, outputSegmentationMasks });
    mode = wanted;
  }
  return landmarker;
}

/** The people in a picture, each with landmarks and where the picture shows them. */
async function people(canvas) {
  const found = [];
  (await lookingAt("IMAGE")).detect(canvas, ({ landmarks, worldLandmarks, segmentationMasks }) => {
    landmarks.forEach((points, i) => {
      const { width, height } = segmentationMasks[i];
      const data = segmentationMasks[i].getAsFloat32Array().slice();
      found.push({ landmarks: points, world: worldLandmarks[i], confidence: { width, height, data } });
    });
  });
  return tallestFirst(found);
}

/** The outline of the person in a photo, and how sure it is: the mirrored photo is asked too. */
async function outline({ picture }) {
  const { width, height } = picture;
  const canvas = new OffscreenCanvas(width, height);
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.drawImage(picture, 0, 0);
  const { data: colours } = context.getImageData(0, 0, width, height);
  const seen = await people(canvas);
  if (!seen.length) return { people: [], agreement: 0, width, height, data: null };
  context.setTransform(-1, 0, 0, 1, width, 0);
  context.drawImage(picture, 0, 0);
  picture.close();
  const [turned] = await people(canvas);
  const [person] = seen;
  const back = turned && mirrored(turned.confidence);
  const agreement = back ? overlap(thresholded(person.confidence), thresholded(back)) : 0;
  const both = back ? averaged(person.confidence, back) : person.confidence;
  return {
    people: seen.map(({ landmarks, world }) => ({ landmarks, world })),
    agreement,
    ...outlined(both, colours),
  };
}

/** How the people before the camera stand. */
async function watch({ frame, time }) {
  const eyes = await lookingAt("VIDEO");
  const { landmarks, worldLandmarks } = eyes.detectForVideo(frame, time);
  frame.close();
  const people = landmarks.map((points, i) => ({ landmarks: points, world: worldLandmarks[i] }));
  return { people: tallestFirst(people) };
}
