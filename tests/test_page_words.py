"""No text that a shopper sees or hears stands in a script or a template in one language alone."""

import json
import re
from pathlib import Path

import jinja2
import pytest
from conftest import text
from jinja2 import nodes

from model.measurements import MEASUREMENTS

ROOT = Path(__file__).resolve().parent.parent
SCRIPTS = sorted(
    file for file in (ROOT / "static").rglob("*.js") if "build" not in file.relative_to(ROOT).parts
)
TEMPLATES = sorted((ROOT / "templates").rglob("*.html"))

NAME = "The Fitting Room"

# ---------------------------------------------------------------- scripts

TOKEN = re.compile(
    r"""(?P<comment>//[^\n]*|/\*.*?\*/)
      | (?P<error>\bnew\s+\w*Error\([^;"'`]*)?(?P<string>"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'
            |`(?:\\.|[^`\\])*`)
      | (?<=[(,=:!&|?\n])\s*/(?![*/])(?:\\.|\[(?:\\.|[^\]\\\n])*\]|[^/\\\n\[])+/ """,
    re.DOTALL | re.VERBOSE,
)
SPOKEN = re.compile(
    r"(?:\b(?:textContent|innerText|title|alt|placeholder|ariaLabel|label)\s*[=:]"
    r"|setAttribute\(\s*[\"'](?:aria-label|aria-valuetext|title|alt|placeholder)[\"'],"
    r"|SpeechSynthesisUtterance\()\s*$"
)
"""What stands before a string that is shown or read out."""
PROSE = re.compile(r"[A-Za-z]{2,}[,;:]? [A-Za-z]{2,}|^[A-Z][a-z]+\b")
CODE = re.compile(
    r"void main|^\s*:host|^\w+\([^)]*\)$|^\([a-z-]+: [a-z]+\)$"
    r"|^(?:[a-z]+(?:-[a-z]+)+ ?)+$|^[a-z]+ (?:of|with)-[a-z]+$"
)
"""Shaders, style sheets, transformations, questions of media; lists of classes or permissions."""
KNOWN = {NAME, "Enter", "Content-Type", "draft of ", "ft, in"}
"""The site's name, a key, a header, where a draft is kept, and units."""


def texts_in_script(script):
    """Strings of a script that look like words for people; errors speak to programmers."""
    found = []
    for token in TOKEN.finditer(script):
        if token["string"] is None or token["error"]:
            continue
        string = re.sub(r"\$\{[^}]*\}", "", token["string"][1:-1])
        shown = SPOKEN.search(script[: token.start("string")]) and re.search(r"[A-Za-z]", string)
        if string not in KNOWN and not CODE.search(string) and (shown or PROSE.search(string)):
            found.append(string)
    return found


@pytest.mark.parametrize("file", SCRIPTS, ids=lambda file: file.relative_to(ROOT).as_posix())
def test_no_script_has_words_of_its_own(file):
    assert texts_in_script(file.read_text()) == [], "words belong into the page's template"


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ('button.textContent = "none";', ["none"]),
        ('const MESSAGES = { ready: "Your body is here." };', ["Your body is here."]),
        ('const REGIONS = { legs: { label: "legs" } };', ["legs"]),
        ('canvas.setAttribute("aria-label", `In 3D: ${help}`);', ["In 3D: "]),
        ("speak(new SpeechSynthesisUtterance('left'));", ["left"]),
        ('say(`${low} to ${high}, about`); // "Not this one"', []),
        ("say(`from ${low} up to ${high}`);", ["from  up to "]),
        ('throw new ViewerError("This browser cannot show 3D.");', []),
        ('line.className = "tape-label of-entered"; text.replace(/"/g, "")', []),
        ("button.textContent = WORDS.regions[region];", []),
    ],
)
def test_words_in_a_script_are_found(line, found):
    assert texts_in_script(line) == found


# ---------------------------------------------------------------- templates

TRANSLATED = {"_", "gettext", "ngettext", "pgettext", "npgettext"}
ADDRESSES = {"url_for", "static_url"}


def texts_in_template(template):
    """Words of a template that do not go through the translations."""
    html = re.sub(r"\{#.*?#\}|\{%.*?%\}|\{\{.*?\}\}", "", template, flags=re.DOTALL)
    shown = re.findall(r'\b(?:alt|title|placeholder|aria-label)="([^"]*)', html)
    shown += [line.strip() for line in re.sub(r"<[^>]*>", "\n", html).split("\n")]
    found = [string for string in shown if re.search(r"[A-Za-z]{2,}", string)]
    found += _own_strings(jinja2.Environment(autoescape=True).parse(template))
    return [string for string in found if string not in KNOWN | {f"– {NAME}"}]


def _own_strings(node):
    """Strings of a template's expressions that look like words for people."""
    if isinstance(node, nodes.Const) and isinstance(node.value, str):
        return [node.value] if PROSE.search(node.value) else []
    inside = list(node.iter_child_nodes())
    if isinstance(node, nodes.Call) and isinstance(node.node, nodes.Name):
        if node.node.name in ADDRESSES:
            return []
        if node.node.name in TRANSLATED:
            inside = node.kwargs
    return [string for child in inside for string in _own_strings(child)]


