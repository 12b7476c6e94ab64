"""The queue before bodies and pictures: some wait, one more is told when to come again."""

import io
import json
import threading
import time

import pytest
from prometheus_client import REGISTRY

from bench.load import comparison
from webapp.overload import Gate, Overloaded

WOMAN = {"body": "female", "measurements": {"stature": 168}}


def test_who_comes_when_all_places_are_taken_is_told_when_to_come_again(make_site):
    site = make_site(WORK_AT_ONCE=1, WORK_WAITING=0)
    client = site.test_client()
    gate = site.extensions["gate"]
    turned_away = REGISTRY.get_sample_value("fitting_room_turned_away_total")
    gate.enter()
    asked = [("GET", path) for path in ("/avatar", "/avatar/sheet", "/avatar.csv")]
    asked += [("POST", "/api/v1/avatars")]
    for method, path in asked:
        answer = client.open(path, method=method, json=WOMAN if method == "POST" else None)
        assert answer.status_code == 503
        assert answer.headers["Retry-After"] == "2"
    assert answer.json["status"] == 503
    assert client.get("/").status_code == 200
    assert client.get("/healthz").status_code == 200
    assert client.get("/readyz").status_code == 503
    gate.leave()
    assert client.post("/api/v1/avatars", json=WOMAN).status_code == 200
    assert client.get("/readyz").status_code == 200
    assert REGISTRY.get_sample_value("fitting_room_turned_away_total") == turned_away + len(asked)


def test_a_request_that_fails_leaves_its_place(make_site):
    site = make_site(WORK_AT_ONCE=1, WORK_WAITING=0)
    client = site.test_client()
    for content in (b"no JSON", b'{"body": "female", "measurements": {}}', b"{}"):
        sent = client.post("/api/v1/avatars", data=content, content_type="application/json")
        assert sent.status_code in (400, 422)
    assert client.get("/avatar").status_code == 303
    assert client.post("/api/v1/avatars", json=WOMAN).status_code == 200


def test_some_wait_and_no_more_than_some():
    gate = Gate(at_once=1, waiting=1)
    gate.enter()
    through = threading.Event()
    second = threading.Thread(target=lambda: (gate.enter(), through.set(), gate.leave()))
    second.start()
    while not gate.is_full:
        time.sleep(0.001)
    with pytest.raises(Overloaded):
        gate.enter()
    assert not through.is_set()
    gate.leave()
    second.join()
    assert through.is_set()
    gate.enter()


@pytest.mark.parametrize(
    ("method", "path", "kind", "status"),
    [
        ("POST", "/api/v1/avatars", "application/json", 200),
        ("POST", "/api/v1/comparisons", "multipart/form-data; boundary=part", 415),
        ("POST", "/api/v1/avatars", "text/plain", 415),
        ("GET", "/avatar.glb", "text/plain", 404),
    ],
)
def test_what_is_sent_is_read_while_there_is_no_turn(make_site, method, path, kind, status):
    """Before it; or after it, where it is refused unread and heard out."""
    site = make_site(WORK_AT_ONCE=1, WORK_WAITING=0)
    gate, full = site.extensions["gate"], []

    class Slow(io.BytesIO):
        def read(self, size=-1):
            full.append(gate.is_full)
            return super().read(size)

    sent = comparison(b"no picture") if kind.startswith("multi") else json.dumps(WOMAN).encode()
    answer = site.test_client().open(
        path,
        method=method,
        input_stream=Slow(sent),
        content_length=len(sent),
        content_type=kind,
        environ_overrides={"wsgi.input_terminated": True},  # As gunicorn says.
    )
    assert answer.status_code == status
    assert set(full) == {False}


def test_nobody_waits_for_ever():
    gate = Gate(at_once=1, waiting=1, patience=0.01)
    gate.enter()
    with pytest.raises(Overloaded):
        gate.enter()
    gate.leave()
    gate.enter()
