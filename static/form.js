/**
 * The forms of the wizard, made smoother: they work without this.
 *
 * What is typed survives a reload and a look at another page, units change without one on the form
 * of all numbers, and the list of answers to look at again takes the focus.
 */

const DRAFTS = "draft of ";
const DRAFT = `${DRAFTS}${location.pathname}`;

const form = document.getElementById("measurements");

/** What tells one session from the next: when measurements are forgotten, so is the draft. */
function session() {
  const [token] = form.elements.csrf_token.value.split(".");
  return token;
}

function keepDraft() {
  const answers = [...new FormData(form)].filter(([name]) => name !== "csrf_token");
  sessionStorage.setItem(DRAFT, JSON.stringify({ session: session(), answers }));
}

function dropDraft() {
  sessionStorage.removeItem(DRAFT);
}

/** When measurements are forgotten, what was typed and never sent goes from every page. */
function dropForgotten() {
  for (const key of Object.keys(sessionStorage)) {
    if (!key.startsWith(DRAFTS)) continue;
    if (JSON.parse(sessionStorage.getItem(key)).session !== session()) sessionStorage.removeItem(key);
  }
}

/** Puts back what was typed and never sent, unless the page has other units by now. */
function restoreDraft() {
  const draft = JSON.parse(sessionStorage.getItem(DRAFT) ?? "{}");
  const answers = new Map(draft.answers);
  const units = form.elements.namedItem("units");
  const other = units.type === "hidden" && answers.get("units") !== units.value;
  if (draft.session !== session() || other) {
    dropDraft();
    return;
  }
  for (const [name, value] of answers) {
    const field = form.elements.namedItem(name);
    if (field) field.value = value;
  }
}

/** Sends the form for conversion and takes over what comes back: the server alone converts. */
async function switchUnits(button) {
  const body = new URLSearchParams(new FormData(form, button));
  const response = await fetch(form.action, { method: "POST", body });
  if (!response.ok) throw new Error(`The units could not be changed: ${response.status}`);
  const page = new DOMParser().parseFromString(await response.text(), "text/html");
  for (const part of ["units", "fields"]) {
    const converted = page.getElementById(part);
    document.getElementById(part).replaceChildren(...converted.childNodes);
  }
  form.elements.units.value = button.value;
  document.getElementById("summary")?.remove();
  document.querySelector("footer").replaceWith(page.querySelector("footer"));
  dropDraft();
  form.querySelector(`[name=switch_to][value=${button.value}]`).focus();
}

/** Lets the browser send the form as if there were no script. */
function sendPlainly(button) {
  const choice = document.createElement("input");
  Object.assign(choice, { type: "hidden", name: button.name, value: button.value });
  form.append(choice);
  form.submit();
}

// Suggestions would show one shopper what another typed on the same device. Without scripts they
// stay, because browsers that are told to leave them out forget the form at a reload too.
form.autocomplete = "off";
dropForgotten();
restoreDraft();
document.getElementById("summary")?.focus();

form.addEventListener("input", keepDraft);
form.addEventListener("submit", (event) => {
  const button = event.submitter;
  if (button?.name === "switch_to" && document.getElementById("fields")) {
    event.preventDefault();
    switchUnits(button).catch(() => sendPlainly(button));
  } else {
    dropDraft();
  }
});

// ---- an inside leg's unit: whatever the page's units, trousers are mostly labelled in inches ----

const unit = document.getElementById("unit");

function tellUnit() {
  const printed = form.elements.namedItem("inseam_height:to")?.value === "trousers";
  unit.textContent = printed ? unit.dataset.printed : unit.dataset.unit;
}

if (unit?.dataset.printed) {
  form.addEventListener("change", tellUnit);
  tellUnit(); // a draft may have been put back
}

// ---- what is said about a number while it is typed ----

const PAUSE = 600; // milliseconds after the last key
const check = document.getElementById("check");
let waiting = 0;
let asking = null;

/** Asks the server, which keeps nothing of it, what it says to the numbers as they stand. */
async function askAboutNumbers() {
  asking?.abort();
  asking = new AbortController();
  const body = new URLSearchParams(new FormData(form));
  const { signal } = asking;
  const response = await fetch(check.dataset.check, { method: "POST", body, signal });
  if (!response.ok) return;
  const { faults, said } = await response.json();
  const template = document.createElement("template");
  template.innerHTML = said; // of our own server's template, which escapes what was typed
  const messages = faults.map((words) => {
    const line = document.createElement("p");
    line.className = "fault";
    line.textContent = words;
    return line;
  });
  check.replaceChildren(...messages, ...template.content.childNodes);
}

if (check) {
  form.addEventListener("input", () => {
    clearTimeout(waiting);
    waiting = setTimeout(() => askAboutNumbers().catch(() => {}), PAUSE);
  });
}
