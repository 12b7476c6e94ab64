/**
 * A square picture of a round shadow: dark in the middle, nothing at the rim, smooth at both.
 *
 * @param {number} side its width and height in pixels
 * @param {number} darkest the opacity in the middle, from 0 to 1
 * @returns {Uint8Array} red, green, blue and opacity of each pixel, row by row
 */
export function radialShade(side, darkest = 0.28) {
  const pixels = new Uint8Array(4 * side * side);
  for (let row = 0; row < side; row += 1) {
    for (let column = 0; column < side; column += 1) {
      const far = Math.hypot(column + 0.5 - side / 2, row + 0.5 - side / 2) / (side / 2);
      const light = Math.max(0, 1 - far * far);
      pixels[4 * (row * side + column) + 3] = Math.round(255 * darkest * light * light);
    }
  }
  return pixels;
}
