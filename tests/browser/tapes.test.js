import assert from "node:assert/strict";
import { test } from "node:test";

import { areaNormal, band, outwards, smoothed } from "../../static/bands.js";
import { column, sides } from "../../static/labels.js";
import {
  parse,
  preview,
  show,
  showSigned,
  toSi,
  words,
  write,
} from "../../static/numbers.js";
import { REGIONS } from "../../static/regions.js";
import { marks } from "../../static/ruler.js";
import { Tapes } from "../../static/tapes.js";

const near = (actual, expected, tolerance = 1e-6) =>
  assert.ok(Math.abs(actual - expected) <= tolerance, `${actual} is not ${expected}`);

const ring = Array.from({ length: 24 }, (_, i) => {
  const turn = (2 * Math.PI * i) / 24;
  return [0.1 * Math.cos(turn), 1, 0.1 * Math.sin(turn)];
});

test("a girth's band stands upright around it, as wide as it is said to be", () => {
  const { positions, edges, index } = band(ring, true, [], 0.01);
  const heights = positions.filter((_, i) => i % 3 === 1);
  near(Math.max(...heights) - Math.min(...heights), 0.01, 1e-6);
  for (let i = 0; i < positions.length; i += 3) near(Math.hypot(positions[i], positions[i + 2]), 0.1);
  assert.equal(index.length, 24 * 3 * 6);
  assert.equal(Math.max(...index), positions.length / 3 - 1);
  assert.equal(edges.filter((edge) => edge === 1).length, (2 * edges.length) / 3);
});

test("a length's band lies across its way and the skin's, and is open", () => {
  const path = [[0, 0, 0], [0, 0.1, 0], [0, 0.2, 0]];
  const { positions, index } = band(path, false, path.map(() => [0, 0, 1]), 0.02);
  const across = positions.filter((_, i) => i % 3 === 0);
  near(Math.max(...across), 0.01);
  near(Math.min(...across), -0.01);
  assert.equal(index.length, 2 * 3 * 6);
});

test("the area of a level ring faces up or down, its skin outwards", () => {
  near(Math.abs(areaNormal(ring)[1]), 1);
  outwards(ring).forEach((way, i) => near(way[0], ring[i][0] / 0.1));
});

test("smoothed directions keep a straight line and calm a trembling one", () => {
  const still = smoothed(ring.map(() => [0, 1, 0]));
  for (const way of still) assert.deepEqual(way, [0, 1, 0]);
  const trembling = ring.map((_, i) => [i % 2 ? 0.2 : -0.2, 1, 0]);
  for (const [x] of smoothed(trembling).slice(4, -4)) assert.ok(Math.abs(x) < 0.03);
});

test("labels stay where they would like to be, where there is room", () => {
  const labels = [50, 120, 300].map((wanted) => ({ wanted, height: 30 }));
  assert.deepEqual(column(labels, 0, 400), [50, 120, 300]);
});

test("labels that would overlap share the way, and none leaves the column", () => {
  const [first, second] = column([100, 110].map((wanted) => ({ wanted, height: 30 })), 0, 400, 4);
  near(second - first, 34);
  near((first + second) / 2, 105);
  let seed = 3;
  const random = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
  for (let trial = 0; trial < 50; trial += 1) {
    const labels = Array.from({ length: 8 }, () => ({ wanted: 500 * random() - 50, height: 20 + 20 * random() }));
    const middles = column(labels, 10, 390, 4);
    const order = labels.map((_, i) => i).sort((a, b) => middles[a] - middles[b]);
    order.forEach((i, rank) => {
      assert.ok(middles[i] - labels[i].height / 2 > 10 - 1e-9);
      assert.ok(middles[i] + labels[i].height / 2 < 390 + 1e-9);
      if (!rank) return;
      const above = order[rank - 1];
      const gap = middles[i] - middles[above] - (labels[i].height + labels[above].height) / 2;
      assert.ok(gap > 4 - 1e-9, String(gap));
      assert.ok(labels[above].wanted <= labels[i].wanted);
    });
  }
});

