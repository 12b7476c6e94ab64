import assert from "node:assert/strict";
import { test } from "node:test";

import {
  VIEWS,
  between,
  ease,
  fitDistance,
  orbitOf,
  position,
  shortestTurn,
} from "../../static/orbit.js";
import { radialShade } from "../../static/shade.js";

const near = (actual, expected, tolerance = 1e-12) =>
  assert.ok(Math.abs(actual - expected) <= tolerance, `${actual} is not ${expected}`);

test("the views look from the front, the person's right hand and the back", () => {
  const from = (name) => position({ ...VIEWS[name], distance: 2, height: 0.8 });
  const expected = { front: [0, 0.8, 2], side: [-2, 0.8, 0], back: [0, 0.8, -2] };
  for (const [name, point] of Object.entries(expected)) {
    const { x, y, z } = from(name);
    [x, y, z].forEach((value, axis) => near(value, point[axis]));
  }
});

test("an orbit is found again from its point", () => {
  const orbit = { azimuth: -1.2, polar: 1.1, distance: 3.4, height: 0.9 };
  const again = orbitOf(position(orbit), orbit.height);
  for (const name of Object.keys(orbit)) near(again[name], orbit[name]);
});

test("the fitted distance shows the body's cylinder whole, and no more than the margin", () => {
  const lens = { fieldOfView: 0.5, aspect: 0.6 };
  const slope = Math.tan(lens.fieldOfView / 2);
  for (const body of [
    { height: 1.7, radius: 0.2 },
    { height: 1.5, radius: 0.7 },
  ]) {
    const depth = fitDistance(body, lens, 1) - body.radius; // of the cylinder's nearest line
    const tall = body.height / 2 / (depth * slope);
    const wide = body.radius / (depth * slope * lens.aspect);
    near(Math.max(tall, wide), 1);
  }
});

test("a turn takes the shorter way round", () => {
  near(shortestTurn(0, 1), 1);
  near(shortestTurn(0.1, 2 * Math.PI - 0.1), -0.2);
  near(shortestTurn(3, -3), 2 * Math.PI - 6);
  near(shortestTurn(0, 8 * Math.PI + 0.5), 0.5);
  for (let from = -9; from < 9; from += 0.7) {
    for (let to = -9; to < 9; to += 0.7) {
      const turn = shortestTurn(from, to);
      assert.ok(Math.abs(turn) <= Math.PI + 1e-12);
      near(Math.cos(from + turn), Math.cos(to));
      near(Math.sin(from + turn), Math.sin(to));
    }
  }
});

test("easing begins and ends at rest, and never turns back", () => {
  near(ease(0), 0);
  near(ease(1), 1);
  near(ease(-1), 0);
  near(ease(2), 1);
  near(ease(0.5), 0.5);
  const step = 1e-4;
  assert.ok(ease(step) / step < 1e-3 && (1 - ease(1 - step)) / step < 1e-3);
  for (let share = 0; share < 1; share += 0.05) assert.ok(ease(share + 0.05) > ease(share));
});

test("between two orbits, both ends are met and the distance grows by ratio", () => {
  const start = { azimuth: 3, polar: 1, distance: 1, height: 1 };
  const end = { azimuth: -3, polar: 2, distance: 4, height: 0.5 };
  for (const name of Object.keys(start)) near(between(start, end, 0)[name], start[name]);
  const last = between(start, end, 1);
  near(last.azimuth, 2 * Math.PI - 3);
  for (const name of ["polar", "distance", "height"]) near(last[name], end[name]);
  near(between(start, end, 0.5).distance, 2);
});

test("a round shade is darkest in the middle, gone at the rim, and round", () => {
  const side = 32;
  const pixels = radialShade(side, 0.5);
  const at = (row, column) => pixels[4 * (row * side + column) + 3];
  assert.equal(pixels.length, 4 * side * side);
  assert.ok(at(16, 16) > 120 && at(16, 16) <= 128);
  assert.equal(at(0, 0), 0);
  assert.ok(at(16, 0) <= 2);
  for (let row = 0; row < side; row += 1) {
    for (let column = 0; column < side; column += 1) {
      assert.equal(at(row, column), at(column, row));
      assert.equal(at(row, column), at(side - 1 - row, column));
    }
  }
});
