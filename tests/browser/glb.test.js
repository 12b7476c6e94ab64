import assert from "node:assert/strict";
import { test } from "node:test";

import { GlbError, readGlb } from "../../static/glb.js";

/** A file of accessors, each an array with its type, laid one after the other. */
function glb({ arrays, mesh, nodes, materials, extensionsRequired }) {
  const views = [];
  const accessors = [];
  let length = 0;
  for (const { values, type, componentType, stride, bytes, ...rest } of arrays) {
    views.push({ byteOffset: length, byteLength: values.byteLength, byteStride: stride });
    length += Math.ceil(values.byteLength / 4) * 4;
    const count = rest.count ?? values.length / { SCALAR: 1, VEC3: 3 }[type];
    accessors.push({ bufferView: views.length - 1, componentType, type, count, ...rest });
  }
  const document = {
    asset: { version: "2.0" },
    meshes: [mesh],
    nodes,
    materials,
    accessors,
    bufferViews: views,
    extensionsRequired,
  };
  const text = Buffer.from(JSON.stringify(document));
  const padded = Buffer.concat([text, Buffer.alloc(-text.length & 3, " ")]);
  const file = Buffer.alloc(12 + 8 + padded.length + 8 + length);
  file.write("glTF", 0);
  file.writeUInt32LE(2, 4);
  file.writeUInt32LE(file.length, 8);
  file.writeUInt32LE(padded.length, 12);
  file.write("JSON", 16);
  padded.copy(file, 20);
  file.writeUInt32LE(length, 20 + padded.length);
  file.write("BIN\0", 24 + padded.length, "latin1");
  arrays.forEach(({ values }, i) => {
    const at = 28 + padded.length + views[i].byteOffset;
    Buffer.from(values.buffer).copy(file, at);
  });
  return file.buffer.slice(file.byteOffset, file.byteOffset + file.length);
}

const FLOAT = 5126;
const INDEX = { values: Uint16Array.of(0, 1, 2), type: "SCALAR", componentType: 5123 };

test("floats come as they are, with targets, their names and steps", () => {
  const file = glb({
    arrays: [
      { values: Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0), type: "VEC3", componentType: FLOAT },
      { values: Float32Array.of(0, 0, 1, 0, 0, 1, 0, 0, 1), type: "VEC3", componentType: FLOAT },
      INDEX,
      { values: Float32Array.of(0, 0, 0, 0.5, 0, 0, 0, 0, 0), type: "VEC3", componentType: FLOAT },
    ],
    mesh: {
      primitives: [
        { attributes: { POSITION: 0, NORMAL: 1 }, indices: 2, material: 0, targets: [{ POSITION: 3 }] },
      ],
      extras: { targetNames: ["waist_girth"], targets: [{ name: "waist_girth", step: 0.1 }] },
    },
    materials: [{ name: "Skin" }],
  });
  const body = readGlb(file);
  assert.deepEqual([...body.positions], [0, 0, 0, 1, 0, 0, 0, 1, 0]);
  assert.deepEqual([...body.normals], [0, 0, 1, 0, 0, 1, 0, 0, 1]);
  assert.deepEqual(body.parts, [{ name: "Skin", index: Uint16Array.of(0, 1, 2) }]);
  assert.equal(body.targets[0].name, "waist_girth");
  assert.equal(body.targets[0].step, 0.1);
  assert.equal(body.targets[0].moves[3], 0.5);
});

test("quantized points become metres by their node, interleaved and normalized ones too", () => {
  const points = Int16Array.of(0, 0, 0, 0, 32767, 0, -32767, 0, 100, 200, 300, 0); // 8 bytes each
  const normals = Int8Array.of(127, 0, 0, 0, 0, -127, 0, 0, 0, 0, 127, 0); // 4 bytes each
  const file = glb({
    arrays: [
      { values: points, type: "VEC3", componentType: 5122, normalized: true, stride: 8, count: 3 },
      { values: normals, type: "VEC3", componentType: 5120, normalized: true, stride: 4, count: 3 },
      INDEX,
      { values: Int16Array.of(0, 0, 0, 0, 10, 0, 0, 0, 0, 0, 0, 0), type: "VEC3", componentType: 5122, stride: 8, count: 3 },
    ],
    mesh: {
      primitives: [{ attributes: { POSITION: 0, NORMAL: 1 }, indices: 2, targets: [{ POSITION: 3 }] }],
    },
    nodes: [{ mesh: 0, scale: [2, 2, 2], translation: [0, 1, 0] }],
    extensionsRequired: ["KHR_mesh_quantization"],
  });
  const { positions, normals: read, targets } = readGlb(file);
  assert.deepEqual([...positions.subarray(0, 6)], [0, 1, 0, 2, 1, -2]);
  assert.ok(Math.abs(positions[8] - (2 * 300) / 32767) < 1e-6);
  assert.deepEqual([...read], [1, 0, 0, 0, -1, 0, 0, 0, 1]);
  assert.deepEqual([...targets[0].moves], [0, 0, 0, 20, 0, 0, 0, 0, 0]); // moved, not shifted
});

test("a sparse accessor is nought but where it says", () => {
  const sparse = {
    count: 1,
    indices: { bufferView: 1, componentType: 5123 },
    values: { bufferView: 2 },
  };
  const arrays = [
    { values: Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0), type: "VEC3", componentType: FLOAT },
    { values: Uint16Array.of(2), type: "SCALAR", componentType: 5123 },
    { values: Float32Array.of(7, 8, 9), type: "VEC3", componentType: FLOAT },
    { ...INDEX },
    { values: new Float32Array(0), type: "VEC3", componentType: FLOAT, count: 3, sparse, bufferView: undefined },
  ];
  const file = glb({
    arrays,
    mesh: { primitives: [{ attributes: { POSITION: 0, NORMAL: 0 }, indices: 3, targets: [{ POSITION: 4 }] }] },
  });
  assert.deepEqual([...readGlb(file).targets[0].moves], [0, 0, 0, 0, 0, 0, 7, 8, 9]);
});

test("what is no avatar is refused", () => {
  assert.throws(() => readGlb(new TextEncoder().encode("no such file".repeat(3)).buffer), GlbError);
  const float = { type: "VEC3", componentType: FLOAT };
  const triangle = { ...float, values: new Float32Array(9) };
  const mesh = { primitives: [{ attributes: { POSITION: 0, NORMAL: 0 }, indices: 1 }] };
  const arrays = [triangle, INDEX];
  assert.throws(() => readGlb(glb({ arrays, mesh: { primitives: [{ attributes: {} }] } })), GlbError);
  const packed = { arrays, mesh, extensionsRequired: ["KHR_draco_mesh_compression"] };
  assert.throws(() => readGlb(glb(packed)), /KHR_draco/);
  assert.throws(() => readGlb(glb({ arrays, mesh, nodes: [{ mesh: 0, rotation: [0, 1, 0, 0] }] })), /turned/);
  const apart = { attributes: { POSITION: 2, NORMAL: 0 }, indices: 1 };
  const split = { primitives: [...mesh.primitives, apart] };
  assert.throws(() => readGlb(glb({ arrays: [...arrays, triangle], mesh: split })), /share/);
});