test("labels go to the side that they point to, those in the middle where there are fewer", () => {
  assert.deepEqual(sides([10, 90, 48], 50, 5), ["left", "right", "left"]);
  assert.deepEqual(sides([10, 20, 48, 52], 50, 5), ["left", "left", "right", "right"]);
});

test("a ruler is long each twenty centimetres or each foot", () => {
  const metric = marks("metric", 1.68);
  assert.equal(metric.length, 34);
  assert.deepEqual(metric[8], { height: 0.4, long: true, label: "40" });
  const imperial = marks("imperial", 1.68);
  near(imperial[20].height, 5 * 0.3048);
  assert.equal(imperial[20].label, "5′");
  assert.equal(imperial[21].label, "");
});

test("numbers are written as the server writes them", () => {
  assert.equal(show(74), "74.0");
  assert.equal(show(66.14, true), "5′ 6.1″");
  assert.equal(show(71.97, true), "6′ 0.0″");
  assert.equal(show(15.25), "15.3");
  assert.equal(showSigned(-1.24), "\u22121.2");
  assert.equal(showSigned(0.31), "+0.3");
  assert.equal(showSigned(-0.04), "0.0");
  near(toSi(10, "in"), 0.254);
});

test("numbers are read as the server reads them, feet and inches too", () => {
  for (const [text, value] of [
    ["92,5", 92.5],
    [" 36 1/4 ", 36.25],
    ["36-1/4", 36.25],
    ["3/4", 0.75],
    [".5", 0.5],
  ]) {
    near(parse(text), value);
  }
  for (const [text, value] of [
    ["5'6\"", 66],
    ["5 ft 6", 66],
    ["5′ 6.1″", 66.1],
    ["5’ 6 1/2’’", 66.5],
    ["5 feet", 60],
    ["5 ft 6,25 in", 66.25],
    ["66", 66],
    ["66 in", 66],
  ]) {
    near(parse(text, true), value);
  }
  // The server may know better: it is asked.
  for (const text of ["", "wide", "1.68 m", "-5", "5 6"]) assert.ok(Number.isNaN(parse(text, true)));
  assert.ok(Number.isNaN(parse("5'6\"")));
});

test("numbers are written into fields as the server writes them", () => {
  assert.equal(write(74.5), "74.5");
  assert.equal(write(66.25, true), "5 ft 6.25 in");
  assert.equal(write(71.999, true), "6 ft 0 in");
  assert.equal(write(66.5, true, { decimal: "," }), "5 ft 6,5 in");
  for (const value of [48, 59.75, 66.14, 72]) near(parse(write(value, true), true), value);
});

test("a label says what was entered, or the range", () => {
  const row = { unit: "cm", taken: 74, asked: 74, low: 74, high: 74 };
  const english = {
    decimal: ".",
    range: "{low} to {high}",
    entered: "entered",
    entered_as: "entered {value}",
    estimated: "estimated",
  };
  assert.deepEqual(words(row, english), { value: "74.0 cm", note: "entered" });
  assert.equal(words({ ...row, asked: 72 }, english).note, "entered 72.0");
  assert.equal(words({ ...row, asked: null, low: 70, high: 78 }, english).note, "70.0 to 78.0");
  assert.equal(words({ ...row, asked: null }, english).note, "estimated");
  const portuguese = { ...english, decimal: ",", range: "{low} a {high}" };
  assert.equal(words({ ...row, asked: null, low: 70, high: 78 }, portuguese).note, "70,0 a 78,0");
  const tall = { name: "stature", unit: "in", taken: 66.14, asked: 66.14, low: 66.14, high: 66.14 };
  assert.equal(words(tall, portuguese).value, "5′ 6,14″");
  const neck = { unit: "in", taken: 15.25, asked: 15.25, low: 15.25, high: 15.25 };
  assert.equal(words(neck, english).value, "15.25 in");
});

