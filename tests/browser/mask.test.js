import assert from "node:assert/strict";
import { test } from "node:test";

import {
  area,
  averaged,
  blackAndWhite,
  bounds,
  cut,
  grown,
  guided,
  largestRegion,
  mirrored,
  outlined,
  overlap,
  pasted,
  silhouetteIn,
  thresholded,
  withoutPinholes,
} from "../../static/photos/mask.js";

/** A mask from lines of "#" and ".". */
function drawn(...lines) {
  const data = Uint8Array.from([...lines.join("")], (sign) => Number(sign === "#"));
  return { width: lines[0].length, height: lines.length, data };
}

const shown = ({ width, height, data }) =>
  Array.from({ length: height }, (_, row) =>
    [...data.subarray(row * width, (row + 1) * width)].map((on) => (on ? "#" : ".")).join(""),
  );

/** A picture whose values are a function of column and row. */
function made(width, height, value, kind = Float32Array) {
  const data = new kind(width * height);
  for (let i = 0; i < data.length; i += 1) data[i] = value(i % width, Math.floor(i / width));
  return { width, height, data };
}

function coloured(width, height, colour) {
  const data = new Uint8ClampedArray(4 * width * height);
  for (let i = 0; i < width * height; i += 1) {
    data.set([...colour(i % width, Math.floor(i / width)), 255], 4 * i);
  }
  return data;
}

test("mirrored twice is as before, and left becomes right", () => {
  const mask = drawn("#..", "##.");
  assert.deepEqual(shown(mirrored(mask)), ["..#", ".##"]);
  assert.deepEqual(mirrored(mirrored(mask)), mask);
});

test("a mean of two confidences is half when one alone is sure", () => {
  const [one, other] = [made(3, 2, () => 1), made(3, 2, (x) => Number(x === 0))];
  assert.deepEqual([...averaged(one, other).data], [1, 0.5, 0.5, 1, 0.5, 0.5]);
  assert.equal(area(thresholded(averaged(one, other), 0.6)), 2);
});

test("overlap is one with itself, none with what lies elsewhere, and a third for half and half", () => {
  const mask = drawn("##..");
  assert.equal(overlap(mask, mask), 1);
  assert.equal(overlap(mask, drawn("..##")), 0);
  assert.equal(overlap(mask, drawn(".##.")), 1 / 3);
  assert.equal(overlap(drawn("...."), drawn("....")), 0);
});

test("bounds are the smallest box, and null for nobody", () => {
  assert.deepEqual(bounds(drawn("....", ".#..", "..#.")), { left: 1, top: 1, right: 3, bottom: 3 });
  assert.equal(bounds(drawn("...")), null);
});

test("the largest region stays alone; corners do not touch", () => {
  const mask = drawn("##..#", "##..#", "..#.#", "#....");
  assert.deepEqual(shown(largestRegion(mask)), ["##...", "##...", ".....", "....."]);
  assert.deepEqual(shown(largestRegion(drawn("..."))), ["..."]);
});

test("small holes are filled, large ones and bays stay", () => {
  const mask = drawn("#######", "#.#..##", "###..#.", "#######");
  const filled = ["#######", "###..##", "###..#.", "#######"];
  assert.deepEqual(shown(withoutPinholes(mask, 1)), filled);
  assert.equal(area(withoutPinholes(mask, 4)), 27);
});

test("a guide of one colour smooths like a mean over squares, twice", () => {
  const size = 21;
  const step = made(size, size, (x) => Number(x >= 10));
  const tidy = guided(step, coloured(size, size, () => [90, 90, 90]), 2);
  // Far from the rim two means over five columns make a ramp from x = 6 to x = 14.
  const row = [...tidy.data.subarray(10 * size, 11 * size)];
  const box = (values, x) => [-2, -1, 0, 1, 2].reduce((sum, d) => sum + values(x + d), 0) / 5;
  for (let x = 4; x < 17; x += 1) {
    const expected = box((at) => box((there) => Number(there >= 10), at), x);
    assert.ok(Math.abs(row[x] - expected) < 1e-6, `${x}: ${row[x]}, not ${expected}`);
  }
});

test("the edge moves to where the photo's colour changes", () => {
  const size = 40;
  const colours = coloured(size, size, (x) => (x < 20 ? [200, 180, 170] : [40, 70, 120]));
  const near = made(size, size, (x) => Number(x < 23)); // three pixels off
  const before = area(thresholded(near));
  const after = area(thresholded(guided(near, colours, 6)));
  assert.equal(before, 23 * size);
  assert.ok(Math.abs(after - 20 * size) <= size, `${after / size} columns, not 20`);
});

test("a confidence that is the guide itself comes back", () => {
  const grey = made(30, 30, (x, y) => ((x * 7 + y * 13) % 32) / 32);
  const colours = coloured(30, 30, (x, y) => Array(3).fill(255 * (((x * 7 + y * 13) % 32) / 32)));
  const tidy = guided(grey, colours, 3, 1e-8);
  const worst = Math.max(...tidy.data.map((value, i) => Math.abs(value - grey.data[i])));
  assert.ok(worst < 0.01, `${worst}`);
});

test("a part that is cut out and put back changes nothing", () => {
  const mask = drawn("#..#", ".##.", "#.#.");
  const box = { left: 1, top: 1, right: 3, bottom: 3 };
  assert.deepEqual(shown(cut(mask, box)), ["##", ".#"]);
  assert.deepEqual(pasted(mask, cut(mask, box), box), mask);
  assert.deepEqual(grown(box, 2, mask), { left: 0, top: 0, right: 4, bottom: 3 });
});

test("the outline is one region along the photo's edge, without specks", () => {
  const inside = (x, y) => x >= 30 && x < 70 && y >= 20 && y < 180;
  const speck = (x, y) => x < 4 && y < 4;
  const hole = (x, y) => x === 50 && y === 100;
  const confidence = made(100, 200, (x, y) =>
    Number((inside(x - 1, y) || speck(x, y)) && !hole(x, y)),
  );
  // Sure by 0.9 at most, so that the filter may move the edge.
  confidence.data.forEach((value, i) => (confidence.data[i] = 0.05 + 0.9 * value));
  const colours = coloured(100, 200, (x, y) => (inside(x, y) ? [210, 160, 140] : [90, 110, 100]));
  const mask = outlined(confidence, colours);
  assert.deepEqual(bounds(mask), { left: 30, top: 20, right: 70, bottom: 180 });
  assert.equal(area(mask), 40 * 160);
  assert.equal(area(outlined(made(9, 9, () => 0), coloured(9, 9, () => [0, 0, 0]))), 0);
});

test("a silhouette file tells the person by light, or by what is not transparent", () => {
  const mask = drawn(".##", "..#");
  assert.deepEqual(silhouetteIn({ ...mask, data: blackAndWhite(mask) }), mask);
  const clear = blackAndWhite(mask).map((value, i) => (i % 4 === 3 ? 255 * mask.data[i >> 2] : 0));
  assert.deepEqual(silhouetteIn({ ...mask, data: clear }), mask);
});

test("what is sent is black and white and nothing else", () => {
  const mask = drawn("#.", ".#");
  assert.deepEqual([...blackAndWhite(mask)].join(), "255,255,255,255,0,0,0,255,0,0,0,255,255,255,255,255");
});
