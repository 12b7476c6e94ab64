import assert from "node:assert/strict";
import { test } from "node:test";

import { Shape } from "../../static/shape.js";
import { feet, highest, nearest, vertexNormals } from "../../static/surface.js";

const near = (actual, expected, tolerance = 1e-6) =>
  assert.ok(Math.abs(actual - expected) <= tolerance, `${actual} is not ${expected}`);
const allNear = (actual, expected, tolerance) =>
  actual.forEach((value, i) => near(value, expected[i], tolerance));

/** An octahedron about a point, with the normals of the sphere around it. */
const CORNERS = [1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1];
const FACES = Uint16Array.of(
  0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5,
);

function ball(targets = []) {
  const positions = Float32Array.from(CORNERS, (value, i) => value + (i % 3 === 1 ? 1 : 0));
  const normals = Float32Array.from(CORNERS);
  return { positions, normals, parts: [{ name: "Skin", index: FACES }], targets };
}

const wider = { name: "waist_girth", step: 0.1, moves: Float32Array.from(CORNERS, (v, i) => (i % 3 ? 0 : v)) };
const taller = { name: "stature", step: 0.1, moves: Float32Array.from(CORNERS, (v, i) => (i % 3 === 1 ? v + 1 : 0)) };

test("on a sphere the normals are the radii", () => {
  const stretched = Float32Array.from(CORNERS, (value) => 3 * value);
  allNear(vertexNormals(stretched, [FACES], new Float32Array(18)), CORNERS);
});

test("a point without a face faces upwards", () => {
  const normals = vertexNormals(new Float32Array(9), [Uint16Array.of()], new Float32Array(9));
  assert.deepEqual([...normals], [0, 1, 0, 0, 1, 0, 0, 1, 0]);
});

test("the nearest point is the one that a look at all of them finds", () => {
  let seed = 1;
  const random = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
  const points = Float32Array.from({ length: 900 }, () => 2 * random() - 1);
  const find = nearest(points, 0.1);
  for (let trial = 0; trial < 100; trial += 1) {
    const place = [0, 1, 2].map(() => 3 * random() - 1.5);
    let [best, least] = [-1, Infinity];
    for (let p = 0; p < 300; p += 1) {
      const far = Math.hypot(...place.map((value, k) => points[3 * p + k] - value));
      if (far < least) [best, least] = [p, far];
    }
    assert.equal(find(...place), best);
  }
});

test("feet are what touches the floor, and the height is the highest point's", () => {
  const standing = Float32Array.of(0.1, 0.01, 0.2, -0.3, 0, 0.1, 0.5, 1.7, 0.9);
  const { apart, back } = feet(standing);
  near(apart, 0.2);
  near(back, 0.15);
  near(highest(standing), 1.7);
  assert.deepEqual(feet(new Float32Array()), { apart: 0, back: 0 });
  assert.equal(highest(new Float32Array()), 0);
});

test("changes add up, each by its step, and nought is the served body to the last bit", () => {
  const shape = new Shape(ball([wider, taller]));
  const served = [...shape.positions];
  shape.bend({ waist_girth: 0.02, stature: 0.05 });
  const expected = served.map((v, i) => v + 0.2 * wider.moves[i] + 0.5 * taller.moves[i]);
  allNear(shape.positions, expected);
  shape.bend({ neck_girth: 1 });
  assert.deepEqual([...shape.positions], served);
  assert.deepEqual([...shape.normals], CORNERS);
});

test("a body that bends stays on the floor", () => {
  const sinks = { name: "weight", step: 1, moves: Float32Array.from(CORNERS, (v, i) => (i % 3 === 1 ? -0.3 : 0)) };
  const shape = new Shape(ball([sinks]));
  shape.bend({ weight: 1 });
  near(Math.min(...shape.positions.filter((_, i) => i % 3 === 1)), 0);
});

test("normals follow the body, and keep what the cloth has smoothed", () => {
  const body = ball([wider]);
  body.normals.set([0, 0, 1], 0); // as cloth would have it
  const shape = new Shape(body);
  shape.bend({ waist_girth: 0.1 });
  const bent = vertexNormals(shape.positions, [FACES], new Float32Array(18));
  for (let i = 3; i < 18; i += 1) near(shape.normals[i], bent[i]);
  assert.ok(shape.normals[2] > 0.9);
  for (let i = 0; i < 18; i += 3) near(Math.hypot(...shape.normals.subarray(i, i + 3)), 1);
});

test("another body takes over without a jump, whatever changes meanwhile", () => {
  const shape = new Shape(ball([wider]));
  shape.bend({ waist_girth: 0.05 });
  const shown = [...shape.positions];
  const next = ball();
  next.positions.forEach((value, i) => {
    next.positions[i] = value * (i % 3 === 0 ? 1.6 : 1);
  });
  shape.replace(next, { waist_girth: 0 });
  allNear(shape.positions, shown);
  shape.bend({ waist_girth: 0.01 });
  near(shape.positions[0] - shown[0], 0.1);
  shape.approach(0.5);
  near(shape.positions[0], (shown[0] + 1.6) / 2 + 0.1);
  assert.ok(shape.moving);
  shape.bend({});
  shape.approach(1);
  assert.ok(!shape.moving);
  assert.deepEqual([...shape.positions], [...next.positions]);
});

test("a body on another mesh is refused", () => {
  const shape = new Shape(ball());
  assert.throws(() => shape.replace({ ...ball(), positions: new Float32Array(3) }), RangeError);
});