test("the preview follows the slopes, in the shopper's units, and ranges keep their share", () => {
  const rows = [
    { name: "waist_girth", unit: "in", asked: 30, taken: 30.1, low: 30, high: 30.1 },
    { name: "weight", unit: "lb", asked: null, taken: 150, low: 135, high: 165 },
  ];
  const extras = {
    targets: [{ name: "waist_girth" }],
    measurements: [{ name: "weight", slopes: [100] }], // kilograms a metre
  };
  const [waist, weight] = preview(rows, { waist_girth: 31 }, extras);
  near(waist.asked, 31);
  near(waist.taken, 31.1);
  const gain = (100 * 0.0254) / 0.45359237;
  near(weight.taken, 150 + gain);
  near(weight.low / weight.taken, 0.9);
  assert.deepEqual(preview(rows, {}, extras), rows);
});

test("every measurement with a tape belongs to one region", () => {
  const names = Object.values(REGIONS).flat();
  assert.equal(new Set(names).size, names.length);
  assert.equal(names.length, 39); // all 41 but stature, which the ruler tells, and weight
});

test("tapes go with the skin beneath them, each with its own", () => {
  const served = Float32Array.from([0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 2, 0]);
  const normals = Float32Array.from({ length: 15 }, (_, i) => (i % 3 === 2 ? 1 : 0));
  const shape = { served, positions: served.slice(), normals };
  const rows = [
    { name: "ring", kind: "girth", asked: 1, path: [[0, 0, 0], [1, 0, 0], [1, 0, 1]] },
    { name: "line", kind: "length", asked: null, path: [[0, 1, 0], [0, 2, 0]] },
    { name: "up", kind: "height", asked: null, path: [[0, 2, 0], [0, 0, 0]] },
  ];
  const tapes = new Tapes();
  tapes.lay(rows, shape);
  const positions = () => Array.from(tapes.mesh.geometry.getAttribute("position").array);
  const before = positions();
  assert.equal(before.length, 3 * 6 * 5); // of the height no band is drawn
  // The second point of the ring and the line's first move.
  const [out, up] = [0.25, 0.5];
  shape.positions[3] += out;
  shape.positions[10] += up;
  tapes.follow(shape);
  const moved = positions().map((value, i) => value - before[i]);
  moved.forEach((by, i) => {
    const [corner, axis] = [Math.floor(i / 3 / 6), i % 3];
    const expected = corner === 1 && axis === 0 ? out : corner === 3 && axis === 1 ? up : 0;
    assert.ok(Math.abs(by - expected) < 1e-6, `corner ${i}: ${by}`);
  });
  assert.deepEqual(tapes.laid.map(({ points }) => points), [
    [[0, 0, 0], [1.25, 0, 0], [1, 0, 1]],
    [[0, 1.5, 0], [0, 2, 0]],
    [[0, 2, 0], [0, 0, 0]],
  ]);
  assert.deepEqual(rows[0].path[1], [1, 0, 0]);
});

test("tapes go over to another body from the one that they were laid on", () => {
  const served = Float32Array.from([0, 0, 0, 1, 0, 0, 1, 0, 1]);
  const shape = { served, positions: served.slice(), normals: new Float32Array(9) };
  const ring = { name: "ring", kind: "girth", asked: 1, path: [[0, 0, 0], [1, 0, 0], [1, 0, 1]] };
  const tapes = new Tapes();
  tapes.lay([ring], shape);
  // The next body has come, half as large again, and its own tapes are still on their way.
  shape.served = served.map((value) => 1.5 * value);
  shape.positions.set(shape.served);
  tapes.follow(shape);
  assert.deepEqual(tapes.laid[0].points, [[0, 0, 0], [1.5, 0, 0], [1.5, 0, 1.5]]);
  const after = ring.path.map((point) => point.map((value) => 1.5 * value));
  tapes.lay([{ ...ring, path: after }], shape);
  assert.deepEqual(tapes.laid[0].points, after);
});
