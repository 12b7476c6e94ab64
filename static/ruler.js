/** The marks of an upright ruler, in metres and in the words of the shopper's units. */

const INCH = 0.0254;

/**
 * @param {"metric"|"imperial"} units
 * @param {number} top how far up the ruler goes, in metres
 * @returns {{height: number, label: string, long: boolean}[]} from the floor upwards; marks that
 *     are long have a label
 */
export function marks(units, top) {
  const step = units === "metric" ? 0.05 : 3 * INCH;
  const each = 4; // of which every fourth is long: 20 centimetres, a foot
  return Array.from({ length: Math.floor(top / step + 1e-9) + 1 }, (_, i) => ({
    height: i * step,
    long: i % each === 0,
    label: i % each ? "" : units === "metric" ? String((i / each) * 20) : `${i / each}′`,
  }));
}
