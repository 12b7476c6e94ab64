"""Languages: every text has its words, numbers are written as people there write them."""

import re

import pytest
from conftest import text

import words
from webapp.language import LANGUAGES, TAGS
from webapp.units import parse

OTHERS = [language for language in LANGUAGES if language != "en"]
PLACES = re.compile(r"%\(\w+\)s")


@pytest.fixture(scope="module")
def found():
    return words.texts()


def test_every_language_has_its_translations():
    assert words.languages() == OTHERS
    assert set(TAGS) == set(LANGUAGES)


@pytest.mark.parametrize("language", OTHERS)
def test_nothing_is_left_untranslated_and_the_compiled_file_is_in_step(language, found):
    catalog = words.in_step(language, found)
    assert words.untranslated(catalog) == []
    file = words.po_file(language)
    assert file.with_suffix(".mo").read_bytes() == words.as_mo(catalog), "run: make words"
    assert file.read_bytes() == words.as_po(catalog), "run: make words"


@pytest.mark.parametrize("language", OTHERS)
def test_a_translation_keeps_what_is_filled_in(language, found):
    for message in words.in_step(language, found):
        if message.id:
            ours, theirs = (
                parts[-1] if isinstance(parts, list | tuple) else parts
                for parts in (message.id, message.string)
            )
            assert sorted(PLACES.findall(ours)) == sorted(PLACES.findall(theirs)), ours


def test_what_has_no_words_is_found(found):
    catalog = words.in_step(OTHERS[0], found)
    catalog.add("A text that nobody translated")
    assert words.untranslated(catalog) == ["A text that nobody translated"]


def test_the_browsers_language_is_spoken_until_another_is_chosen(client):
    portuguese = {"Accept-Language": "pt-BR,pt;q=0.9,en;q=0.5"}
    response = client.get("/", headers=portuguese)
    assert client.page.get("lang") == response.headers["Content-Language"] == "pt-PT"
    assert "Accept-Language" in response.headers["Vary"]
    assert text(client.page.find(".//h1")) == "Tire as suas medidas"
    client.get("/", headers={"Accept-Language": "fi"})
    assert client.page.get("lang") == "en-GB"
    client.send("/language", language="pt", page="/numbers")
    client.get("/numbers")
    assert client.page.get("lang") == "pt-PT"


def test_a_change_of_language_keeps_what_is_being_typed_and_the_page(client):
    client.send("/", body="female", units="metric")
    response = client.send("/measure/stature", units="metric", stature="168,5", language="pt")
    assert response.location == "/measure/stature"
    client.get(response.location)
    assert text(client.page.find(".//h1")) == "Altura"
    assert client.page.find(".//input[@id='stature']").get("value") == "168,5"
    response = client.send("/numbers", units="metric", hip_girth="101", language="en")
    client.get(response.location)
    assert client.page.find(".//input[@id='hip_girth']").get("value") == "101"


@pytest.mark.parametrize(
    "page", ["https://elsewhere.example/", "//elsewhere.example", "/\\elsewhere.example", "x", ""]
)
def test_a_change_of_language_leads_nowhere_else(client, page):
    assert client.send("/language", language="pt", page=page).location == "/"


def test_numbers_are_written_as_the_language_writes_them(client):
    client.send("/language", language="pt")
    client.send("/", body="female", units="metric")
    client.send("/measure/stature", units="metric", stature="1.68")
    page = text(client.page)
    assert "Queria dizer 168 cm?" in page
    client.send("/measure/stature", units="metric", stature="168")
    client.send("/measure/hip_girth", units="metric", hip_girth="100", switch_to="imperial")
    client.get("/measure/hip_girth")
    typed = client.page.find(".//input[@id='hip_girth']").get("value")
    assert typed == "39,37"
    assert parse(typed, "m", "imperial") == pytest.approx(1.0, abs=1e-4)
    client.get("/avatar")
    (row,) = [row for row in client.page.iter("tr") if row.get("data-measurement") == "hip_girth"]
    assert "39,37" in text(row)


def test_the_interface_for_programs_speaks_english(client):
    client.send("/language", language="pt")
    document = {"body": "female", "measurements": {"stature": 1.68}}
    answer = client.post("/api/v1/avatars", json=document, headers={"Accept-Language": "pt"})
    assert answer.json["errors"][0]["message"] == "That looks like metres. Did you mean 168 cm?"


def test_forgetting_keeps_the_language(client):
    client.send("/language", language="pt")
    client.send("/forget")
    client.get("/")
    assert client.page.get("lang") == "pt-PT"
    assert "As suas medidas foram esquecidas." in text(client.page)