@pytest.mark.parametrize("file", TEMPLATES, ids=lambda file: file.relative_to(ROOT).as_posix())
def test_no_template_has_untranslated_words(file):
    assert texts_in_template(file.read_text()) == []


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ('<h1 class="{{ kind }}">Your measurements</h1>', ["Your measurements"]),
        ('<img src="/a.png" alt="Your body, {{ words }}">', ["Your body, "]),
        ('{{ "In inches." if units == "imperial" else _("In cm.") }}', ["In inches."]),
        ('{% set words = ("front", _("From the front")) %}<p>{{ _("Words") }} {{ low }}</p>', []),
        ('{{ _("Use %(value)s", value="This one") }}', ["This one"]),
        ("<b>{# A note. #}</b>", []),
    ],
)
def test_words_in_a_template_are_found(line, found):
    assert texts_in_template(line) == found


# ---------------------------------------------------------------- pages in Portuguese

ENGLISH = re.compile(
    r"\b(?:the|of|and|your|you|with|is|are|was|this|that|to|not|on|by|from|here|body|entered)\b",
    re.I,
)
"""Words that English texts hardly do without, and Portuguese ones never have."""

PERSON = {
    "body": "female",
    "units": "metric",
    "stature": "168",
    "weight": "62,5",
    "waist_girth": "74",
    "hip_girth": "99",
    "inseam_height": "78",
    "inseam_height:to": "floor",
}
PAGES = (
    "/",
    "/measure",
    *(f"/measure/{name}" for name in MEASUREMENTS),
    "/review",
    "/numbers",
    "/avatar",
    "/avatar/sheet",
    "/compare",
    "/nowhere",
)
HEARD = ("alt", "title", "placeholder", "aria-label", "aria-valuetext")


@pytest.fixture
def shopper(client):
    with client.session_transaction() as session:
        session["language"] = "pt"
        session["typed"] = dict(PERSON)
    return client


def said(page):
    """All that a page says: what is seen, what is read out, and what its scripts say later."""
    spoken = [value for element in page.iter() for key, value in element.items() if key in HEARD]
    spoken += [value for element in page.iter() for key, value in element.items() if "data-" in key]
    for block in page.iter("script"):
        if block.get("type") == "application/json":
            spoken += re.findall(r': "([^"]*)"', block.text)
            block.text = ""
    return " | ".join([text(page.find("body")), text(page.find("head/title")), *spoken])


@pytest.mark.parametrize("path", PAGES)
def test_a_portuguese_page_has_no_english_words(shopper, path):
    shopper.get(path)
    assert shopper.page.get("lang") == "pt-PT"
    words = said(shopper.page).replace(NAME, "")
    assert ENGLISH.findall(words) == [], words


@pytest.mark.parametrize("path", ["/", "/measure/waist_girth", "/avatar", "/avatar/sheet"])
def test_an_english_page_has_them(client, path):
    with client.session_transaction() as session:
        session["typed"] = dict(PERSON)
    client.get(path)
    assert len(ENGLISH.findall(said(client.page))) > 15  # the start is short


def test_the_numbers_of_a_portuguese_sheet_and_its_table_are_portuguese(shopper):
    shopper.get("/avatar/sheet")
    page = said(shopper.page)
    assert "As suas medidas" in page and "À volta do corpo" in page
    cells = [text(cell) for cell in shopper.page.iter("td")]
    assert "62,5" in cells and not any("." in cell for cell in cells)
    lines = shopper.get("/avatar.csv").text.splitlines()
    assert lines[0].startswith("measurement,label,unit")  # for programs
    assert any(line.startswith("waist_girth,Cintura,cm,74.00,") for line in lines)


@pytest.mark.parametrize("path", ["/avatar", "/measure/waist_girth"])
def test_scripts_are_told_the_decimal_sign_of_each_pages_language(client, path):
    for language, sign in (("en", "."), ("pt", ","), ("en", ".")):
        with client.session_transaction() as session:
            session["typed"], session["language"] = dict(PERSON), language
        client.get(path)
        (block,) = [it for it in client.page.iter("script") if it.get("id") == "words"]
        assert json.loads(block.text)["numbers"]["decimal"] == sign


def test_a_man_is_not_told_of_bras(client):
    with client.session_transaction() as session:
        session["typed"] = {"body": "male", "units": "metric", "stature": "178"}
    client.get("/measure/bust_girth")
    assert "bra " not in text(client.page)


def test_what_the_mirror_says_later_is_portuguese(shopper):
    answer = shopper.get("/avatar.json").json
    labels = {row["name"]: row["label"] for row in answer["measurements"]}
    assert labels["waist_girth"] == "Cintura"
    ask = {"headers": {"X-CSRFToken": shopper.token()}}
    changed = shopper.post("/avatar.json", json={"neck_girth": "45"}, **ask).json
    assert any("Ao lado dos seus outros números" in it["message"] for it in changed["warnings"])
    refused = shopper.post("/avatar.json", json={"waist_girth": "400"}, **ask).json
    assert "Aqui podemos" in refused["errors"][0]["message"]
