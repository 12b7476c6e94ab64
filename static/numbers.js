/**
 * Numbers as they stand on the page, read and written as the server does (webapp/units.py), with the
 * decimal sign of the page's language.
 */

import { WORDS, fill } from "./words.js";

const MINUS = "\u2212";
const FOOT = 12; // inches

/** A number with the decimal sign of the page's language. */
function localised(text, { decimal = "." } = WORDS.numbers ?? {}) {
  return text.replace(".", decimal);
}

/** Whether a row of the API's answer is told in feet and inches. */
function inFeet(row) {
  return row.unit === "in" && row.name === "stature";
}

/** A value in the page's unit, to so many decimals; `feet`: inches as 5′ 6.1″. */
export function show(value, feet = false, said = WORDS.numbers, places = 1) {
  const written = (number) => localised(number.toFixed(places), said);
  if (!feet) return written(value);
  const rounded = Number(value.toFixed(places));
  return `${Math.floor(rounded / FOOT)}′ ${written(rounded % FOOT)}″`;
}

/** A value of a row that was entered: as fine as tapes are read, a quarter of an inch stays one. */
export function showEntered(value, row, said = WORDS.numbers) {
  return show(value, inFeet(row), said, row.unit === "in" ? 2 : 1);
}

/** A difference with its sign, a true minus, and none at nought. */
export function showSigned(value, said = WORDS.numbers) {
  const text = Math.abs(value).toFixed(1);
  const sign = Number(text) === 0 ? "" : value < 0 ? MINUS : "+";
  return `${sign}${localised(text, said)}`;
}

/** A row's range, of the ends as they are written. */
export function range(row, said = WORDS.numbers) {
  return fill(said.range, { low: show(row.low, false, said), high: show(row.high, false, said) });
}

/** What a row of the API's answer says in words: "74.0 cm", or with its range. */
export function words(row, said = WORDS.numbers) {
  const feet = inFeet(row);
  const entered = row.asked !== null;
  const shown = entered ? showEntered(row.taken, row, said) : show(row.taken, feet, said);
  const value = feet ? shown : `${shown} ${row.unit}`;
  if (entered) {
    const asked = showEntered(row.asked, row, said);
    return { value, note: asked === shown ? said.entered : fill(said.entered_as, { value: asked }) };
  }
  return { value, note: row.low < row.high ? range(row, said) : said.estimated };
}

/** A value as it stands in a field: two decimals at most; `feet`: inches as 5 ft 6.1 in. */
export function write(value, feet = false, said = WORDS.numbers) {
  const rounded = Math.round(100 * value) / 100;
  if (!feet) return localised(String(rounded), said);
  const inches = Math.round(100 * (rounded % FOOT)) / 100;
  return `${Math.floor(rounded / FOOT)} ft ${localised(String(inches), said)} in`;
}

const AMOUNT = String.raw`(?:(\d+(?:[.,]\d*)?|[.,]\d+)(?![\d/]))?(?:\s*-?\s*(\d+)\s*/\s*(\d+))?`;
const NUMBER = new RegExp(String.raw`^\s*${AMOUNT}\s*$`);
const INCHES = new RegExp(String.raw`^\s*${AMOUNT}\s*(?:"|in|inch|inches)?\.?\s*$`);
const FEET = new RegExp(
  String.raw`^\s*${AMOUNT}\s*(?:'|ft|feet|foot)\.?\s*(?:${AMOUNT}\s*(?:"|in|inch|inches)?\.?)?\s*$`,
);

/**
 * What was typed, in the page's unit: 92,5 or 36 1/4; `feet`: 5'6", 5 ft 6 or 66, in inches. The
 * server knows more spellings.
 *
 * @returns {number} not a number where the page cannot tell
 */
export function parse(text, feet = false) {
  const plain = text
    .toLowerCase()
    .replace(/[\u2018\u2019\u2032`\u00b4]/g, "'")
    .replace(/[\u201c\u201d\u2033]|''/g, '"');
  const two = feet && plain.match(FEET);
  if (two) return FOOT * amount(two.slice(1, 4)) + (amount(two.slice(4, 7)) || 0);
  const one = plain.match(feet ? INCHES : NUMBER);
  return one ? amount(one.slice(1, 4)) : NaN;
}

function amount([whole, over, under]) {
  if (whole === undefined && over === undefined) return NaN;
  const part = over === undefined ? 0 : Number(over) / Number(under);
  return Number((whole ?? "0").replace(",", ".")) + part;
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
