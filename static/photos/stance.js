/**
 * How a person stands, from the landmarks that the network finds, and what to say about it.
 *
 * Landmarks are the 33 of MediaPipe's pose: `{x, y, visibility}` as shares of the picture's width
 * and height from its top left corner; world landmarks are metres, x to the picture's right, y
 * down, z away from the camera. Findings are codes, the most important first; their words belong
 * to the page. Angles are degrees.
 */

const NOSE = 0;
const EARS = [7, 8];
const SHOULDERS = [11, 12];
const ELBOWS = [13, 14];
const WRISTS = [15, 16];
const HIPS = [23, 24];
const KNEES = [25, 26];
const ANKLES = [27, 28];
const FEET = [27, 28, 29, 30, 31, 32];

/** The crown above the ears, as a share of the ears' height over the shoulders; hair included. */
const CROWN = 0.75;
/** A landmark less visible than this was guessed. */
const SEEN = 0.3;
/** Limits of what is good enough; shoulders' yaw is noisy by 10 to 20 degrees. */
const LIMITS = {
  smallest: 0.45, // of the picture's height
  second: 0.35, // another person's height, of the first one's
  front: 28,
  side: [60, 120],
  arms: [12, 55],
  hands: 0.13, // of the person's height, from the hip
  lean: 7,
  knees: 155,
  feet: [0.5, 3.2], // between the ankles, of the distance between the hips
};
/** Below this agreement of the photo and its mirror image the outline is not to be trusted. */
const AGREEMENT = 0.9;

/** People in a picture, whoever is the tallest in it first: the others passed by. */
export function tallestFirst(people) {
  const tallness = ({ landmarks }) => {
    const heights = landmarks.map(({ y }) => y);
    return Math.max(...heights) - Math.min(...heights);
  };
  return people.toSorted((one, other) => tallness(other) - tallness(one));
}

/**
 * What should be better before a photo is taken, or what was not good on one.
 *
 * @param {{landmarks: object[], world: object[]}[]} people in the picture, the tallest first
 * @param {"front" | "profile"} view
 * @param {{width: number, height: number}} frame pixels
 * @returns {string[]} codes; none where all is well
 */
export function findings(people, view, frame) {
  if (!people.length) return ["nobody"];
  const [person] = people;
  const found = [];
  if (people.slice(1).some((other) => isSomeoneElse(other, person))) found.push("several");
  found.push(...framing(person.landmarks, frame));
  const turn = yaw(person.world);
  const pose = new Pose(person.landmarks, frame);
  if (view === "front") {
    if (Math.abs(turn) > LIMITS.front) found.push("face_front");
    else found.push(...pose.frontArms());
  } else {
    const [least, most] = LIMITS.side;
    if (Math.abs(turn) < least || Math.abs(turn) > most) found.push("face_side");
    else if (pose.handsAway()) found.push("hands");
  }
  if (pose.lean() > LIMITS.lean) found.push("lean");
  if (pose.straightness() < LIMITS.knees) found.push("knees");
  if (view === "front") found.push(...pose.feet());
  return found;
}

/**
 * Why another photo would give a better outline than the one that was found.
 *
 * @param {{people: object[], agreement: number, data: Uint8Array | null}} found as the worker tells
 * @returns {string[]} codes, as of `findings`; "unsure" last
 */
export function doubts({ people, agreement, data }, view, frame) {
  const found = findings(people, view, frame);
  return data && agreement < AGREEMENT ? [...found, "unsure"] : found;
}

/**
 * How far the person is turned from facing the camera, -180 to 180; 90 faces the picture's right.
 */
export function yaw(world) {
  const across = [SHOULDERS, HIPS].map(([left, right]) => ({
    x: world[left].x - world[right].x,
    z: world[left].z - world[right].z,
  }));
  const x = across[0].x + across[1].x;
  const z = across[0].z + across[1].z;
  return degrees(Math.atan2(z, x));
}

/** Which way a person in profile looks: "right" or "left" in the picture. */
export function facing(world) {
  return yaw(world) >= 0 ? "right" : "left";
}

