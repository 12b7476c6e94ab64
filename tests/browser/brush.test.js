import assert from "node:assert/strict";
import { test } from "node:test";

import { Painting } from "../../static/photos/brush.js";
import { area } from "../../static/photos/mask.js";

const blank = (width, height) => ({ width, height, data: new Uint8Array(width * height) });

function stroke(painting, from, to, radius, value) {
  painting.begin();
  painting.draw(from, to, radius, value);
}

test("a dab is a disc and a stroke a disc drawn along a line", () => {
  const painting = new Painting(blank(400, 300));
  stroke(painting, { x: 100, y: 100 }, { x: 100, y: 100 }, 40, 1);
  const disc = Math.PI * 40 ** 2;
  assert.ok(Math.abs(area(painting.mask) / disc - 1) < 0.01);
  painting.undo();
  stroke(painting, { x: 100, y: 100 }, { x: 180, y: 160 }, 40, 1);
  assert.ok(Math.abs(area(painting.mask) / (disc + 100 * 80) - 1) < 0.01);
});

test("erasing takes away what adding gave, and only that", () => {
  const painting = new Painting(blank(60, 60));
  const line = [{ x: 10, y: 30 }, { x: 50, y: 30 }, 6];
  stroke(painting, ...line, 1);
  assert.ok(area(painting.mask) > 0);
  stroke(painting, ...line, 0);
  assert.equal(area(painting.mask), 0);
});

test("strokes are taken back one by one, and a reset too", () => {
  const found = blank(50, 50);
  found.data.fill(1, 0, 500);
  const painting = new Painting(found);
  const areas = [area(painting.mask)];
  for (const [x, value] of [[10, 1], [30, 0], [40, 1]]) {
    stroke(painting, { x, y: 10 }, { x, y: 40 }, 5, value);
    areas.push(area(painting.mask));
  }
  painting.reset();
  assert.deepEqual(painting.mask.data, found.data);
  for (const before of areas.toReversed()) {
    painting.undo();
    assert.equal(area(painting.mask), before);
  }
  assert.equal(painting.painted, false);
  painting.undo();
  assert.deepEqual(painting.mask.data, found.data);
});

test("a stroke that changes nothing costs no step back", () => {
  const painting = new Painting(blank(30, 30));
  stroke(painting, { x: 15, y: 15 }, { x: 15, y: 15 }, 5, 1);
  stroke(painting, { x: 15, y: 15 }, { x: 15, y: 15 }, 4, 1);
  painting.undo();
  assert.equal(area(painting.mask), 0);
});

test("a brush over the rim paints what is inside", () => {
  const painting = new Painting(blank(20, 20));
  stroke(painting, { x: -30, y: 10 }, { x: 50, y: 10 }, 100, 1);
  assert.equal(area(painting.mask), 400);
});

test("the mask that was given stays as it was", () => {
  const found = blank(9, 9);
  stroke(new Painting(found), { x: 4, y: 4 }, { x: 4, y: 4 }, 3, 1);
  assert.equal(area(found), 0);
});
