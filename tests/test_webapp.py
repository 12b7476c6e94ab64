"""The site as a whole: settings, headers, limits, error pages, static files."""

import io
import re

import pytest
from conftest import SETTINGS, text
from flask import abort
from gunicorn.config import Config
from gunicorn.http import errors as gunicorn_errors
from gunicorn.http.parser import RequestParser

from webapp import create_app
from webapp.settings import check_key, environment


def test_a_site_without_a_secret_key_refuses_to_start():
    with pytest.raises(RuntimeError, match="SECRET_KEY"):
        create_app({"SECRET_KEY": ""})


@pytest.mark.parametrize("key", ["secret", "Change-Me!", "change_me_12345678901", "fourteen chars"])
def test_a_deployed_site_refuses_a_key_that_is_no_secret(key):
    with pytest.raises(RuntimeError, match="SECRET_KEY"):
        create_app({"SECRET_KEY": key, "FITTING_ROOM_LOCAL": False})
    check_key(key, local=True)
    check_key("9b1f0c6a5d7e8f42", local=False)


def test_a_former_key_is_still_read(make_site):
    old = make_site(SECRET_KEY="the key of last year").test_client()
    old.send(body="male", stature="180")
    cookie = old.get_cookie("__Host-fitting_room").value
    for former, status in ((["the key of last year"], 200), ([], 404)):
        new = make_site(SECRET_KEY="the key of this year", SECRET_KEY_FALLBACKS=former)
        client = new.test_client()
        client.set_cookie("__Host-fitting_room", cookie)
        assert client.get("/avatar.glb").status_code == status


def test_a_deployed_site_takes_its_key_from_the_environment_and_has_no_other():
    assert environment({})["SECRET_KEY"] == ""
    deployed = environment({"SECRET_KEY": "long and random"})
    assert deployed["SECRET_KEY"] == "long and random"
    assert deployed["SESSION_COOKIE_SECURE"]
    assert deployed["SESSION_COOKIE_HTTPONLY"]
    assert deployed["SESSION_COOKIE_SAMESITE"] == "Lax"


def test_a_local_site_makes_up_a_key_and_needs_no_https():
    local, another = (environment({"FITTING_ROOM_LOCAL": "1"}) for _ in range(2))
    assert local["SECRET_KEY"] != another["SECRET_KEY"]
    assert not local["SESSION_COOKIE_SECURE"]


@pytest.mark.parametrize(
    ("variable", "enabled"), [("0", False), ("false", False), ("1", True), ("True", True)]
)
def test_request_limits_can_be_switched_off(variable, enabled):
    assert environment({"RATELIMIT_ENABLED": variable})["RATELIMIT_ENABLED"] is enabled
    assert environment({})["RATELIMIT_ENABLED"]


def test_request_limits_can_be_kept_elsewhere():
    settings = environment(
        {"RATELIMIT_STORAGE_URI": "redis://limits", "RATELIMIT_DEFAULT": "9/day"}
    )
    assert settings["RATELIMIT_STORAGE_URI"] == "redis://limits"
    assert settings["RATELIMIT_DEFAULT"] == "9/day"


def test_the_cookie_is_as_safe_as_the_settings_say(make_site):
    deployed = make_site(SESSION_COOKIE_SECURE=True).test_client()
    cookie = deployed.get("/", base_url="https://localhost").headers["Set-Cookie"]
    assert {"Secure", "HttpOnly", "SameSite=Lax"} <= set(cookie.split("; "))


def test_a_form_over_https_works_with_the_referrer_that_our_policy_sends(make_site):
    client = make_site(SESSION_COOKIE_SECURE=True).test_client()
    token = client.token(base_url="https://localhost")
    fields = {"csrf_token": token, "body": "male", "stature": "180"}
    sent = client.post(
        "/", data=fields, base_url="https://localhost", headers={"Referer": "https://localhost/"}
    )
    assert sent.status_code == 303
    assert sent.headers["Referrer-Policy"] == "same-origin"


