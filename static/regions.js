/** The parts of a body that tapes are shown for together, in the page's order. */

export const REGIONS = Object.freeze({
  head: { label: "Head and neck", names: ["head_girth", "neck_girth", "neck_height"] },
  around: {
    label: "Torso, around",
    names: [
      "armscye_girth",
      "bust_girth",
      "underbust_girth",
      "waist_girth",
      "abdomen_girth",
      "hip_girth",
    ],
  },
  along: {
    label: "Torso, along",
    names: [
      "shoulder_length",
      "collarbone_to_waist_length",
      "collarbone_to_underbust_length",
      "breast_length",
      "underbust_to_belly_button_length",
      "belly_length",
      "front_lower_trunk_length",
      "groin_length",
      "rise_length",
      "armpit_to_waist_length",
      "neck_to_waist_length",
      "glute_length",
      "torso_height",
    ],
  },
  arms: {
    label: "Arms",
    names: [
      "upper_arm_girth",
      "elbow_girth",
      "lower_arm_girth",
      "wrist_girth",
      "arm_length",
      "upper_arm_length",
      "lower_arm_length",
    ],
  },
  legs: {
    label: "Legs",
    names: [
      "thigh_girth",
      "mid_thigh_girth",
      "knee_girth",
      "calf_girth",
      "ankle_girth",
      "waist_height",
      "waist_to_knee_height",
      "inseam_height",
      "hip_to_ankle_height",
      "foot_height",
    ],
  },
});
