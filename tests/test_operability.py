"""What those who run a site see of it: its health, its logs, its metrics, and what it is told."""

import io
import json
import logging
import re
import threading
import time
from pathlib import Path

import pytest
from itsdangerous import TimestampSigner
from prometheus_client import REGISTRY
from werkzeug.test import Client

from model import studio
from model.studio import RenderingTimedOut
from webapp import health, logs, metrics, server
from webapp.settings import VARIABLES, environment

ROOT = Path(__file__).resolve().parent.parent
WOMAN = {"body": "female", "measurements": {"stature": 168.4321, "bust_girth": 92.8765}}


# ---------------------------------------------------------------- what it is told


class Recording(dict):
    """An environment that remembers what it was asked for."""

    def __init__(self):
        super().__init__()
        self.asked = set()

    def get(self, name, default=None):
        self.asked.add(name)
        return default

    __getitem__ = get


def test_the_table_of_variables_is_that_of_the_code_and_of_the_page():
    asked = Recording()
    environment(asked)
    server.settings(asked)
    # Read by NumPy, before anything of ours.
    assert asked.asked | {"OPENBLAS_NUM_THREADS"} == {variable.name for variable in VARIABLES}
    page = (ROOT / "docs" / "hosting.md").read_text()
    rows = re.findall(r"^\| `(\w+)` \| (.*?) \| (.*) \|$", page, re.MULTILINE)
    assert rows == [
        (variable.name, f"`{variable.default}`" if variable.default else "", variable.meaning)
        for variable in VARIABLES
    ]


def test_the_server_is_told_the_defaults_of_the_table():
    defaults = {variable.name: variable.default for variable in VARIABLES}
    assert server.settings({}) == server.settings(defaults)
    assert environment({"SECRET_KEY": "x"}) == environment(defaults | {"SECRET_KEY": "x"})


def test_nothing_else_reads_the_environment():
    readers = [
        file.name
        for file in (ROOT / "webapp").glob("*.py")
        if re.search(r"os\.environ|getenv", file.read_text())
    ]
    assert sorted(readers) == ["__init__.py", "metrics.py", "server.py"]


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("TRUSTED_PROXIES", "-1"),
        ("WORK_AT_ONCE", "many"),
        ("EMBED_ORIGINS", "https://shop.example/path"),
        ("EMBED_ORIGINS", "*"),
        ("EMBED_ORIGINS", "shop.example; script-src *"),
    ],
)
def test_a_setting_that_cannot_be_is_named(name, value):
    with pytest.raises(ValueError, match=name):
        environment({name: value})


# ---------------------------------------------------------------- health


def test_a_server_that_can_serve_is_ready(client):
    answer = client.get("/readyz")
    assert answer.status_code == 200
    assert answer.json["status"] == "ready"
    assert answer.json["checks"]["estimators"] == "ok"
    assert answer.json["checks"]["limits"] == "off"


def test_readiness_tells_of_the_last_picture(client, no_pyrender, monkeypatch):
    assert client.get("/readyz").json["checks"]["pictures"] == "missing"
    assert client.get("/readyz").status_code == 200
    no_pyrender.undo()
    monkeypatch.setattr(health, "TRY_AGAIN", 3600)
    assert client.get("/readyz").json["checks"]["pictures"] == "missing", "tried too soon"
    monkeypatch.setattr(health, "TRY_AGAIN", 0)
    assert client.get("/readyz").json["checks"]["pictures"] == "ok"


def test_a_picture_that_hangs_is_a_503_that_says_when_to_come_again(make_site):
    client = make_site().test_client()
    end = threading.Event()
    with pytest.raises(RenderingTimedOut):
        studio._in_studio(lambda _: end.wait(60), patience=0.1)
    while not studio.hangs():
        time.sleep(0.001)
    try:
        answer = client.post("/api/v1/avatars/front.png", json=WOMAN)
        assert (answer.status_code, answer.headers["Retry-After"]) == (503, "2")
        assert client.get("/readyz").json["checks"]["pictures"] == "missing"
        assert client.post("/api/v1/avatars", json=WOMAN).status_code == 200
    finally:
        end.set()
    while studio.hangs():
        time.sleep(0.001)
    assert client.get("/readyz").json["checks"]["pictures"] == "ok"


