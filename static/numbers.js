/** Numbers as they stand on the page, the same as the server writes them (webapp/units.py). */

const MINUS = "\u2212";

/** A value in the page's unit: one decimal; `feet`: inches as 5′ 6.1″. */
export function show(value, feet = false) {
  if (!feet) return value.toFixed(1);
  const tenths = Math.round(10 * value);
  return `${Math.floor(tenths / 120)}′ ${((tenths % 120) / 10).toFixed(1)}″`;
}

/** A difference with its sign, a true minus, and none at nought. */
export function showSigned(value) {
  const text = Math.abs(value).toFixed(1);
  if (Number(text) === 0) return text;
  return `${value < 0 ? MINUS : "+"}${text}`;
}

/** What a row of the API's answer says in words: "74.0 cm", or with its range. */
export function words(row) {
  const value = `${show(row.taken)} ${row.unit}`;
  if (row.asked !== null) {
    const met = show(row.asked) === show(row.taken);
    return { value, note: met ? "entered" : `entered ${show(row.asked)}` };
  }
  return { value, note: row.low < row.high ? `${show(row.low)} to ${show(row.high)}` : "estimated" };
}

const SI = { cm: 0.01, in: 0.0254, kg: 1, lb: 0.45359237 };

/** A value or a change of a row, in metres or kilograms. */
export function toSi(value, unit) {
  return value * SI[unit];
}

/**
 * The rows as they would be for other entered values, to first order: what the server will answer
 * a moment later, nearly. An entered value is met as far as it was before.
 *
 * @param {object[]} rows of the API's answer
 * @param {Record<string, number>} asked entered values by name, in the rows' units
 * @param {object} extras of the body's file: its targets, and each measurement's slopes
 */
export function preview(rows, asked, extras) {
  const slopes = new Map(extras.measurements.map(({ name, slopes }) => [name, slopes]));
  const entered = new Map(rows.map((row) => [row.name, row]));
  const changes = extras.targets.map(({ name }) => {
    const row = entered.get(name);
    return row && name in asked ? toSi(asked[name] - row.asked, row.unit) : 0;
  });
  return rows.map((row) => {
    if (row.asked !== null) {
      const value = asked[row.name] ?? row.asked;
      const taken = row.taken + value - row.asked;
      return { ...row, asked: value, taken, low: row.low + value - row.asked, high: row.high + value - row.asked };
    }
    const own = slopes.get(row.name) ?? [];
    const moved = own.reduce((sum, slope, i) => sum + slope * (changes[i] ?? 0), 0);
    const taken = row.taken + moved / SI[row.unit];
    const ratio = taken / row.taken; // a range is a share of its value
    return { ...row, taken, low: row.low * ratio, high: row.high * ratio };
  });
}