function framing(landmarks, { width, height }) {
  const found = [];
  const ears = mean(EARS.map((i) => landmarks[i].y));
  const shoulders = mean(SHOULDERS.map((i) => landmarks[i].y));
  const crown = ears - CROWN * (shoulders - ears);
  const soles = Math.max(...FEET.map((i) => landmarks[i].y));
  const unseen = ANKLES.every((i) => (landmarks[i].visibility ?? 1) < SEEN);
  if (crown < 0) found.push("head_out");
  if (soles > 0.995 || unseen) found.push("feet_out");
  const sides = [NOSE, ...SHOULDERS, ...ELBOWS, ...WRISTS, ...ANKLES].map((i) => landmarks[i].x);
  if (Math.min(...sides) < 0.01 || Math.max(...sides) > 0.99) found.push("side_out");
  // A picture that lies on its side is judged by its shorter edge.
  const tall = ((soles - crown) * height) / Math.min(height, width * 2);
  if (!found.length && tall < LIMITS.smallest) found.push("too_far");
  return found;
}

/** The network may find one person twice: whoever stands elsewhere, and is no passer-by far off. */
function isSomeoneElse(other, person) {
  const [one, two] = [box(person.landmarks), box(other.landmarks)];
  if (two.bottom - two.top < LIMITS.second * (one.bottom - one.top)) return false;
  const across = Math.min(one.right, two.right) - Math.max(one.left, two.left);
  const down = Math.min(one.bottom, two.bottom) - Math.max(one.top, two.top);
  const smaller = Math.min(...[one, two].map((b) => (b.right - b.left) * (b.bottom - b.top)));
  return Math.max(0, across) * Math.max(0, down) < 0.5 * smaller;
}

function box(landmarks) {
  const [x, y] = [landmarks.map((point) => point.x), landmarks.map((point) => point.y)];
  return {
    left: Math.min(...x),
    right: Math.max(...x),
    top: Math.min(...y),
    bottom: Math.max(...y),
  };
}

/** Angles and distances in the picture, in pixels. */
class Pose {
  constructor(landmarks, { width, height }) {
    this.points = landmarks.map(({ x, y, visibility }) => ({
      x: x * width,
      y: y * height,
      visibility: visibility ?? 1,
    }));
    const ys = this.points.map(({ y }) => y);
    this.height = Math.max(...ys) - Math.min(...ys);
  }

  /** The middle of some landmarks. */
  middle(indices) {
    return {
      x: mean(indices.map((i) => this.points[i].x)),
      y: mean(indices.map((i) => this.points[i].y)),
    };
  }

  /** What is wrong with the arms: their angles from shoulder to wrist, away from straight down. */
  frontArms() {
    const centre = this.middle(SHOULDERS).x;
    const angles = [0, 1].map((side) => {
      const [shoulder, wrist] = [this.points[SHOULDERS[side]], this.points[WRISTS[side]]];
      const outwards = Math.sign(shoulder.x - centre) || 1;
      return degrees(Math.atan2(outwards * (wrist.x - shoulder.x), wrist.y - shoulder.y));
    });
    const [least, most] = LIMITS.arms;
    if (Math.min(...angles) < least) return ["arms_out"];
    return Math.max(...angles) > most ? ["arms_down"] : [];
  }

  /** Whether a visible hand is away from the thigh, before or behind. */
  handsAway() {
    const hip = this.middle(HIPS).x;
    return WRISTS.some((i) => {
      const { x, visibility } = this.points[i];
      return visibility >= SEEN && Math.abs(x - hip) > LIMITS.hands * this.height;
    });
  }

  /** How far the line from ankles to shoulders is from upright. */
  lean() {
    const [low, high] = [this.middle(ANKLES), this.middle(SHOULDERS)];
    return Math.abs(degrees(Math.atan2(high.x - low.x, low.y - high.y)));
  }

  /** The angle at the more bent of the knees that are seen; 180 is straight. */
  straightness() {
    const angles = [0, 1]
      .filter((side) => this.points[KNEES[side]].visibility >= SEEN)
      .map((side) => angle(...[HIPS, KNEES, ANKLES].map((joint) => this.points[joint[side]])));
    return Math.min(180, ...angles);
  }

  /** What is wrong with how far the feet stand apart. */
  feet() {
    const apart = ([left, right]) => Math.abs(this.points[left].x - this.points[right].x);
    const ratio = apart(ANKLES) / Math.max(1, apart(HIPS));
    const [least, most] = LIMITS.feet;
    if (ratio < least) return ["feet_apart"];
    return ratio > most ? ["feet_closer"] : [];
  }
}

/** The angle at `corner` between two other points. */
function angle(one, corner, other) {
  const [a, b] = [one, other].map(({ x, y }) => Math.atan2(y - corner.y, x - corner.x));
  const between = Math.abs(degrees(a - b)) % 360;
  return Math.min(between, 360 - between);
}

function degrees(radians) {
  return (radians * 180) / Math.PI;
}

function mean(values) {
  return values.reduce((sum, value) => sum + value, 0) / values.length;
}
