import assert from "node:assert/strict";
import { test } from "node:test";

import {
  VIEWS,
  between,
  ease,
  extent,
  fitSlope,
  middleSlope,
  orbitOf,
  partDistance,
  position,
  reach,
  shortestTurn,
} from "../../static/orbit.js";

const near = (actual, expected, tolerance = 1e-12) =>
  assert.ok(Math.abs(actual - expected) <= tolerance, `${actual} is not ${expected}`);

test("the views look from the front, the person's left front, right hand and back", () => {
  const from = (name) => position({ ...VIEWS[name], distance: 2, height: 0.8 });
  const aslant = Math.SQRT2;
  const expected = {
    front: [0, 0.8, 2],
    quarter: [aslant, 0.8, aslant],
    side: [-2, 0.8, 0],
    back: [0, 0.8, -2],
  };
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

test("the fitted lens leaves a twenty-fifth free on the side that is the tightest", () => {
  const camera = { distance: 3, height: 0.9 };
  // A flat cross in the plane of the axis: its slopes are its measures over the distance.
  const cross = Float32Array.of(-0.5, 0.9, 0, 0.5, 0.9, 0, 0, 0, 0, 0, 1.8, 0);
  const free = 1 - 2 * 0.04;
  near(fitSlope(cross, 0.4, camera), 0.5 / 3 / free / 0.4, 1e-6);
  // A wide frame shows it as large as the still pictures do.
  for (const aspect of [0.5, 1, 10]) near(fitSlope(cross, aspect, camera), 0.5 / 3 / free / 0.5, 1e-6);
  const narrow = Float32Array.of(-0.3, 0.9, 0, 0.3, 0.9, 0, 0, 0, 0, 0, 1.8, 0);
  near(fitSlope(narrow, 10, camera), 0.9 / 3 / free, 1e-6);
  // In profile the cross's arms come nearer, but lie on the axis: front decides.
  near(fitSlope(cross, 0.1, camera), 0.5 / 3 / free / 0.1, 1e-6);
  const deep = Float32Array.of(0, 0.9, 1, 0, 0.9, -1, 0, 0.8, 0, 0, 1, 0);
  near(fitSlope(deep, 1, camera), 1 / 3 / free / 0.5, 1e-6);
});

test("a body's middle is found from where it is looked at", () => {
  const camera = { distance: 3, height: 1 };
  const pole = Float32Array.of(0, 0, 0, 0, 1.5, 0);
  for (const azimuth of [0, 1, 2]) near(middleSlope(pole, azimuth, camera), -0.25 / 3, 1e-6);
  const footBefore = Float32Array.of(1, 0, 0, 0, 2, 0); // nearer from the left: lower
  near(middleSlope(footBefore, Math.PI / 2, camera), (-1 / 2 + 1 / 3) / 2, 1e-6);
  near(middleSlope(footBefore, 0, camera), 0, 1e-6);
});

test("a body reaches as far in the frame as its farthest point, from wherever it is seen", () => {
  const orbit = { azimuth: 0, polar: Math.PI / 2, distance: 3, height: 1 };
  const point = (...at) => Float32Array.of(0, 1, 0, ...at);
  near(reach(point(0, 2, 1), orbit, 0.5), 1 / 2, 1e-6);
  near(reach(point(0, -0.5, 0), orbit, 0.5), 1.5 / 3, 1e-6);
  near(reach(point(0.2, 1, 0), orbit, 0.5), 0.2 / 3 / 0.5, 1e-6);
  near(reach(point(0, 1, 0.2), { ...orbit, azimuth: -1.2 }, 1), (0.2 * Math.sin(1.2)) / (3 - 0.2 * Math.cos(1.2)), 1e-6);
  // From above by the angle a: what stands on the axis leans away.
  const [a, up] = [0.4, 0.5];
  const slope = (up * Math.cos(a)) / (3 - up * Math.sin(a));
  for (const azimuth of [0, 2]) {
    near(reach(point(0, 1 + up, 0), { ...orbit, azimuth, polar: Math.PI / 2 - a }, 1), slope, 1e-6);
  }
  near(reach(point(0, 1, 0.5), { ...orbit, polar: Math.PI / 2 - a }, 1), (0.5 * Math.sin(a)) / (3 - 0.5 * Math.cos(a)), 1e-6);
});

test("a part fills its share of the frame, upwards or sideways, from its near side", () => {
  const shares = { tall: 0.8, wide: 0.5 };
  const tall = partDistance({ low: 0.5, high: 1.5, radius: 0.1 }, 0.3, 1, shares) - 0.1;
  near(0.5 / (tall * 0.3), 0.8);
  const wide = partDistance({ low: 0.9, high: 1.1, radius: 0.4 }, 0.3, 0.5, shares) - 0.4;
  near(0.4 / (wide * 0.3 * 0.5), 0.5);
});

test("a part reaches as far as its farthest points, and has some room above and below", () => {
  const points = [[0.2, 1.1, 0.05], [-0.1, 0.9, -0.3]];
  const front = extent(points, 0);
  near(front.low, 0.8);
  near(front.high, 1.2);
  near(front.radius, 0.2);
  near(extent(points, Math.PI / 2).radius, 0.3);
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
  const start = { azimuth: 3, polar: 1, distance: 1, height: 1, slope: 0.3 };
  const end = { azimuth: -3, polar: 2, distance: 4, height: 0.5, slope: 0.2 };
  for (const name of Object.keys(start)) near(between(start, end, 0)[name], start[name]);
  const last = between(start, end, 1);
  near(last.azimuth, 2 * Math.PI - 3);
  for (const name of ["polar", "distance", "height", "slope"]) near(last[name], end[name]);
  near(between(start, end, 0.5).distance, 2);
});
