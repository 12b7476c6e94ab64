"""The headers of answers, of every address that the site knows: see docs/asvs.md."""

import re
from pathlib import Path

import gunicorn
import pytest
from conftest import WOMAN
from werkzeug.test import Client

STATIC = Path(__file__).resolve().parent.parent / "static"

EXAMPLES = {"name": "waist_girth", "side": "front", "filename": "css/site.css"}
"""A value for each part of an address that has many."""

DOCUMENT = {"body": "female", "measurements": {"stature": 168}}


def addresses(site, method):
    """Every address that answers a method, with an example for what varies in it."""
    adapter = site.url_map.bind("localhost")
    return {
        rule.endpoint: adapter.build(
            rule.endpoint, {part: EXAMPLES[part] for part in rule.arguments}
        )
        for rule in site.url_map.iter_rules()
        if method in (rule.methods or ())
    }


@pytest.fixture
def answers(shopper, site):
    """What every address answers to someone who has entered measurements, by endpoint."""
    token = shopper.token()
    given = {name: shopper.get(path) for name, path in addresses(site, "GET").items()}
    for name, path in addresses(site, "POST").items():
        form = {} if name.startswith("api.") else {"data": WOMAN | {"csrf_token": token}}
        given[f"POST {name}"] = shopper.post(path, **(form or {"json": DOCUMENT}))
        given[f"refused {name}"] = shopper.post(path, data=b"?", content_type="text/plain")
    return given | {"404": shopper.get("/nothing"), "API's 404": shopper.get("/api/v1/nothing")}


def test_browsers_keep_nothing_but_the_sites_own_files(answers):
    assert {"wizard.form", "wizard.step", "wizard.review", "avatars.page"} <= answers.keys()
    assert answers["wizard.form"].status_code == answers["avatars.page"].status_code == 200
    assert WOMAN["waist_girth"] in answers["wizard.step"].text
    for name, answer in answers.items():
        assert answer.cache_control.no_store == (name != "static"), name


def test_every_answer_says_what_it_is_and_in_which_letters(answers, client):
    nowhere = client.get("/", headers={"Host": ".."})
    assert nowhere.mimetype == "text/plain"
    drawing = client.get("/static/favicon.svg")
    for name, answer in {**answers, "no host": nowhere, "drawing": drawing}.items():
        assert answer.mimetype, name
        if answer.mimetype.startswith("text/") or answer.mimetype.endswith("+xml"):
            assert answer.mimetype_params["charset"] == "utf-8", name
        assert answer.headers["X-Content-Type-Options"] == "nosniff", name


def test_no_answer_tells_a_version_of_the_server(answers):
    for name, answer in answers.items():
        for header in ("Server", "X-Powered-By", "Via"):
            assert not re.search(r"\d", answer.headers.get(header, "")), name
    # Gunicorn adds its own where it serves: a name, and no number.
    assert re.fullmatch(r"[a-z]+", gunicorn.SERVER)


def test_no_other_origin_may_read_an_answer(site):
    client = Client(site)
    for origin in ("https://shop.example", "null"):
        for path in ("/", "/api/v1/measurements", "/api/v1/avatars"):
            for ask in (client.get, client.options, client.post):
                headers = ask(path, headers={"Origin": origin}).headers
                names = [name for name, _ in headers]
                assert names and not [name for name in names if name.startswith("Access-Control")]


def test_what_the_api_answers_is_saved_and_not_opened(answers):
    of_api = {name: answer for name, answer in answers.items() if "api." in name or "API" in name}
    assert {answer.status_code for answer in of_api.values()} >= {200, 404, 415}
    for name, answer in of_api.items():
        how, _, called = answer.headers["Content-Disposition"].partition("; ")
        assert how == "attachment", name
        assert called in ('filename="api.json"', 'filename="api.png"', "filename=avatar.glb"), name
    assert "Content-Disposition" not in answers["wizard.start"].headers


def test_a_deployed_sites_cookie_belongs_to_its_host_alone(make_site):
    client = make_site(SESSION_COOKIE_SECURE=True).test_client()
    cookie = client.get("/", base_url="https://localhost").headers["Set-Cookie"]
    first, *rest = cookie.split("; ")
    assert first.startswith("__Host-fitting_room=")
    assert {"Secure", "Path=/"} <= set(rest)
    assert "Domain" not in cookie


def test_what_lies_among_the_files_is_meant_to_be_served():
    kinds = {file.suffix for file in STATIC.rglob("*") if file.is_file()}
    assert kinds <= {".css", ".js", ".json", ".svg", ".webp", ".wasm", ".task", ".txt", ""}
