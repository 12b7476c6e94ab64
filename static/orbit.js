/**
 * Where the camera stands around a body: arithmetic only, in metres and radians.
 *
 * An orbit is {azimuth, polar, distance, height}: the azimuth is 0 in front of the person (+Z) and
 * grows towards the person's left (+X); the polar angle is measured from straight above; the
 * camera looks at the point of that height on the body's vertical axis.
 */

const LEVEL = Math.PI / 2;

/** The named views. From the side, the person faces the picture's right. */
export const VIEWS = Object.freeze({
  front: { azimuth: 0, polar: LEVEL },
  side: { azimuth: -Math.PI / 2, polar: LEVEL },
  back: { azimuth: Math.PI, polar: LEVEL },
});

/**
 * The distance from which a whole body can be seen from everywhere around it.
 *
 * @param {{height: number, radius: number}} body its height, and the radius of the upright
 *     cylinder that holds it
 * @param {{fieldOfView: number, aspect: number}} lens upright field of view, width over height
 * @param {number} margin how much larger the frame is than the body: 1.1 leaves a tenth free
 */
export function fitDistance(body, lens, margin = 1.05) {
  const slope = Math.tan(lens.fieldOfView / 2);
  const forHeight = ((body.height / 2) * margin) / slope;
  const forWidth = (body.radius * margin) / (slope * lens.aspect);
  // The body's nearest part stands before its axis by the radius.
  return Math.max(forHeight, forWidth) + body.radius;
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
  };
}

export function clamp(value, low, high) {
  return Math.min(Math.max(value, low), high);
}