def test_addresses_behind_a_proxy_are_the_shoppers(make_site):
    site = make_site(TRUSTED_PROXIES=1, RATELIMIT_ENABLED=True, RATELIMIT_DEFAULT="1 per hour")
    client = site.test_client()
    for address in ("192.0.2.1", "192.0.2.2"):
        assert client.get("/", headers={"X-Forwarded-For": address}).status_code == 200
    assert client.get("/", headers={"X-Forwarded-For": "192.0.2.1"}).status_code == 429
    assert "One moment, please" in text(client.page)


@pytest.mark.parametrize("path", ["/", "/avatar", "/nothing", "/healthz", "/api/v1/nothing"])
def test_every_answer_has_the_security_headers(client, path):
    headers = client.get(path).headers
    policy = headers["Content-Security-Policy"]
    assert "unsafe" not in policy
    for rule in (
        "script-src 'self'",
        "connect-src 'self'",
        "object-src 'none'",
        "base-uri 'none'",
        "frame-ancestors 'none'",
    ):
        assert rule in policy.split("; ")
    assert headers["Strict-Transport-Security"] == "max-age=31536000"
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert headers["Cross-Origin-Opener-Policy"] == "same-origin"
    assert "camera=()" in headers["Permissions-Policy"]


def test_pages_hold_no_inline_script_or_style(client):
    client.send(body="female", stature="168")
    for path in ("/", "/avatar", "/nothing"):
        client.get(path)
        for element in client.page.iter():
            assert element.tag != "style"
            assert not [name for name in element.attrib if name == "style" or name.startswith("on")]
            # A block of data is not run.
            if element.tag == "script" and element.get("type") != "application/json":
                assert element.get("src")
                assert not text(element)


def test_what_is_not_there_is_told_on_a_page(client):
    assert client.get("/nothing").status_code == 404
    assert text(client.page.find(".//h1")) == "There is nothing here"


@pytest.mark.parametrize("host", ["..", "a" * 70 + ".example"])
@pytest.mark.parametrize("path", ["/", "/avatar", "/static/nothing", "/api/v1/measurements"])
def test_a_host_that_can_be_none_is_a_bad_request(client, host, path):
    assert client.get(path, headers={"Host": host}).status_code == 400


def test_a_wrong_method_is_told_on_a_page(client):
    response = client.post("/avatar")
    assert response.status_code == 405
    assert "GET" in response.headers["Allow"]


def test_too_large_a_form_is_told_on_a_page(client):
    response = client.post("/", data={"stature": "1" * 100_000})
    assert response.status_code == 413
    assert text(client.page.find(".//h1")) == "That was too much"


def test_a_refused_request_is_heard_out(client):
    content = io.BytesIO(b" " * 1_000_000)
    response = client.post(
        "/api/v1/avatars",
        input_stream=content,
        content_type="text/plain",
        environ_overrides={"wsgi.input_terminated": True},
    )
    assert response.status_code == 415
    assert content.read() == b""


class Broken(io.BytesIO):
    """A request's body that turns out to be malformed, told as servers tell it."""

    def __init__(self, start, error):
        super().__init__(start)
        self.error = error

    def read(self, size=-1):
        if content := super().read(size):
            return content
        raise self.error


@pytest.mark.parametrize(
    "error",
    [
        gunicorn_errors.ChunkMissingTerminator(b"fgh"),
        gunicorn_errors.InvalidChunkSize(b"zz"),
        gunicorn_errors.NoMoreData(b""),
        gunicorn_errors.InvalidHeader("trailer"),
        ConnectionResetError(),
        TimeoutError(),
    ],
    ids=lambda error: type(error).__name__,
)
@pytest.mark.parametrize("start", [b"", b"{}", b"stature=168&body=male&"])
@pytest.mark.parametrize(
    ("path", "content_type"),
    [
        ("/", "application/x-www-form-urlencoded"),
        ("/", "multipart/form-data; boundary=a"),
        ("/forget", "application/x-www-form-urlencoded"),
        ("/api/v1/avatars", "application/json"),
        ("/api/v1/avatars.glb", "application/json"),
    ],
)
def test_a_body_that_cannot_be_read_is_a_bad_request(client, path, content_type, start, error):
    response = client.post(
        path,
        input_stream=Broken(start, error),
        content_type=content_type,
        environ_overrides={"wsgi.input_terminated": True},
    )
    assert response.status_code == 400
    if path.startswith("/api/"):
        assert response.mimetype == "application/problem+json"
        assert response.json["status"] == 400


