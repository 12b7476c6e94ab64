"""The real server, as the Procfile has it, started on this machine and asked over loopback."""

import http.client
import json
import os
import re
import secrets
import shlex
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Self

ROOT = Path(__file__).resolve().parent.parent
PATIENCE = 120.0
"""Seconds until a server must have started, on a machine that does other things besides."""

SITE = "webapp:create_app()"


def free_port() -> int:
    """A port that nobody listens on."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port: int = one.getsockname()[1]
        return port


@dataclass(frozen=True, slots=True)
class Memory:
    """Bytes that a process holds, as Linux counts them (proc(5), ``smaps_rollup``).

    resident : all of them (Rss)
    shared : those of them that another process holds too (Shared_Clean and Shared_Dirty)
    proportional : where each page counts in equal parts for all that hold it (Pss)
    """

    resident: int
    shared: int
    proportional: int


def memory_of(process: int) -> Memory:
    """What a process holds."""
    text = Path(f"/proc/{process}/smaps_rollup").read_text()
    held = {name: 1024 * int(size) for name, size in re.findall(r"^(\w+): +(\d+) kB", text, re.M)}
    return Memory(held["Rss"], held["Shared_Clean"] + held["Shared_Dirty"], held["Pss"])


class Server:
    """Gunicorn with our configuration: starts when it is entered, and stops when it is left.

    Parameters
    ----------
    settings : of the environment, beside those of a server on one's own machine without limits.
    application : what it serves, as gunicorn takes it.
    command : what stands before gunicorn's, such as a limit on what it may write.
    """

    def __init__(
        self, settings: Mapping[str, str] | None = None, application: str = SITE, command: str = ""
    ) -> None:
        self.port = free_port()
        self.environment = {
            **os.environ,
            "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
            "HOST": "127.0.0.1",
            "PORT": str(self.port),
            "FITTING_ROOM_LOCAL": "1",
            "RATELIMIT_ENABLED": "0",
            "SECRET_KEY": secrets.token_hex(32),
            "PYTHONUNBUFFERED": "1",
            **(settings or {}),
        }
        gunicorn = ["gunicorn", "--config", "webapp/server.py", application]
        self.command = command + "exec " + shlex.join(gunicorn)
        self.process: subprocess.Popen[str] | None = None

    def start(self) -> subprocess.Popen[str]:
        """Start it, and do not wait."""
        self.process = subprocess.Popen(  # noqa: S603 - our own command
            ["/bin/sh", "-c", self.command],
            cwd=ROOT,
            env=self.environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        return self.process

    def refusal(self) -> tuple[int, str]:
        """Start it, and wait until it gives up: its exit code and its words."""
        done = subprocess.run(  # noqa: S603 - our own command
            ["/bin/sh", "-c", self.command],
            cwd=ROOT,
            env=self.environment,
            capture_output=True,
            text=True,
            check=False,
            timeout=PATIENCE,
        )
        return done.returncode, done.stdout + done.stderr

    def __enter__(self) -> Self:
        process = self.start()
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end and process.poll() is None:
            try:
                if ask(self.port, "GET", "/healthz").status == 200:
                    return self
            except OSError:
                time.sleep(0.2)
        process.kill()
        raise RuntimeError(f"the server did not start: {self.refusal()[1][-2000:]}")

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self.process is not None and self.process.poll() is None:
            self.process.terminate()
            self.process.wait(timeout=PATIENCE)

    def workers(self) -> list[int]:
        """The processes that answer."""
        children = Path(f"/proc/{self._running.pid}/task/{self._running.pid}/children")
        return [int(number) for number in children.read_text().split()]

    def memory(self) -> list[Memory]:
        """What each of them holds."""
        return [memory_of(worker) for worker in self.workers()]

    def signal(self, number: signal.Signals) -> None:
        """Tell it to stop, or to begin anew."""
        self._running.send_signal(number)

    @property
    def _running(self) -> subprocess.Popen[str]:
        if self.process is None:
            raise RuntimeError("the server was not started")
        return self.process


@dataclass(frozen=True, slots=True)
class Answer:
    """What came back."""

    status: int
    headers: Mapping[str, str]
    body: bytes


def ask(
    port: int,
    method: str,
    path: str,
    content: bytes | Mapping[str, object] | None = None,
    headers: Mapping[str, str] | None = None,
) -> Answer:
    """One request on a connection of its own; content that is no bytes goes as JSON.

    Raises
    ------
    OSError, http.client.HTTPException
        Where no whole answer came.
    """
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE)
    try:
        return ask_on(connection, method, path, content, headers)
    finally:
        connection.close()


def ask_on(
    connection: http.client.HTTPConnection,
    method: str,
    path: str,
    content: bytes | Mapping[str, object] | None = None,
    headers: Mapping[str, str] | None = None,
) -> Answer:
    """One request on a connection that may be kept."""
    sent = dict(headers or {})
    if content is not None and not isinstance(content, bytes):
        content = json.dumps(content).encode()
        sent["Content-Type"] = "application/json"
    connection.request(method, path, content, sent)
    response = connection.getresponse()
    body = response.read()
    return Answer(response.status, dict(response.getheaders()), body)


@dataclass
class Shopper:
    """A browser of sorts, which keeps a cookie and sends a form with its token."""

    port: int
    cookie: str = field(default="", repr=False)

    def get(self, path: str) -> Answer:
        return self._keep(ask(self.port, "GET", path, headers=self._headers()))

    def enter(self, **fields: str) -> Answer:
        """Fill in the form of all numbers."""
        page = self.get("/numbers")
        token = re.search(rb'name="csrf_token" value="([^"]+)"', page.body)
        if token is None:
            raise ValueError(f"the form has no token: {page.status}")
        pairs = {"csrf_token": token[1].decode(), "units": "metric", **fields}
        content = "&".join(f"{name}={value}" for name, value in pairs.items()).encode()
        kind = {"Content-Type": "application/x-www-form-urlencoded"}
        return self._keep(ask(self.port, "POST", "/numbers", content, self._headers() | kind))

    def _headers(self) -> dict[str, str]:
        return {"Cookie": self.cookie} if self.cookie else {}

    def _keep(self, answer: Answer) -> Answer:
        if "Set-Cookie" in answer.headers:
            self.cookie = answer.headers["Set-Cookie"].split(";")[0]
        return answer
