/**
 * What the mirror needs of an avatar's file, as plain arrays: points, normals, faces and targets.
 *
 * three.js's loader would make materials, bones and textures of them, for its own ways to bend a
 * body on the graphics card. Here the points are bent on the processor, where the page can also
 * lay tapes on them. Reads glTF 2.0 binaries with one mesh on one set of points, floating or
 * quantized (KHR_mesh_quantization), sparse or not.
 *
 * References: Khronos Group, "glTF 2.0 Specification", sections 3.6, 3.7 and 4.4.
 */

const MAGIC = 0x46546c67; // "glTF"
const [JSON_CHUNK, BINARY_CHUNK] = [0x4e4f534a, 0x004e4942];

const ARRAYS = {
  5120: Int8Array,
  5121: Uint8Array,
  5122: Int16Array,
  5123: Uint16Array,
  5125: Uint32Array,
  5126: Float32Array,
};
/** What a normalized integer is divided by. */
const WHOLE = { 5120: 127, 5121: 255, 5122: 32767, 5123: 65535 };
const SIZES = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };

export class GlbError extends Error {}

/**
 * @param {ArrayBuffer} buffer a GLB file
 * @returns {{positions: Float32Array, normals: Float32Array,
 *     parts: {name: string, index: Uint16Array|Uint32Array}[],
 *     targets: {name: string, step: number, moves: Float32Array}[], extras: object}} metres, three
 *     numbers a point in `positions`, `normals` and `moves`; a value that is greater by `step` adds
 *     one time the moves; `extras` are the mesh's own
 * @throws {GlbError} where the file is no avatar
 */
export function readGlb(buffer) {
  const { document, binary } = chunks(buffer);
  const mesh = document.meshes?.[0];
  const first = mesh?.primitives[0];
  if (first?.attributes.POSITION === undefined) throw new GlbError("The file holds no body.");
  const { scale, shift } = placing(document);
  const read = (index) => accessor(document, binary, index);

  const positions = read(first.attributes.POSITION);
  for (let i = 0; i < positions.length; i += 1) {
    positions[i] = positions[i] * scale[i % 3] + shift[i % 3];
  }
  const names = mesh.extras?.targetNames ?? [];
  const targets = (first.targets ?? []).map(({ POSITION }, number) => {
    const moves = read(POSITION);
    for (let i = 0; i < moves.length; i += 1) moves[i] *= scale[i % 3];
    const step = mesh.extras?.targets?.[number]?.step ?? 1;
    return { name: names[number] ?? String(number), step, moves };
  });
  const parts = mesh.primitives.map(({ attributes, indices, material }) => {
    if (attributes.POSITION !== first.attributes.POSITION) {
      throw new GlbError("The body's parts do not share their points.");
    }
    return { name: document.materials?.[material]?.name ?? "", index: read(indices) };
  });
  return {
    positions,
    normals: read(first.attributes.NORMAL),
    parts,
    targets,
    extras: mesh.extras ?? {},
  };
}

function chunks(buffer) {
  const view = new DataView(buffer);
  if (buffer.byteLength < 20 || view.getUint32(0, true) !== MAGIC) {
    throw new GlbError("The file is no GLB.");
  }
  const found = {};
  for (let at = 12; at + 8 <= buffer.byteLength; ) {
    const length = view.getUint32(at, true);
    found[view.getUint32(at + 4, true)] = [at + 8, length];
    at += 8 + length;
  }
  const text = new Uint8Array(buffer, ...found[JSON_CHUNK]);
  const document = JSON.parse(new TextDecoder().decode(text));
  const unknown = (document.extensionsRequired ?? []).filter(
    (name) => name !== "KHR_mesh_quantization",
  );
  if (unknown.length) throw new GlbError(`The file needs ${unknown.join(", ")}.`);
  return { document, binary: { buffer, start: found[BINARY_CHUNK][0] } };
}

/** How the mesh's node places its points, which is how quantized ones become metres. */
function placing(document) {
  const node = document.nodes?.find(({ mesh }) => mesh === 0) ?? {};
  if (node.matrix || node.rotation) throw new GlbError("The body is turned in its file.");
  return { scale: node.scale ?? [1, 1, 1], shift: node.translation ?? [0, 0, 0] };
}

/** The numbers of an accessor: whole ones as they are where they are indices, else floats. */
function accessor(document, binary, number) {
  const { componentType, normalized, count, type, bufferView, byteOffset, sparse } =
    document.accessors[number];
  const size = SIZES[type];
  const whole = type === "SCALAR" && !normalized && componentType !== 5126;
  const result = new (whole ? ARRAYS[componentType] : Float32Array)(count * size);
  if (bufferView !== undefined) {
    const stored = elements(document, binary, { bufferView, byteOffset, componentType, count, size });
    result.set(stored);
  }
  if (sparse) {
    const [at, values] = [
      elements(document, binary, { ...sparse.indices, count: sparse.count, size: 1 }),
      elements(document, binary, { componentType, ...sparse.values, count: sparse.count, size }),
    ];
    at.forEach((place, i) => {
      for (let axis = 0; axis < size; axis += 1) {
        result[place * size + axis] = values[i * size + axis];
      }
    });
  }
  if (normalized) {
    const most = WHOLE[componentType];
    for (let i = 0; i < result.length; i += 1) result[i] = Math.max(result[i] / most, -1);
  }
  return result;
}

/** Numbers as they are stored, one element after the other. */
function elements(document, binary, { bufferView, byteOffset = 0, componentType, count, size }) {
  const Numbers = ARRAYS[componentType];
  const view = document.bufferViews[bufferView];
  const start = binary.start + (view.byteOffset ?? 0) + byteOffset;
  const step = view.byteStride ?? size * Numbers.BYTES_PER_ELEMENT;
  if (step === size * Numbers.BYTES_PER_ELEMENT && start % Numbers.BYTES_PER_ELEMENT === 0) {
    return new Numbers(binary.buffer, start, count * size);
  }
  const result = new Numbers(count * size);
  const bytes = new Uint8Array(result.buffer);
  const length = size * Numbers.BYTES_PER_ELEMENT;
  for (let i = 0; i < count; i += 1) {
    bytes.set(new Uint8Array(binary.buffer, start + i * step, length), i * length);
  }
  return result;
}
