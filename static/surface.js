/** Arithmetic on a surface's points: normals, the nearest, the highest, the feet. Metres. */

/**
 * Smooth normals, not yet of length 1. A face weighs at a corner by the sine of its angle over the
 * lengths of the two sides there (N. Max, Journal of Graphics Tools 4(2), 1999), as on the server.
 *
 * @param {Float32Array} positions three numbers a point
 * @param {ArrayLike<number>[]} faces lists of corners, three a face
 * @param {Float32Array} normals where they are written
 */
export function vertexNormals(positions, faces, normals) {
  normals.fill(0);
  for (const index of faces) {
    for (let f = 0; f < index.length; f += 3) {
      const a = 3 * index[f];
      const b = 3 * index[f + 1];
      const c = 3 * index[f + 2];
      const ux = positions[b] - positions[a];
      const uy = positions[b + 1] - positions[a + 1];
      const uz = positions[b + 2] - positions[a + 2];
      const vx = positions[c] - positions[b];
      const vy = positions[c + 1] - positions[b + 1];
      const vz = positions[c + 2] - positions[b + 2];
      const wx = -ux - vx;
      const wy = -uy - vy;
      const wz = -uz - vz;
      const nx = uy * vz - uz * vy;
      const ny = uz * vx - ux * vz;
      const nz = ux * vy - uy * vx;
      const uu = ux * ux + uy * uy + uz * uz;
      const vv = vx * vx + vy * vy + vz * vz;
      const ww = wx * wx + wy * wy + wz * wz;
      // One division for three: the weight at a is 1 / (uu · ww), and so on.
      const share = 1 / Math.max(uu * vv * ww, 1e-45);
      const atA = vv * share;
      const atB = ww * share;
      const atC = uu * share;
      normals[a] += nx * atA;
      normals[a + 1] += ny * atA;
      normals[a + 2] += nz * atA;
      normals[b] += nx * atB;
      normals[b + 1] += ny * atB;
      normals[b + 2] += nz * atB;
      normals[c] += nx * atC;
      normals[c + 1] += ny * atC;
      normals[c + 2] += nz * atC;
    }
  }
  return unit(normals);
}

/** Vectors brought to length 1 where they stand; one of length 0 points up. */
export function unit(vectors) {
  for (let i = 0; i < vectors.length; i += 3) {
    // Neither taken apart as a list nor by Math.hypot: each takes several times as long.
    const x = vectors[i];
    const y = vectors[i + 1];
    const z = vectors[i + 2];
    const square = x * x + y * y + z * z;
    if (square > 0) {
      const share = 1 / Math.sqrt(square);
      vectors[i] = share * x;
      vectors[i + 1] = share * y;
      vectors[i + 2] = share * z;
    } else {
      vectors[i + 1] = 1;
    }
  }
  return vectors;
}

/**
 * Finds the nearest of some points, by a grid of cubes.
 *
 * @param {Float32Array} positions three numbers a point
 * @param {number} side of a cube
 * @returns {(x: number, y: number, z: number) => number} the number of the nearest point
 */
export function nearest(positions, side = 0.03) {
  const key = (i, j, k) => (i * 4096 + j) * 4096 + k;
  const cell = (value) => Math.floor(value / side);
  const cubes = new Map();
  for (let p = 0; p < positions.length; p += 3) {
    const name = key(...[0, 1, 2].map((axis) => cell(positions[p + axis])));
    if (!cubes.has(name)) cubes.set(name, []);
    cubes.get(name).push(p);
  }
  const farthest = Math.ceil(3 / side);
  return (x, y, z) => {
    const [i, j, k] = [cell(x), cell(y), cell(z)];
    let [best, square] = [-1, Infinity];
    // All points of a shell of cubes lie further away than those of the shells before the last.
    for (let ring = 0; ring <= farthest && square > ((ring - 1) * side) ** 2; ring += 1) {
      for (let a = -ring; a <= ring; a += 1) {
        for (let b = -ring; b <= ring; b += 1) {
          const rim = Math.max(Math.abs(a), Math.abs(b)) === ring;
          for (let c = -ring; c <= ring; c += rim ? 1 : Math.max(1, 2 * ring)) {
            for (const p of cubes.get(key(i + a, j + b, k + c)) ?? []) {
              const far =
                (positions[p] - x) ** 2 +
                (positions[p + 1] - y) ** 2 +
                (positions[p + 2] - z) ** 2;
              if (far < square) [best, square] = [p / 3, far];
            }
          }
        }
      }
    }
    return best;
  };
}

const SOLE = 0.02; // metres above the floor that still are sole

/**
 * Where the feet stand: how far each lies from the middle, and how far in front, in metres.
 *
 * @param {Float32Array} positions three numbers a point
 */
export function feet(positions) {
  let [count, apart, back] = [0, 0, 0];
  for (let i = 0; i < positions.length; i += 3) {
    if (positions[i + 1] > SOLE) continue;
    count += 1;
    apart += Math.abs(positions[i]);
    back += positions[i + 2];
  }
  return { apart: apart / Math.max(count, 1), back: back / Math.max(count, 1) };
}

/** The height of the highest of some points, at least 0. */
export function highest(positions) {
  let height = 0;
  for (let i = 1; i < positions.length; i += 3) height = Math.max(height, positions[i]);
  return height;
}