@pytest.mark.parametrize(
    ("path", "content_type", "status"),
    [("/api/v1/avatars", "text/plain", 415), ("/nothing", "text/plain", 404)],
)
def test_a_refused_body_that_cannot_be_read_is_heard_to_where_it_breaks(
    client, path, content_type, status
):
    response = client.post(
        path,
        input_stream=Broken(b" " * 100_000, gunicorn_errors.ChunkMissingTerminator(b"fgh")),
        content_type=content_type,
        environ_overrides={"wsgi.input_terminated": True},
    )
    assert response.status_code == status


@pytest.mark.parametrize(
    ("path", "content_type"),
    [("/", "application/x-www-form-urlencoded"), ("/api/v1/avatars", "application/json")],
)
@pytest.mark.parametrize(
    "chunks",
    [b"zz\r\n", b"5\r\nabcdefgh\r\n", b"2\r\n{}\r\n0\r\na trailer\r\n\r\n", b"9\r\n{}", b""],
)
def test_malformed_chunks_are_a_bad_request_with_the_server_that_we_run(
    client, path, content_type, chunks
):
    head = f"POST {path} HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n"
    received = next(RequestParser(Config(), [head.encode() + chunks], ("127.0.0.1", 1)))
    response = client.post(
        path,
        content_type=content_type,
        environ_overrides={"wsgi.input": received.body, "wsgi.input_terminated": True},
    )
    assert response.status_code == 400


def test_our_own_failure_is_told_without_its_cause(make_site, monkeypatch):
    site = make_site(TESTING=False)
    site.add_url_rule("/broken", "page", lambda: abort(500, "a secret"))
    site.add_url_rule("/api/v1/broken", "call", lambda: 1 / 0)
    monkeypatch.setattr(site.logger, "disabled", True)
    client = site.test_client()
    page = client.get("/broken")
    assert page.status_code == 500
    assert "a secret" not in page.text
    problem = client.get("/api/v1/broken")
    assert problem.status_code == problem.json["status"] == 500
    assert "division" not in problem.text


def test_static_files_are_kept_for_a_year_by_their_fingerprint(client):
    page = client.get("/").text
    style = re.search(r'"(/static/css/site.css\?v=[0-9a-f]{12})"', page)[1]
    kept = client.get(style).headers["Cache-Control"]
    assert "max-age=31536000" in kept
    assert "immutable" in kept
    assert "no-cache" not in kept
    assert "no-cache" in client.get("/static/css/site.css").headers["Cache-Control"]


@pytest.mark.parametrize(
    "path", ["/static/css/site.css?v=000000000000", "/static/build/nothing-ABCDEFGH.js"]
)
def test_what_another_version_has_is_not_kept_under_its_name(client, path):
    """A page of a new version may ask a server of the old one while it is brought out."""
    answer = client.get(path)
    assert "immutable" not in answer.headers["Cache-Control"]
    assert "max-age" not in answer.headers["Cache-Control"]


def test_settings_go_before_the_environment(make_site):
    assert make_site().config["SECRET_KEY"] == SETTINGS["SECRET_KEY"]


def test_webassembly_and_the_camera_are_for_the_photos_alone(client):
    everywhere = client.get("/").headers
    worker = client.get("/static/build/photos/worker.js").headers
    assert "wasm" not in everywhere["Content-Security-Policy"]
    assert "camera=()" in everywhere["Permissions-Policy"]
    assert "script-src 'self' 'wasm-unsafe-eval';" in worker["Content-Security-Policy"]
    assert "camera=(self)" in worker["Permissions-Policy"]
    for headers in (everywhere, worker):
        assert "connect-src 'self';" in headers["Content-Security-Policy"]
        assert "'unsafe-" not in headers["Content-Security-Policy"]
