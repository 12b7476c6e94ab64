import assert from "node:assert/strict";
import { test } from "node:test";

import { actionOf } from "../../static/hands.js";

/** What a key calls, with what. */
function pressed(key) {
  const heard = [];
  const hear =
    (verb) =>
    (...given) =>
      heard.push([verb, ...given]);
  actionOf(key, { show: hear("show"), zoom: hear("zoom"), turn: hear("turn"), slide: hear("slide") })?.();
  return heard;
}

test("the figures show the four views in the order that the page says", () => {
  const views = ["1", "2", "3", "4"].map((key) => pressed(key)[0]);
  assert.deepEqual(
    views,
    ["front", "quarter", "side", "back"].map((name) => ["show", name]),
  );
});

test("what one arrow or sign does, its opposite undoes", () => {
  const [[, right]] = pressed("ArrowRight");
  const [[, left]] = pressed("ArrowLeft");
  assert.ok(right > 0 && left === -right);
  const [[, , up]] = pressed("ArrowUp");
  const [[, , down]] = pressed("ArrowDown");
  assert.ok(down > 0 && up === -down);
  const [[, nearer]] = pressed("+");
  const [[, farther]] = pressed("-");
  assert.ok(nearer > 1 && Math.abs(nearer * farther - 1) < 1e-12);
  assert.deepEqual(pressed("="), pressed("+"));
  const [[, higher]] = pressed("PageUp");
  const [[, lower]] = pressed("PageDown");
  assert.ok(higher > 0 && lower === -higher);
});

test("other keys stay the browser's", () => {
  for (const key of ["Tab", "5", "a", "toString", "Enter"]) assert.deepEqual(pressed(key), []);
});
