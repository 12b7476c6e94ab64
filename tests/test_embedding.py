"""The fitting room on shops' pages: who may frame it, and what becomes of the cookie."""

import json
import re
from pathlib import Path

import pytest

from webapp.settings import environment

DOCS = Path(__file__).resolve().parent.parent / "docs"
SHOPS = "https://shop.example https://www.shop.example"


@pytest.fixture(scope="module")
def embedded(make_site):
    settings = environment({"EMBED_ORIGINS": SHOPS, "FITTING_ROOM_LOCAL": "1"})
    names = ("EMBED_ORIGINS", "SESSION_COOKIE_SAMESITE", "SESSION_COOKIE_PARTITIONED")
    return make_site(SESSION_COOKIE_SECURE=True, **{name: settings[name] for name in names})


def test_only_the_shops_on_the_list_may_frame_it(embedded, client):
    answer = embedded.test_client().get("/")
    assert f"frame-ancestors 'self' {SHOPS}" in answer.headers["Content-Security-Policy"]
    assert "frame-ancestors 'none'" in client.get("/").headers["Content-Security-Policy"]


def test_the_cookie_travels_in_the_shops_own_jar(embedded):
    cookie = embedded.test_client().get("/numbers", base_url="https://localhost")
    parts = set(cookie.headers["Set-Cookie"].split("; "))
    assert {"Secure", "HttpOnly", "SameSite=None", "Partitioned"} <= parts


def test_without_shops_the_cookie_is_no_third_partys():
    settings = environment({})
    assert settings["SESSION_COOKIE_SAMESITE"] == "Lax"
    assert not settings["SESSION_COOKIE_PARTITIONED"]


def test_a_form_in_a_frame_still_needs_its_token(embedded):
    client = embedded.test_client()
    assert client.post("/numbers", data={"body": "male", "stature": "180"}).status_code == 400


def test_of_all_files_other_origins_may_load_one(embedded, client):
    policy = "Cross-Origin-Resource-Policy"
    shown = embedded.test_client()
    assert shown.get("/static/embed.js").headers[policy] == "cross-origin"
    assert shown.get("/static/embedded.js").headers[policy] == "same-origin"
    assert shown.get("/").headers[policy] == "same-origin"
    assert client.get("/static/embed.js").headers[policy] == "same-origin"


def test_pages_speak_to_shops_only_where_there_are_any(embedded, client):
    client.get("/")
    assert client.page.find(".//script[@data-origins]") is None
    shown = embedded.test_client()
    shown.get("/")
    assert shown.page.find(".//script[@data-origins]").get("data-origins") == SHOPS


def test_the_contract_is_that_of_the_scripts():
    page = (DOCS / "embedding.md").read_text()
    messages = [json.loads(text) for text in re.findall(r"^    (\{\".*\})$", page, re.MULTILINE)]
    static = DOCS.parent / "static"
    there, here = ((static / name).read_text() for name in ("embed.js", "embedded.js"))
    (greeting, *answers) = messages
    assert greeting == {"to": "fitting-room", "version": 1, "event": "hello"}
    assert '{ to: "fitting-room", version: 1, event: "hello" }' in there
    said = re.findall(r'return "(\w+)"', here)
    assert [answer["page"] for answer in answers] == sorted(said)
    assert {json.dumps(answer | {"page": ""}) for answer in answers} == {
        json.dumps({"from": "fitting-room", "version": 1, "event": "page", "page": ""})
    }
