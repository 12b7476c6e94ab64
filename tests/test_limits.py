"""Limits on requests against a real Redis server, which two processes of the real site share."""

import shutil
import signal
import subprocess
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor

import pytest
from redis import Redis, RedisError

from bench.serving import Server, ask, free_port

PROGRAM = shutil.which("redis-server")
LIMIT = 6

pytestmark = pytest.mark.skipif(
    PROGRAM is None, reason="redis-server is missing: scripts/require.sh redis brings it"
)


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """A Redis server that keeps nothing on disk: its process and a client of it."""
    port = free_port()
    keeping_nothing = [
        "--save",
        "",
        "--appendonly",
        "no",
        "--dir",
        tmp_path_factory.mktemp("redis"),
    ]
    with subprocess.Popen(
        [PROGRAM, "--bind", "127.0.0.1", "--port", str(port), *keeping_nothing],
        stdout=subprocess.DEVNULL,
    ) as process:
        client = Redis(port=port, socket_timeout=5)
        try:
            until(lambda: answers(client), "Redis does not start")
            yield process, client, port
        finally:
            process.send_signal(signal.SIGCONT)
            process.terminate()


@pytest.fixture(scope="module")
def site(store):
    """The site as it is deployed, with two processes and a limit that is soon reached."""
    settings = {
        "RATELIMIT_ENABLED": "1",
        "RATELIMIT_DEFAULT": f"{LIMIT} per hour",
        "RATELIMIT_STORAGE_URI": f"redis://127.0.0.1:{store[2]}/0",
        "WEB_CONCURRENCY": "2",
    }
    with Server(settings) as server:
        until(lambda: len(server.workers()) == 2, "the second process does not start")
        yield server


def answers(client):
    try:
        return client.ping()
    except RedisError:
        return False


def until(holds, words, seconds=60):
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end, words
        time.sleep(0.1)


def ask_often(site, times, at_once=1):
    """How many requests for a page were answered with which status."""
    with ThreadPoolExecutor(at_once) as pool:
        return Counter(pool.map(lambda _: ask(site.port, "GET", "/numbers").status, range(times)))


def test_two_processes_share_one_limit(site, store):
    store[1].flushall()
    one, other = site.workers()
    with site.alone(one):
        assert ask_often(site, LIMIT - 2) == {200: LIMIT - 2}
    with site.alone(other):
        assert ask_often(site, 4) == {200: 2, 429: 2}
        assert b'"limits":"ok"' in ask(site.port, "GET", "/readyz").body


def test_what_redis_keeps_names_nobody(site, store):
    ask_often(site, 1)
    (key,) = store[1].keys()
    assert b"127.0.0.1" not in key


def test_the_site_answers_while_redis_hangs_and_shares_again_afterwards(site, store):
    """Each process counts for itself then, and nobody is told of an error of ours."""
    process, client, _ = store
    client.flushall()
    process.send_signal(signal.SIGSTOP)
    many = ask_often(site, 4 * LIMIT, at_once=2 * LIMIT)
    assert set(many) <= {200, 429}
    assert many[200] >= LIMIT
    ready = ask(site.port, "GET", "/readyz")
    assert (ready.status, b"counts for itself" in ready.body) == (200, True)
    process.send_signal(signal.SIGCONT)
    client.flushall()
    # Both processes have had their fill: only a count that begins anew lets requests through.
    until(lambda: sum(ask_often(site, 1)[200] for _ in range(4)), "Redis is not used again")
    # On a slow machine a process's own limit may be over by then: what is asked now is counted.
    until(lambda: (ask_often(site, 1), client.keys())[1], "Redis is not counted in")


def test_the_site_answers_when_redis_dies(site, store):
    process, client, _ = store
    client.flushall()
    process.kill()
    process.wait()
    assert set(ask_often(site, 4 * LIMIT, at_once=2 * LIMIT)) <= {200, 429}
    assert ask(site.port, "GET", "/readyz").status == 200
