"""Two servers behind Debian's nginx with the configuration of deploy/, and two processes of one."""

import os
import re
import signal
import socket
import threading
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import pytest

from bench.load import WOMAN
from bench.serving import Server, Shopper, ask, free_port, nginx, nginx_program
from fault_ways import TYPED, asked, entered

SLOTS = 12
"""Requests that a process lets reckon or wait: WORK_AT_ONCE and WORK_WAITING, of 16 threads."""

needs_nginx = pytest.mark.skipif(
    nginx_program() is None, reason="nginx is missing: scripts/require.sh nginx brings it"
)


@pytest.fixture(scope="module")
def replicas():
    """Two servers of one key; the first has two processes, and metrics."""
    both = {"SECRET_KEY": "one key for both of them", "TRUSTED_PROXIES": "1"}
    metrics = free_port()
    first = {**both, "METRICS_BIND": f"127.0.0.1:{metrics}", "WEB_CONCURRENCY": "2"}
    with Server(first) as one, Server({**both, "WEB_CONCURRENCY": "1"}) as other:
        one.metrics = metrics
        yield one, other


@pytest.fixture
def balanced(replicas):
    """The port of nginx, which takes them in turn."""
    with nginx(tuple(server.port for server in replicas)) as port:
        yield port


@needs_nginx
def test_a_wizards_steps_may_each_be_answered_by_another_server(balanced, replicas):
    shopper = Shopper(balanced)
    assert entered(shopper.measure("female", TYPED)) == list(TYPED.values())
    shown = asked(shopper.get("/avatar"))
    assert {name: float(value) for name, value in shown.items()} == {
        name: float(value) for name, value in TYPED.items()
    }
    addresses = {f"127.0.0.1:{server.port}" for server in replicas}
    for method in ("GET", "POST"):
        assert {by for how, by in shopper.answered_by if how == method} == addresses


# ---------------------------------------------------------------- who sends slowly


OUTLINES = (
    b"POST /api/v1/comparisons HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100000\r\n"
    b"Content-Type: multipart/form-data; boundary=part\r\n\r\n--part\r\n"
)
TEXT = (
    b"POST /api/v1/avatars HTTP/1.1\r\nHost: localhost\r\nContent-Length: 60000\r\n"
    b"Content-Type: text/plain\r\n\r\n"
)
"""Refused for its type, and heard out."""


@contextmanager
def slow_senders(port, count, begun=OUTLINES):
    """Some who send on byte by byte, and never come to an end."""
    senders = [socket.create_connection(("127.0.0.1", port)) for _ in range(count)]
    stop = threading.Event()

    def send():
        while not stop.wait(0.5):
            for sender in senders:
                sender.sendall(b"-")

    sending = threading.Thread(target=send)
    try:
        for sender in senders:
            sender.sendall(begun)
        sending.start()
        time.sleep(1)  # Until all are taken up: were one not, the test would only be kinder.
        yield
    finally:
        stop.set()
        sending.join()
        for sender in senders:
            sender.close()


@pytest.mark.parametrize("begun", [OUTLINES, TEXT], ids=["outlines", "text"])
def test_who_sends_slowly_takes_no_turn_from_others(replicas, begun):
    with slow_senders(replicas[1].port, SLOTS + 1, begun):
        assert ask(replicas[1].port, "POST", "/api/v1/avatars", WOMAN).status == 200


@needs_nginx
def test_behind_nginx_who_sends_slowly_takes_no_thread_either(balanced):
    with slow_senders(balanced, 100):
        for _ in range(4):
            assert ask(balanced, "GET", "/numbers").status == 200
            assert ask(balanced, "POST", "/api/v1/avatars", WOMAN).status == 200


# ---------------------------------------------------------------- who is asking


class ByHttps(Shopper):
    """One whose browser sends no referrer, and whom a proxy that speaks https lets through."""

    def _ask(self, method, path, content=None, headers=None):
        front = {"X-Forwarded-For": "203.0.113.9", "X-Forwarded-Proto": "https"}
        return super()._ask(method, path, content, {**front, **(headers or {})})


@needs_nginx
@pytest.mark.parametrize("hops", [1, 2])
def test_behind_a_proxy_as_many_are_believed_as_are_counted(hops):
    """One hop: nginx alone; two: a proxy before it too, for which this test stands."""
    settings = {
        "TRUSTED_PROXIES": str(hops),
        "RATELIMIT_ENABLED": "1",
        "RATELIMIT_DEFAULT": "3 per hour",
        "WEB_CONCURRENCY": "1",
    }
    with Server(settings) as server, nginx((server.port, server.port)) as port:
        # Where the site knows that it is asked by https it takes no form without a referrer.
        sent = ByHttps(port).enter(body="female", stature="168")
        assert sent.status == (303 if hops == 1 else 400)

        def status(senders):
            return ask(port, "GET", "/numbers", headers={"X-Forwarded-For": senders}).status

        made_up = ("198.51.100.7, 203.0.113.9", "192.0.2.1, 203.0.113.9", "203.0.113.9")
        assert [status(senders) for senders in made_up] == [200, 200, 429]
        assert status("198.51.100.7") == (429 if hops == 1 else 200)


# ---------------------------------------------------------------- both are full


@needs_nginx
def test_two_full_queues_turn_away_who_wants_a_body_and_nobody_else():
    small = {"WORK_AT_ONCE": "1", "WORK_WAITING": "0", "WEB_CONCURRENCY": "1"}
    bodies, pages = [], []

    def want(number):
        for _ in range(8):
            if number % 4:
                bodies.append(ask(port, "POST", "/api/v1/avatars", WOMAN))
            else:
                pages.append(ask(port, "GET", "/numbers").status)

    with (
        Server(small) as one,
        Server(small) as other,
        nginx((one.port, other.port)) as port,
        ThreadPoolExecutor(16) as shoppers,
    ):
        list(shoppers.map(want, range(16)))
    assert Counter(pages) == {200: 32}
    assert {answer.status for answer in bodies} == {200, 503}
    assert {answer.headers.get("Retry-After") for answer in bodies if answer.status == 503} == {"2"}


# ---------------------------------------------------------------- metrics of two processes


def metrics_of(server):
    """What the server tells: each sample's name and labels, and its value."""
    text = ask(server.metrics, "GET", "/metrics").body.decode()
    return {name: float(value) for name, value in re.findall(r"^(fitting\S+) (\S+)$", text, re.M)}


def pages(server):
    name = 'fitting_room_requests_total{endpoint="wizard.form",method="GET",status="200"}'
    return metrics_of(server).get(name, 0)


def living(server):
    resident = "fitting_room_worker_resident_bytes"
    told = [name for name in metrics_of(server) if name.startswith(resident)]
    return {int(re.search(r'pid="(\d+)"', name)[1]) for name in told}


def test_two_processes_tell_their_numbers_together(replicas):
    server = replicas[0]
    first, second = server.workers()
    before = pages(server)
    for worker, times in ((first, 2), (second, 3)):
        with server.alone(worker):
            for _ in range(times):
                assert ask(server.port, "GET", "/numbers").status == 200
    for worker in (first, second):
        with server.alone(worker):
            assert pages(server) == before + 5
    assert living(server) == {first, second}
    # What a process counted stays when it has ended; what it holds does not.
    os.kill(first, signal.SIGKILL)
    end = time.monotonic() + 60
    while first in living(server):
        assert time.monotonic() < end
        time.sleep(0.05)
    assert pages(server) == before + 5
