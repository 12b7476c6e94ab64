/** The page's tables and sentences, brought up to date with the API's answer. */

import { range, show, showEntered, showSigned } from "./numbers.js";

/** @param {object[]} rows of the API's answer */
export function fillTables(rows) {
  for (const row of rows) {
    const line = document.querySelector(`tr[data-measurement="${row.name}"]`);
    if (!line) continue;
    const cells = line.querySelectorAll("td");
    const texts =
      row.asked === null
        ? [show(row.taken), range(row)]
        : [showEntered(row.asked, row), showEntered(row.taken, row), showSigned(row.taken - row.asked)];
    texts.forEach((text, i) => {
      if (cells[i].textContent !== text) cells[i].textContent = text;
    });
  }
}
