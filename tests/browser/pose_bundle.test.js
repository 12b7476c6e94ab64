import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

import { unzipSync } from "fflate";
import { ByteBuffer } from "flatbuffers";

import { described, poseBundle } from "../../scripts/pose_bundle.mjs";

const PACKAGE = fileURLToPath(new URL("../../node_modules/@mediapipe/pose", import.meta.url));
const packed = (name) => new Uint8Array(readFileSync(`${PACKAGE}/${name}`));
const LITE = { name: "pose landmarks", mean: 0, deviation: 255 };

/** The names in a model's list of metadata, and what lies at each. */
function metadata(file) {
  const bytes = new ByteBuffer(file);
  const model = bytes.readInt32(0);
  const list = (table, field) => {
    const at = bytes.__offset(table, 4 + 2 * field);
    const start = bytes.__vector(table + at);
    const count = at ? bytes.__vector_len(table + at) : 0;
    return Array.from({ length: count }, (_, i) => bytes.__indirect(start + 4 * i));
  };
  const buffers = list(model, 4);
  return list(model, 6).map((entry) => {
    const name = bytes.__string(entry + bytes.__offset(entry, 4));
    const buffer = buffers[bytes.readInt32(entry + bytes.__offset(entry, 6))];
    const data = buffer + bytes.__offset(buffer, 4);
    const start = bytes.__vector(data);
    return { name, start, content: file.subarray(start, start + bytes.__vector_len(data)) };
  });
}

test("the weights stay as they were shipped, byte by byte, and aligned as before", () => {
  const shipped = packed("pose_landmark_lite.tflite");
  const file = described(shipped, LITE);
  assert.equal((file.length - shipped.length) % 16, 0);
  assert.ok(file.length - shipped.length < 8192);
  assert.equal(Buffer.compare(file.subarray(-shipped.length), shipped), 0);
});

test("what is new is one description, beside those that were there", () => {
  const shipped = packed("pose_landmark_lite.tflite");
  const before = metadata(shipped);
  const after = metadata(described(shipped, LITE));
  const names = (entries) => entries.map(({ name }) => name);
  assert.deepEqual(names(after), [...names(before), "TFLITE_METADATA"]);
  const { content, start } = after.at(-1);
  assert.equal(start % 16, 0);
  assert.equal(Buffer.from(content.subarray(4, 8)).toString(), "M001");
  assert.deepEqual(
    after.slice(0, -1).map((entry) => Buffer.from(entry.content)),
    before.map((entry) => Buffer.from(entry.content)),
  );
});

test("the bundle holds both networks, stored, and is the same every time", () => {
  const bundle = poseBundle(PACKAGE, "lite");
  assert.equal(Buffer.compare(bundle, poseBundle(PACKAGE, "lite")), 0);
  const entries = unzipSync(bundle);
  assert.deepEqual(Object.keys(entries), ["pose_detector.tflite", "pose_landmarks_detector.tflite"]);
  const sizes = Object.values(entries).reduce((sum, { length }) => sum + length, 0);
  assert.ok(bundle.length > sizes);
});

test("what is no network is refused", () => {
  assert.throws(() => described(packed("index.d.ts"), LITE), /not a TFL3 model/);
});
