/**
 * Tapes as thin bands: arithmetic only, metres.
 *
 * A band's cross-section has two stripes of edge and one of tape between them, so that it is told
 * from any skin and cloth. It lies on the skin: across the way that the tape runs and the way that
 * the skin faces.
 */

/** Where a band's corners lie across it, from -1 to 1, and whether each is of the light edge. */
const ACROSS = [
  [-1, 1],
  [-0.7, 1],
  [-0.7, 0],
  [0.7, 0],
  [0.7, 1],
  [1, 1],
];
/** Pairs of corners that a stripe runs between. */
const STRIPES = [0, 2, 4];

/**
 * @param {number[][]} path points that the tape runs through
 * @param {boolean} closed whether it comes back to its first point
 * @param {number[][]} normals the way that the skin faces at each point, not used where closed
 * @param {number} width
 * @returns {{positions: Float32Array, edges: Float32Array, index: Uint16Array}} three numbers a
 *     corner, 1 for corners of the edge and 0 for those of the tape, three corners a face
 */
export function band(path, closed, normals, width) {
  const count = path.length;
  const axis = closed ? areaNormal(path) : null;
  const sides = closed ? null : across(path, normals);
  const positions = new Float32Array(count * ACROSS.length * 3);
  const edges = new Float32Array(count * ACROSS.length);
  path.forEach((point, i) => {
    const side = axis ?? sides[i];
    ACROSS.forEach(([share, edge], corner) => {
      const at = i * ACROSS.length + corner;
      edges[at] = edge;
      point.forEach((value, k) => {
        positions[3 * at + k] = value + (share * width * side[k]) / 2;
      });
    });
  });
  const steps = closed ? count : count - 1;
  const index = new Uint16Array(steps * STRIPES.length * 6);
  for (let i = 0, at = 0; i < steps; i += 1) {
    for (const stripe of STRIPES) {
      const here = i * ACROSS.length + stripe;
      const there = ((i + 1) % count) * ACROSS.length + stripe;
      index.set([here, there, here + 1, here + 1, there, there + 1], at);
      at += 6;
    }
  }
  return { positions, edges, index };
}

/** The ways that lie on the skin across an open line. */
function across(path, normals) {
  const ways = path.map((_, i) => {
    const before = path[Math.max(i - 1, 0)];
    const after = path[Math.min(i + 1, path.length - 1)];
    return direction(subtract(after, before));
  });
  return smoothed(smoothed(ways).map((way, i) => direction(cross(way, normals[i]))));
}

/** The direction that a closed line's area faces, by Newell's sums. */
export function areaNormal(path) {
  const sum = [0, 0, 0];
  path.forEach((here, i) => {
    const there = path[(i + 1) % path.length];
    sum[0] += (here[1] - there[1]) * (here[2] + there[2]);
    sum[1] += (here[2] - there[2]) * (here[0] + there[0]);
    sum[2] += (here[0] - there[0]) * (here[1] + there[1]);
  });
  return direction(sum);
}

/** The way outwards at each point of a closed line that lies in a plane about. */
export function outwards(path) {
  const middle = [0, 1, 2].map((k) => path.reduce((sum, point) => sum + point[k], 0) / path.length);
  return path.map((point) => direction(subtract(point, middle)));
}

/** Directions along a line, each averaged with its neighbours': a band that does not flutter. */
export function smoothed(directions, rounds = 4) {
  let result = directions;
  for (let round = 0; round < rounds; round += 1) {
    result = result.map((here, i) => {
      const near = [result[Math.max(i - 1, 0)], here, result[Math.min(i + 1, result.length - 1)]];
      return direction([0, 1, 2].map((k) => near[0][k] + 2 * near[1][k] + near[2][k]));
    });
  }
  return result;
}

function direction(vector) {
  const length = Math.hypot(...vector);
  return length > 0 ? vector.map((value) => value / length) : [0, 1, 0];
}

function subtract(a, b) {
  return a.map((value, k) => value - b[k]);
}

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}
