/**
 * The pose network as the browser's runtime takes it: a bundle of the two networks in
 * `@mediapipe/pose`, with the description of their inputs that the newer runtime asks for.
 *
 * The weights stay as they are, byte by byte: a new root is written in front of each file. Field
 * numbers are those of TensorFlow Lite's published schemas (schema.fbs, metadata_schema.fbs).
 */

import { readFileSync } from "node:fs";

import { zipSync } from "fflate";
import { Builder, ByteBuffer } from "flatbuffers";

/** Fields of a table, by the places that the schema gives them. */
const MODEL = { version: 0, subgraphs: 2, buffers: 4, metadata: 6, fields: 8 };
const SUBGRAPH_OUTPUTS = 2;
const RGB = 1;
const IMAGE_PROPERTIES = 2;
const NORMALIZATION_OPTIONS = 1;
const ALIGNMENT = 16;

/** How each network wants its pixels: (value - mean) / deviation, of values from 0 to 255. */
const LANDMARKS = { name: "pose landmarks", mean: 0, deviation: 255 };
const DETECTOR = { name: "pose detector", mean: 127.5, deviation: 127.5 };

/**
 * @param {string} folder where the package `@mediapipe/pose` lies
 * @param {string} size "lite", "full" or "heavy"
 * @returns {Uint8Array} the content of a `.task` file
 */
export function poseBundle(folder, size) {
  const read = (name) => new Uint8Array(readFileSync(`${folder}/${name}`));
  return zipSync(
    {
      "pose_detector.tflite": described(read("pose_solution_packed_assets.data"), DETECTOR),
      "pose_landmarks_detector.tflite": described(read(`pose_landmark_${size}.tflite`), LANDMARKS),
    },
    // The runtime reads the files in place; a fixed date makes the same bytes every time.
    { level: 0, mtime: "2023-02-01T00:00:00" },
  );
}

/**
 * A TensorFlow Lite file with the description of its input and outputs.
 *
 * @param {Uint8Array} file
 * @param {{name: string, mean: number, deviation: number}} about
 * @returns {Uint8Array}
 * @throws {Error} where the file is no TensorFlow Lite model
 */
export function described(file, about) {
  const old = new ByteBuffer(file);
  if (file.length < 8 || old.getBufferIdentifier() !== "TFL3") throw new Error("not a TFL3 model");
  const model = old.readInt32(0);
  const at = (field) => old.__offset(model, 4 + 2 * field);
  const target = (field) => model + at(field) + old.readInt32(model + at(field));
  const elements = (field) =>
    at(field)
      ? Array.from({ length: old.__vector_len(model + at(field)) }, (_, i) =>
          old.__indirect(old.__vector(model + at(field)) + 4 * i),
        )
      : [];

  const builder = new Builder(file.length + 2 ** 16);
  builder.prep(ALIGNMENT, file.length);
  builder.pad(file.length);
  const start = builder.offset();
  const room = builder.dataBuffer();
  room.bytes().set(file, room.capacity() - start);
  const kept = (position) => start - position;

  const [subgraph] = elements(MODEL.subgraphs);
  const outputs = old.__vector_len(subgraph + old.__offset(subgraph, 4 + 2 * SUBGRAPH_OUTPUTS));
  const bytes = description(about, outputs);
  builder.startVector(1, bytes.length, ALIGNMENT);
  for (const byte of [...bytes].reverse()) builder.addInt8(byte);
  const data = builder.endVector();
  const buffer = table(builder, 1, [[0, data]]);
  const buffers = elements(MODEL.buffers).map(kept);
  const metadata = table(
    builder,
    2,
    [[0, builder.createString("TFLITE_METADATA")]],
    [[1, buffers.length]],
  );
  const replaced = new Map([
    [MODEL.buffers, offsets(builder, [...buffers, buffer])],
    [MODEL.metadata, offsets(builder, [...elements(MODEL.metadata).map(kept), metadata])],
  ]);
  const links = [];
  for (let field = 1; field < MODEL.fields; field += 1) {
    if (replaced.has(field)) links.push([field, replaced.get(field)]);
    else if (at(field)) links.push([field, kept(target(field))]);
  }
  const version = old.readInt32(model + at(MODEL.version));
  builder.finish(table(builder, MODEL.fields, links, [[MODEL.version, version]]), "TFL3");
  return builder.asUint8Array();
}

/** A ModelMetadata buffer: one image of three colours goes in, so many tensors come out. */
function description({ name, mean, deviation }, outputs) {
  const builder = new Builder(1024);
  const numbers = (value) => {
    builder.startVector(4, 3, 4);
    for (let i = 0; i < 3; i += 1) builder.addFloat32(value);
    return builder.endVector();
  };
  const tensor = (label, links = []) => {
    const named = [[0, builder.createString(label)], ...links];
    return table(builder, 7, named);
  };
  const union = (kind, value, fields) => {
    builder.startObject(fields);
    builder.addFieldInt8(0, kind, 0);
    builder.addFieldOffset(1, value, 0);
    return builder.endObject();
  };
  builder.startObject(2);
  builder.addFieldInt8(0, RGB, 0);
  const image = builder.endObject();
  const content = union(IMAGE_PROPERTIES, image, 3);
  const [means, deviations] = [numbers(mean), numbers(deviation)];
  const normalization = table(builder, 2, [[0, means], [1, deviations]]);
  const unit = union(NORMALIZATION_OPTIONS, normalization, 2);
  const input = tensor("image", [[3, content], [4, offsets(builder, [unit])]]);
  const results = Array.from({ length: outputs }, (_, i) => tensor(`output_${i}`));
  const subgraph = table(builder, 8, [
    [2, offsets(builder, [input])],
    [3, offsets(builder, results)],
  ]);
  const root = table(builder, 8, [
    [0, builder.createString(name)],
    [3, offsets(builder, [subgraph])],
  ]);
  builder.finish(root, "M001");
  return builder.asUint8Array();
}

/** A table with links to other parts, and with whole numbers. */
function table(builder, fields, links, numbers = []) {
  builder.startObject(fields);
  for (const [field, value] of numbers) builder.addFieldInt32(field, value, 0);
  for (const [field, offset] of links) builder.addFieldOffset(field, offset, 0);
  return builder.endObject();
}

/** A vector of links. */
function offsets(builder, parts) {
  builder.startVector(4, parts.length, 4);
  for (const part of parts.toReversed()) builder.addOffset(part);
  return builder.endVector();
}
