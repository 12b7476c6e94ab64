import assert from "node:assert/strict";
import { test } from "node:test";

import { doubts, facing, findings, tallestFirst, yaw } from "../../static/photos/stance.js";

const FRAME = { width: 900, height: 1350 };
const DEGREE = Math.PI / 180;

/**
 * Someone who stands as asked, metres: x to their left, y up from the floor, z before them. The
 * places of the joints are rough; what is tested is what follows from them.
 */
function stand({ arms = 25, lean = 0, knees = 0, apart = 0.3 } = {}) {
  const points = Array.from({ length: 33 }, () => [0, 1.5, 0.08]);
  const pair = (left, x, y, z = 0) => {
    points[left] = [x, y, z];
    points[left + 1] = [-x, y, z];
  };
  pair(7, 0.07, 1.55);
  pair(11, 0.17, 1.4);
  const reach = (length) => [0.17 + length * Math.sin(arms * DEGREE), 1.4 - length * Math.cos(arms * DEGREE)];
  pair(13, ...reach(0.28));
  pair(15, ...reach(0.52));
  pair(23, 0.1, 0.9);
  pair(25, (0.1 + apart / 2) / 2, 0.48, knees);
  pair(27, apart / 2, 0.08);
  pair(29, apart / 2, 0.03, -0.05);
  pair(31, apart / 2, 0.02, 0.12);
  return points.map(([x, y, z]) => [x + y * Math.tan(lean * DEGREE), y, z]);
}

/** That person turned (90: facing the picture's right) and photographed from far away. */
function photographed(points, { turn = 0, scale = 650, left = 450, floor = 1250 } = {}) {
  const [cos, sin] = [Math.cos(turn * DEGREE), Math.sin(turn * DEGREE)];
  const world = points.map(([x, y, z]) => ({ x: x * cos + z * sin, y: 0.9 - y, z: x * sin - z * cos }));
  const landmarks = points.map(([, y], i) => ({
    x: (left + scale * world[i].x) / FRAME.width,
    y: (floor - scale * y) / FRAME.height,
    visibility: 1,
  }));
  return { landmarks, world };
}

const judged = (view, how, camera) => findings([photographed(stand(how), camera)], view, FRAME);

test("who stands well from the front hears nothing, and so from either side", () => {
  assert.deepEqual(judged("front"), []);
  assert.deepEqual(judged("profile", { arms: 3 }, { turn: 90 }), []);
  assert.deepEqual(judged("profile", { arms: 3 }, { turn: -90 }), []);
});

test("the turn is found again, with the way the person looks", () => {
  for (const turn of [0, 20, 90, -90, 135]) {
    assert.ok(Math.abs(yaw(photographed(stand(), { turn }).world) - turn) < 1e-9);
  }
  assert.equal(facing(photographed(stand(), { turn: 80 }).world), "right");
  assert.equal(facing(photographed(stand(), { turn: -80 }).world), "left");
});

for (const [code, view, how, camera] of [
  ["head_out", "front", {}, { floor: 990 }],
  ["feet_out", "front", {}, { floor: 1400 }],
  ["side_out", "front", {}, { left: 200 }],
  ["too_far", "front", {}, { scale: 250 }],
  ["face_front", "front", {}, { turn: 45 }],
  ["face_front", "front", {}, { turn: 180 }],
  ["face_side", "profile", {}, { turn: 40 }],
  ["arms_out", "front", { arms: 4 }],
  ["arms_down", "front", { arms: 62 }],
  ["lean", "front", { lean: 10 }],
  ["feet_apart", "front", { apart: 0.06 }],
  ["feet_closer", "front", { apart: 0.8 }],
]) {
  test(`${code} is said from the ${view}: ${JSON.stringify({ ...how, ...camera })}`, () => {
    assert.deepEqual(judged(view, how, camera), [code]);
  });
}

test("bent knees and hands held forward are seen from the side", () => {
  assert.deepEqual(judged("profile", { arms: 3, knees: 0.2 }, { turn: 90 }), ["knees"]);
  const person = photographed(stand({ arms: 3 }), { turn: 90 });
  person.landmarks[16].x += 0.25;
  assert.deepEqual(findings([person], "profile", FRAME), ["hands"]);
  person.landmarks[16].visibility = 0.1; // behind the body: a guess
  assert.deepEqual(findings([person], "profile", FRAME), []);
});

test("feet that are not seen are missing, wherever the network guesses them", () => {
  const person = photographed(stand());
  for (const i of [27, 28]) person.landmarks[i].visibility = 0.1;
  assert.deepEqual(findings([person], "front", FRAME), ["feet_out"]);
});

test("nobody, somebody else, one person found twice, and a passer-by far behind", () => {
  assert.deepEqual(findings([], "front", FRAME), ["nobody"]);
  const person = photographed(stand());
  const beside = photographed(stand(), { left: 750 });
  const twice = photographed(stand(), { left: 455 });
  const behind = photographed(stand(), { left: 800, scale: 150 });
  assert.deepEqual(findings([person, beside], "front", FRAME), ["several"]);
  assert.deepEqual(findings([person, twice], "front", FRAME), []);
  assert.deepEqual(findings([person, behind], "front", FRAME), []);
  assert.deepEqual(tallestFirst([behind, person]), [person, behind]);
});

test("another photo is suggested where the photo and its mirror image disagree", () => {
  const found = { people: [photographed(stand())], agreement: 0.91, data: new Uint8Array(1) };
  assert.deepEqual(doubts(found, "front", FRAME), []);
  const unsure = { ...found, agreement: 0.89 };
  assert.deepEqual(doubts(unsure, "front", FRAME), ["unsure"]);
  const leaning = { ...unsure, people: [photographed(stand({ lean: 10 }))] };
  assert.deepEqual(doubts(leaning, "front", FRAME), ["lean", "unsure"]);
  // Where nobody is found there is no outline to be unsure of.
  assert.deepEqual(doubts({ people: [], agreement: 0, data: null }, "front", FRAME), ["nobody"]);
});
