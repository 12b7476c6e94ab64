/**
 * What the page's scripts say: its template puts their words, in the page's language, into a block
 * of JSON. No script has words of its own.
 */

const block = globalThis.document?.getElementById("words");

/** The words of this page's block; where a page has none, its scripts say nothing. */
export const WORDS = block ? JSON.parse(block.textContent) : {};

/** Words with their places, written as `{name}`, filled in. */
export function fill(text, parts) {
  return text.replace(/\{(\w+)\}/g, (_, name) => parts[name]);
}
