"""The real server, as the Procfile has it, started on this machine and asked over loopback."""

import http.client
import json
import os
import re
import secrets
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Self
from urllib.parse import urlencode

ROOT = Path(__file__).resolve().parent.parent
PATIENCE = 120.0
"""Seconds until a server must have started, on a machine that does other things besides."""

SITE = "webapp:create_app()"
FORM = "application/x-www-form-urlencoded"


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

    @contextmanager
    def alone(self, worker: int) -> Iterator[None]:
        """One process answers; the others sleep."""
        others = [other for other in self.workers() if other != worker]
        try:
            for other in others:
                os.kill(other, signal.SIGSTOP)
            yield
        finally:
            for other in others:
                os.kill(other, signal.SIGCONT)

    def memory(self) -> list[Memory]:
        """What each process that answers holds."""
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
    """A browser of sorts, which keeps a cookie and sends a form with its token.

    answered_by : each request's method, and the server that answered it, where `nginx` told.
    """

    port: int
    cookie: str = field(default="", repr=False)
    answered_by: list[tuple[str, str]] = field(default_factory=list, repr=False)

    def get(self, path: str) -> Answer:
        """A page, asked for with the cookie."""
        return self._ask("GET", path)

    def send(self, path: str, **fields: str) -> Answer:
        """Ask for a page, and fill in its form."""
        return self.fill_in(self.get(path), path, **fields)

    def fill_in(self, page: Answer, path: str, **fields: str) -> Answer:
        """Fill in the form of a page that is there, and send it.

        Raises
        ------
        ValueError
            Where it has none.
        """
        token = re.search(rb'name="csrf_token" value="([^"]+)"', page.body)
        if token is None:
            raise ValueError(f"the form of {path} has no token: {page.status}")
        content = urlencode({"csrf_token": token[1].decode(), "units": "metric", **fields}).encode()
        return self._ask("POST", path, content, {"Content-Type": FORM})

    def enter(self, **fields: str) -> Answer:
        """Fill in the form of all numbers."""
        return self.send("/numbers", **fields)

    def measure(self, body: str, values: Mapping[str, str]) -> Answer:
        """Go through the wizard page by page, and skip what has no value: its last page.

        Raises
        ------
        ValueError
            Where a page does not lead on.
        """
        here, sent = "/", self.send("/", body=body)
        while sent.status == 303 and (there := sent.headers["Location"]) != here:
            here, page = there, self.get(there)
            if not here.startswith("/measure/"):
                return page
            name = here.removeprefix("/measure/")
            sent = self.send(here, **({name: values[name]} if name in values else {"skip": "1"}))
        raise ValueError(f"{here} does not lead on: {sent.status}")

    def _ask(
        self,
        method: str,
        path: str,
        content: bytes | None = None,
        headers: Mapping[str, str] | None = None,
    ) -> Answer:
        own = {"Cookie": self.cookie} if self.cookie else {}
        answer = ask(self.port, method, path, content, {**own, **(headers or {})})
        if "Set-Cookie" in answer.headers:
            self.cookie = answer.headers["Set-Cookie"].split(";")[0]
        self.answered_by.append((method, answer.headers.get(ANSWERED_BY, "")))
        return answer


# ---- two servers behind nginx -------------------------------------------------------------------

ANSWERED_BY = "X-Answered-By"
"""The header in which `nginx` tells which server answered."""

NGINX = (
    "daemon off; pid {folder}/pid; error_log {folder}/error.log; events {{}} http {{ "
    "access_log off; client_body_temp_path {folder}/a; proxy_temp_path {folder}/b; "
    "fastcgi_temp_path {folder}/c; uwsgi_temp_path {folder}/d; scgi_temp_path {folder}/e; "
    "add_header {header} $upstream_addr always; {ours} }}"
)


def nginx_program() -> str | None:
    """Where nginx is; Debian keeps it where only root looks."""
    return shutil.which("nginx", path=f"{os.environ['PATH']}:/usr/sbin")


def nginx_configuration(folder: Path, port: int, ports: tuple[int, int]) -> Path:
    """The configuration of deploy/, told where to listen and where two servers are, as a file."""
    ours = (ROOT / "deploy" / "nginx.conf").read_text().replace("listen 80;", f"listen {port};")
    for name, server in zip(("web1:8000", "web2:8000"), ports, strict=True):
        ours = ours.replace(name, f"127.0.0.1:{server}")
    folder.chmod(0o777)  # Its own user writes here.
    file = folder / "nginx.conf"
    file.write_text(NGINX.format(folder=folder, header=ANSWERED_BY, ours=ours))
    return file


@contextmanager
def nginx(ports: tuple[int, int]) -> Iterator[int]:
    """Debian's nginx with the configuration of deploy/, on some port, before these servers.

    Raises
    ------
    RuntimeError
        Where it is missing, or does not start.
    """
    program = nginx_program()
    if program is None:
        raise RuntimeError("nginx is missing: scripts/require.sh nginx brings it")
    port = free_port()
    with tempfile.TemporaryDirectory() as folder:
        file = nginx_configuration(Path(folder), port, ports)
        with subprocess.Popen(  # noqa: S603 - our own command
            [program, "-c", str(file)], stderr=subprocess.DEVNULL
        ) as process:
            try:
                _until_listening(port, process)
                yield port
            finally:
                process.terminate()


def _until_listening(port: int, process: subprocess.Popen[bytes]) -> None:
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end and process.poll() is None:
        try:
            if ask(port, "GET", "/healthz").status == 200:
                return
        except OSError:
            time.sleep(0.05)
    raise RuntimeError("nginx did not start")