def test_a_server_whose_store_of_limits_is_gone_still_serves_and_says_so(make_site):
    site = make_site(
        RATELIMIT_ENABLED=True,
        RATELIMIT_STORAGE_URI="redis://127.0.0.1:1/0",
        RATELIMIT_DEFAULT="2 per hour",
    )
    client = site.test_client()
    assert [client.get("/").status_code for _ in range(3)] == [200, 200, 429]
    answer = client.get("/readyz")
    assert answer.status_code == 200
    assert answer.json["checks"]["limits"] == "each process counts for itself"


# ---------------------------------------------------------------- logs


@pytest.fixture
def lines():
    """What the site logs, line by line."""
    stream = io.StringIO()
    handler = logging.StreamHandler(stream)
    handler.setFormatter(logs.JsonLines())
    root, ours = logging.getLogger(), logs.LOG
    root.addHandler(handler)
    ours.setLevel(logging.INFO)
    yield lambda: [json.loads(line) for line in stream.getvalue().splitlines()]
    root.removeHandler(handler)


def test_an_answer_is_one_line_with_nothing_of_a_shopper(client, lines):
    client.send(body="female", stature="168.4321", waist_girth="74.1234")
    client.get("/avatar.glb?stature=168.4321", headers={"User-Agent": "a name"})
    client.post("/api/v1/avatars", json=WOMAN)
    client.get("/168.4321")
    logged = lines()
    assert [(line["method"], line["route"], line["status"]) for line in logged[-3:]] == [
        ("GET", "/avatar.glb", 200),
        ("POST", "/api/v1/avatars", 200),
        ("GET", None, 404),
    ]
    assert set(logged[-1]) == {
        *("time", "level", "logger", "message", "request"),
        *("method", "route", "status", "ms", "bytes"),
    }
    # The clock's digits may be anybody's.
    everything = json.dumps(
        [{**line, "time": "", "ms": 0, "bytes": 0, "request": ""} for line in logged]
    )
    for private in ("168.4", "92.8", "74.1", "127.0.0.1", "a name", "?"):
        assert private not in everything


def test_a_failure_is_logged_with_its_place_and_without_its_words(make_site, lines):
    site = make_site(TESTING=False)

    def fail():
        try:
            int("168.4321")
        except ValueError as error:
            raise RuntimeError("stature of 168.4321") from error

    site.add_url_rule("/broken", "broken", fail)
    assert site.test_client().get("/broken").status_code == 500
    failed, answered = lines()
    assert failed["level"] == answered["level"] == "error"
    assert failed["request"] == answered["request"]
    assert failed["error"][-1] == "RuntimeError"
    assert "ValueError" in failed["error"]
    assert any("test_operability.py" in place and "fail" in place for place in failed["error"])
    assert "168.4321" not in json.dumps([failed, answered])


@pytest.mark.parametrize(
    "words",
    [
        "Error handling request /avatar?stature=168.4",
        "Invalid request from ip=203.0.113.9: stature",
        "Invalid request from ip=2001:db8::9: stature",
    ],
)
def test_what_the_server_says_of_requests_loses_addresses_and_queries(words, lines):
    logging.getLogger("gunicorn.error").warning("%s", words)
    message = lines()[0]["message"]
    for private in ("168.4", "203.0.113", "db8"):
        assert private not in message


# ---------------------------------------------------------------- metrics


def sample(name, **labels):
    return REGISTRY.get_sample_value(f"fitting_room_{name}", labels) or 0


def test_requests_and_fits_are_counted(client):
    labels = {"endpoint": "api.avatar", "method": "POST", "status": "200"}
    requests, fits = (
        sample("requests_total", **labels),
        sample("fit_residual_metres_count", body="female"),
    )
    below = sample("fit_residual_metres_bucket", body="female", le="0.001")
    client.post("/api/v1/avatars", json=WOMAN)
    client.post("/api/v1/avatars", json=WOMAN | {"fit": "linear"})
    assert sample("requests_total", **labels) == requests + 2
    assert sample("fit_residual_metres_count", body="female") == fits + 1
    assert sample("fit_residual_metres_bucket", body="female", le="0.001") == below + 1


