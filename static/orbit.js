/**
 * Where the camera stands around a body: arithmetic only, in metres and radians.
 *
 * An orbit is {azimuth, polar, distance, height, slope}: the azimuth is 0 in front of the person
 * (+Z) and grows towards the person's left (+X); the polar angle is measured from straight above;
 * the camera looks at the point of that height on the body's vertical axis. The slope is the
 * lens's: how far up the picture's upper edge lies for each metre of depth.
 */

const LEVEL = Math.PI / 2;

/**
 * The named views. From the side, the person faces the picture's right; three-quarter is from the
 * person's left, where limbs are measured.
 */
export const VIEWS = Object.freeze({
  front: { azimuth: 0, polar: LEVEL },
  quarter: { azimuth: Math.PI / 4, polar: LEVEL },
  side: { azimuth: -Math.PI / 2, polar: LEVEL },
  back: { azimuth: Math.PI, polar: LEVEL },
});

/** The camera's distance from a whole body, and the picture's free edge: model/cameras.py. */
export const DISTANCE = 3;
const MARGIN = 0.04;

/** Width over height of the two still pictures. */
const STILL_ASPECT = 0.5;

/**
 * The lens that the two still pictures have in a frame of some shape: front and side fit into it
 * at one scale, with a free edge. A frame wider than the pictures shows no larger a body, so that
 * the one in 3D takes a picture's place unnoticed.
 *
 * @param {Float32Array} positions three numbers a point
 * @param {number} aspect width over height of the frame
 * @param {{distance: number, height: number}} camera
 * @returns {number} its slope
 */
export function fitSlope(positions, aspect, { distance, height }) {
  const spans = { x: [0, 0], z: [0, 0], y: [0, 0] };
  const take = (span, value) => {
    if (value < span[0]) span[0] = value;
    if (value > span[1]) span[1] = value;
  };
  for (let i = 0; i < positions.length; i += 3) {
    const x = positions[i];
    const y = positions[i + 1];
    const z = positions[i + 2];
    take(spans.x, x / (distance - z));
    take(spans.z, z / (distance + x));
    take(spans.y, (y - height) / (distance - z));
    take(spans.y, (y - height) / (distance + x));
  }
  const wide = ([low, high]) => (high - low) / (2 * (1 - 2 * MARGIN));
  const across = Math.max(wide(spans.x), wide(spans.z));
  return Math.max(wide(spans.y), across / Math.min(aspect, STILL_ASPECT));
}

/**
 * How high above the picture's middle a body's stands, seen from an azimuth: as a slope.
 *
 * @param {Float32Array} positions three numbers a point
 * @param {number} azimuth
 * @param {{distance: number, height: number}} camera
 */
export function middleSlope(positions, azimuth, { distance, height }) {
  const [across, along] = [Math.sin(azimuth), Math.cos(azimuth)];
  let [low, high] = [Infinity, -Infinity];
  for (let i = 0; i < positions.length; i += 3) {
    const depth = distance - positions[i] * across - positions[i + 2] * along;
    const slope = (positions[i + 1] - height) / depth;
    if (slope < low) low = slope;
    if (slope > high) high = slope;
  }
  return (low + high) / 2;
}

/**
 * The least slope of a lens with which all of a body is in the frame, wherever it is seen from.
 *
 * @param {Float32Array} positions three numbers a point
 * @param {{azimuth: number, polar: number, distance: number, height: number}} orbit
 * @param {number} aspect width over height of the frame
 */
export function reach(positions, { azimuth, polar, distance, height }, aspect) {
  const [right, back] = [Math.cos(azimuth), Math.sin(azimuth)];
  const [flat, above] = [Math.sin(polar), Math.cos(polar)];
  let most = 0;
  for (let i = 0; i < positions.length; i += 3) {
    const y = positions[i + 1] - height;
    const nearer = positions[i] * back + positions[i + 2] * right;
    const depth = distance - flat * nearer - above * y;
    const up = Math.abs(flat * y - above * nearer);
    const across = Math.abs(positions[i] * right - positions[i + 2] * back) / aspect;
    const far = up > across ? up : across;
    if (far > most * depth) most = far / depth;
  }
  return most;
}

/**
 * How near the camera comes to show a part of a body.
 *
 * @param {{low: number, high: number, radius: number}} part heights, and how far it reaches
 *     sideways from the axis
 * @param {number} slope of the lens
 * @param {number} aspect
 * @param {{tall: number, wide: number}} shares of the frame that the part fills at most
 */
export function partDistance({ low, high, radius }, slope, aspect, { tall, wide }) {
  const forHeight = (high - low) / 2 / (slope * tall);
  const forWidth = radius / (slope * aspect * wide);
  return Math.max(forHeight, forWidth) + radius;
}

const AROUND = 0.1; // metres that stay free above and below a part

/**
 * How far some points reach, seen from an azimuth: their heights with something around them, and
 * how far sideways from the axis.
 *
 * @param {number[][]} points
 * @param {number} azimuth
 */
export function extent(points, azimuth) {
  const heights = points.map(([, y]) => y);
  const [right, back] = [Math.cos(azimuth), Math.sin(azimuth)];
  return {
    low: Math.min(...heights) - AROUND,
    high: Math.max(...heights) + AROUND,
    radius: Math.max(...points.map(([x, , z]) => Math.abs(x * right - z * back))),
  };
}

/** The point {x, y, z} from which an orbit looks. */
export function position({ azimuth, polar, distance, height }) {
  const flat = distance * Math.sin(polar);
  return {
    x: flat * Math.sin(azimuth),
    y: height + distance * Math.cos(polar),
    z: flat * Math.cos(azimuth),
  };
}

/** The orbit of a camera that looks from a point, {x, y, z}, at a height of the axis. */
export function orbitOf({ x, y, z }, height) {
  const distance = Math.hypot(x, y - height, z);
  return { azimuth: Math.atan2(x, z), polar: Math.acos((y - height) / distance), distance, height };
}

/** The turn from one azimuth to another on the shorter way: from -π up to π. */
export function shortestTurn(from, to) {
  const turn = (to - from) % (2 * Math.PI);
  if (turn >= Math.PI) return turn - 2 * Math.PI;
  if (turn < -Math.PI) return turn + 2 * Math.PI;
  return turn;
}

/** Slow, fast, slow: 0 at 0 and 1 at 1, at rest at both. */
export function ease(share) {
  const t = clamp(share, 0, 1);
  return t * t * (3 - 2 * t);
}

/** The orbit that lies between two at a share of the way from 0 to 1. */
export function between(start, end, share) {
  const mix = (a, b) => a + (b - a) * share;
  return {
    azimuth: start.azimuth + shortestTurn(start.azimuth, end.azimuth) * share,
    polar: mix(start.polar, end.polar),
    // By ratio, so that coming nearer looks even.
    distance: start.distance * (end.distance / start.distance) ** share,
    height: mix(start.height, end.height),
    slope: start.slope * (end.slope / start.slope) ** share,
  };
}

export function clamp(value, low, high) {
  return Math.min(Math.max(value, low), high);
}
