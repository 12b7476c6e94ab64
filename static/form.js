/**
 * The form of measurements, made smoother: it works without this.
 *
 * Units change without a reload, what is typed survives one, and the list of things to look at
 * takes focus.
 */

const DRAFT = "measurements";

const form = document.getElementById("measurements");

/** What the form holds, but for its token. */
function answers() {
  return [...new FormData(form)].filter(([name]) => name !== "csrf_token");
}

function keepDraft() {
  sessionStorage.setItem(DRAFT, JSON.stringify(answers()));
}

function dropDraft() {
  sessionStorage.removeItem(DRAFT);
}

/** Puts back what was typed and never sent, unless the page has other units by now. */
function restoreDraft() {
  const draft = JSON.parse(sessionStorage.getItem(DRAFT) ?? "[]");
  if (new Map(draft).get("units") !== form.elements.units.value) {
    dropDraft();
    return;
  }
  for (const [name, value] of draft) {
    const field = form.elements.namedItem(name);
    if (field) field.value = value;
  }
}

/** Sends the form for conversion and takes over what comes back: the server alone converts. */
async function switchUnits(button) {
  const body = new URLSearchParams(new FormData(form, button));
  const response = await fetch(form.action, { method: "POST", body });
  if (!response.ok) throw new Error(`units: ${response.status}`);
  const page = new DOMParser().parseFromString(await response.text(), "text/html");
  const converted = page.getElementById("measurements");
  for (const part of ["units", "fields-first", "fields-rest"]) {
    document.getElementById(part).replaceChildren(...converted.querySelector(`#${part}`).childNodes);
  }
  form.elements.units.value = converted.elements.units.value;
  document.getElementById("summary")?.remove();
  dropDraft();
  form.querySelector(`[name=switch_to][value=${button.value}]`).focus();
}

// A browser that fills fields in from an earlier person would show one shopper another's body;
// without this script it is needed, to keep what was typed over a reload.
form.autocomplete = "off";
restoreDraft();
document.getElementById("summary")?.focus();

form.addEventListener("input", keepDraft);
form.addEventListener("submit", (event) => {
  if (event.submitter?.name !== "switch_to") {
    dropDraft();
    return;
  }
  event.preventDefault();
  switchUnits(event.submitter).catch(() => {
    const choice = document.createElement("input");
    Object.assign(choice, { type: "hidden", name: "switch_to", value: event.submitter.value });
    form.append(choice);
    form.submit();
  });
});