def test_labels_are_none_that_a_client_can_multiply(client):
    for path in ("/a", "/b"):
        client.open(path, method="ODD")
    names = {
        (one.labels["endpoint"], one.labels["method"])
        for metric in REGISTRY.collect()
        if metric.name == "fitting_room_requests"
        for one in metric.samples
    }
    assert ("none", "other") in names
    assert not [name for name in names if {"/a", "/b", "ODD"} & set(name)]


def test_metrics_are_on_their_own_address_only(make_site):
    client = Client(make_site(METRICS_BIND="127.0.0.1:9100").wsgi_app)
    public = {"SERVER_PORT": "8000", "HTTP_HOST": "localhost:9100"}
    own = {"SERVER_PORT": "9100"}
    assert client.get("/metrics", environ_overrides=public).status_code == 404
    answer = client.get("/metrics", environ_overrides=own)
    assert "fitting_room_request_seconds_bucket" in answer.text
    assert client.get("/healthz", environ_overrides=own).status_code == 404
    with pytest.raises(ValueError, match="METRICS_BIND"):
        metrics.beside(lambda environ, start_response: [], "9100")


def test_the_folder_of_the_metrics_is_made_once_by_a_server(monkeypatch, tmp_path):
    monkeypatch.setattr(server, "MEMORY", tmp_path)
    monkeypatch.setenv("PROMETHEUS_MULTIPROC_DIR", "of the server before")
    monkeypatch.setenv(server.OWNER, "1")
    server.share_metrics()
    server.share_metrics()
    (made,) = tmp_path.iterdir()
    assert server.os.environ["PROMETHEUS_MULTIPROC_DIR"] == str(made)
    server.on_exit(None)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_of_metrics_that_the_host_made_stays(monkeypatch, tmp_path):
    monkeypatch.setenv("PROMETHEUS_MULTIPROC_DIR", str(tmp_path))
    monkeypatch.delenv(server.OWNER, raising=False)
    server.on_exit(None)
    assert tmp_path.is_dir()


# ---------------------------------------------------------------- clocks


@pytest.mark.parametrize("hours", [-1, 1])
def test_a_jump_of_the_clock_is_nothing_where_no_limit_is(client, monkeypatch, hours):
    client.get("/")
    now = time.time
    monkeypatch.setattr(time, "time", lambda: now() + hours * 3600)
    assert client.get("/").status_code == 200


@pytest.mark.parametrize("hours", [-1, 1])
def test_a_jump_of_the_clock_turns_nobody_away_for_longer(make_site, monkeypatch, hours):
    client = make_site(RATELIMIT_ENABLED=True, RATELIMIT_DEFAULT="2 per minute").test_client()
    assert [client.get("/").status_code for _ in range(3)] == [200, 200, 429]
    now = time.time
    monkeypatch.setattr(time, "time", lambda: now() + hours * 3600)
    assert [client.get("/").status_code for _ in range(3)] == [200, 200, 429]


@pytest.mark.parametrize(
    ("hours", "kept"),
    [(-24 * 20, True), (-1, True), (1, True), (24 * 365, True), (-24 * 40, False)],
)
def test_what_was_typed_outlives_a_jump_of_the_clock(site, hours, kept):
    """A cookie that was signed by a server whose clock is fast or slow by some hours."""

    class Elsewhere(TimestampSigner):
        def get_timestamp(self):
            return super().get_timestamp() + hours * 3600

    with site.test_request_context():
        serializer = site.session_interface.get_signing_serializer(site)
        serializer.signer = Elsewhere
        cookie = serializer.dumps({"typed": {"body": "male", "units": "metric", "stature": "180"}})
    client = site.test_client()
    client.set_cookie("__Host-fitting_room", cookie)
    client.get("/")
    assert (client.page.find(".//form[@action='/forget']") is not None) == kept
    client.set_cookie("__Host-fitting_room", cookie[:-1])
    client.get("/")
    assert client.page.find(".//form[@action='/forget']") is None
