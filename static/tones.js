/** Colours of skin to choose from, sRGB from 0 to 1; the first is a shop mannequin's, of nobody's. */

export const SKIN_TONES = Object.freeze({
  mannequin: { label: "Mannequin", colour: [0.84, 0.765, 0.7] },
  tone1: { label: "Skin 1, lightest", colour: [0.95, 0.85, 0.78] },
  tone2: { label: "Skin 2", colour: [0.9, 0.74, 0.62] },
  tone3: { label: "Skin 3", colour: [0.79, 0.6, 0.45] },
  tone4: { label: "Skin 4", colour: [0.63, 0.44, 0.31] },
  tone5: { label: "Skin 5", colour: [0.46, 0.31, 0.23] },
  tone6: { label: "Skin 6, darkest", colour: [0.31, 0.21, 0.17] },
});
