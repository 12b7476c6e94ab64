/**
 * Colours of skin to choose from, sRGB from 0 to 1: a shop mannequin's, which is nobody's; then from
 * the lightest to the darkest.
 */

export const SKIN_TONES = Object.freeze({
  mannequin: [0.84, 0.765, 0.7],
  tone1: [0.95, 0.85, 0.78],
  tone2: [0.9, 0.74, 0.62],
  tone3: [0.79, 0.6, 0.45],
  tone4: [0.63, 0.44, 0.31],
  tone5: [0.46, 0.31, 0.23],
  tone6: [0.31, 0.21, 0.17],
});
