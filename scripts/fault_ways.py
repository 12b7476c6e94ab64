"""The ways in which servers break: each breaks a real one, and tells what shoppers saw of it.

Two servers behind nginx need the Debian package nginx-light, a clock that jumps libfaketime, a full
disk the right to mount.
"""

import http.client
import itertools
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from bench.load import WOMAN, comparison, outline
from bench.serving import Answer, Server, Shopper, ask, nginx
from model.checksums import FILES
from model.template_mesh import DATA


def expect(holds: bool, words: str) -> None:
    """Stop where something is not as it should be."""
    if not holds:
        raise SystemExit(f"NOT AS IT SHOULD BE: {words}")


class NotTried(Exception):
    """A fault that cannot be made here, and why."""


@contextmanager
def shoppers(port: int, count: int = 4) -> Iterator[Counter[str]]:
    """Some who ask for pages and bodies all the while; what they were answered."""
    answers: Counter[str] = Counter()
    stop = threading.Event()

    def one(number: int) -> None:
        while not stop.is_set():
            number += 1
            try:
                if number % 2:
                    status = ask(port, "GET", "/numbers").status
                else:
                    status = ask(port, "POST", "/api/v1/avatars", WOMAN).status
                answers[str(status)] += 1
            except (OSError, http.client.HTTPException) as error:
                answers[type(error).__name__] += 1

    threads = [threading.Thread(target=one, args=(number,)) for number in range(count)]
    for thread in threads:
        thread.start()
    try:
        yield answers
    finally:
        stop.set()
        for thread in threads:
            thread.join()


def until(holds: Callable[[], bool], words: str, seconds: float = 120) -> float:
    """Wait for something; how long it took."""
    start = time.monotonic()
    while not holds():
        expect(time.monotonic() - start < seconds, f"{words}, after {seconds:.0f} s")
        time.sleep(0.05)
    return time.monotonic() - start


def killed_worker() -> str:
    """A process is killed in the middle of its requests."""
    with Server() as server:
        before = server.workers()
        with shoppers(server.port) as answers:
            until(lambda: answers["200"] >= 8, "no answers")
            os.kill(before[0], signal.SIGKILL)
            took = until(
                lambda: len(set(server.workers()) - {before[0]}) == len(before), "no new process"
            )
            reached = answers["200"]
            until(lambda: answers["200"] >= reached + 8, "no answers afterwards")
        lost = sum(answers.values()) - answers["200"]
        expect(lost <= 4, f"{dict(answers)}")
        return (
            f"{lost} of {sum(answers.values())} requests, which it was answering, were cut off;"
            f" a new process was forked after {took:.1f} s, and 8 more requests were answered"
        )


def graceful_restart() -> str:
    """The server is told to begin anew (HUP) while shoppers come and go, twice."""
    with Server() as server:
        with shoppers(server.port) as answers:
            for _ in range(2):
                until(lambda: answers["200"] >= 4, "no answers")
                before = set(server.workers())
                server.signal(signal.SIGHUP)
                _replaced(server, before)
        failed = sum(answers.values()) - answers["200"]
        expect(failed == 0, f"{dict(answers)}")
        return f"all processes replaced twice: {answers['200']} requests, {failed} failed"


def _replaced(server: Server, before: set[int]) -> None:
    until(lambda: not before & set(server.workers()), "old processes stay")


@contextmanager
def full_folder() -> Iterator[Path]:
    """A file system without a byte left.

    Raises
    ------
    NotTried
        Where none may be mounted.
    """
    with tempfile.TemporaryDirectory() as name:
        mount = ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", name]
        mounted = subprocess.run(mount, capture_output=True, text=True, check=False)
        if mounted.returncode != 0:
            raise NotTried(f"a full disk cannot be mounted here: {mounted.stderr.strip()}")
        try:
            with suppress(OSError), (Path(name) / "filler").open("wb", buffering=0) as filler:
                while True:
                    filler.write(bytes(4096))
            yield Path(name)
        finally:
            subprocess.run(["umount", name], check=False)


def full_disk() -> str:
    """No file can be written: a limit of no bytes, and a full folder for what is temporary."""
    with full_folder() as folder:
        settings = {"TMPDIR": str(folder), "WEB_CONCURRENCY": "1"}
        with Server(settings, command="ulimit -f 0; ") as server:
            parts = comparison(outline(server.port))
            kind = {"Content-Type": "multipart/form-data; boundary=part"}
            statuses = [
                ask(server.port, "GET", "/numbers").status,
                ask(server.port, "POST", "/api/v1/avatars.glb", WOMAN).status,
                ask(server.port, "POST", "/api/v1/avatars/front.png", WOMAN).status,
                ask(server.port, "POST", "/api/v1/comparisons", parts, kind).status,
            ]
    expect(statuses == [200] * 4, f"{statuses}")
    return "page, file, picture and comparison were answered as ever: nothing is written to disk"


HIDDEN = """
import ctypes.util
found = ctypes.util.find_library
ctypes.util.find_library = lambda name: None if name == "OSMesa" else found(name)
load = ctypes.CDLL.__init__
def refuse(self, name, *rest, **more):
    if "OSMesa" in str(name):
        raise OSError("libOSMesa is hidden")
    load(self, name, *rest, **more)
ctypes.CDLL.__init__ = refuse
"""
"""Read by Python before all else: OSMesa is neither found nor loaded."""


def no_osmesa() -> str:
    """The library that draws is not there."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "sitecustomize.py").write_text(HIDDEN)
        with Server({"PYTHONPATH": folder, "WEB_CONCURRENCY": "1"}) as server:
            shopper = Shopper(server.port)
            shopper.enter(body="female", stature="168")
            page = shopper.get("/avatar")
            picture = ask(server.port, "POST", "/api/v1/avatars/front.png", WOMAN)
            file = ask(server.port, "POST", "/api/v1/avatars.glb", WOMAN)
            ready = ask(server.port, "GET", "/readyz")
    expect((page.status, file.status, ready.status) == (200, 200, 200), "the site does not work")
    expect(b"cannot draw pictures" in page.body, "the page does not say why")
    expect(picture.status == 503 and b"OSMesa" in picture.body, f"{picture}")
    return (
        "page, numbers and file work; the page says that no pictures are drawn, the API why (503)"
    )


HANGING = """
import os, time
os.environ["PYOPENGL_PLATFORM"] = "osmesa"
import pyrender
draw = pyrender.Renderer.render
def hang(*rest, **more):
    while os.path.exists(os.environ["HANGING"]):
        time.sleep(1e9)
    return draw(*rest, **more)
pyrender.Renderer.render = hang
"""
"""Read by Python before all else: drawing hangs while the file is there that HANGING names."""


def hanging_picture() -> str:
    """The driver never comes back from a picture."""
    with tempfile.TemporaryDirectory() as folder:
        sign = Path(folder) / "hanging"
        (Path(folder) / "sitecustomize.py").write_text(HANGING)
        with Server({"PYTHONPATH": folder, "HANGING": str(sign)}) as server:
            # The first may answer before the second is forked.
            until(lambda: len(server.workers()) == 2, "the second process does not start")
            before = set(server.workers())
            sign.touch()
            with shoppers(server.port, 2) as answers:
                start = time.monotonic()
                late = ask(server.port, "POST", "/api/v1/avatars/front.png", WOMAN)
                waited = time.monotonic() - start
                sign.unlink()
                ended = until(lambda: not before <= set(server.workers()), "it stays")
                until(lambda: len(server.workers()) == len(before), "no new process")
                drawn = ask(server.port, "POST", "/api/v1/avatars/front.png", WOMAN)
        failed = sum(answers.values()) - answers["200"]
    expect(late.status == 503 and "Retry-After" in late.headers, f"{late}")
    expect(drawn.status == 200, f"{drawn}")
    expect(failed == 0, f"{dict(answers)}")
    return (
        f"503 with `Retry-After` after {waited:.0f} s; that process ended {ended:.1f} s later and "
        f"another one drew; meanwhile {answers['200']} other requests, {failed} failed"
    )


def damaged_files() -> str:
    """Each file of the estimators is missing, cut off, or has a byte changed."""
    tried = 0
    with tempfile.TemporaryDirectory() as folder:
        for name in FILES:
            for harm in ("missing", "cut off", "with a changed byte"):
                data = Path(folder) / "data"
                shutil.rmtree(data, ignore_errors=True)
                shutil.copytree(DATA, data)
                file = data / name
                middle = file.stat().st_size // 2
                if harm == "missing":
                    file.unlink()
                elif harm == "cut off":
                    os.truncate(file, middle)
                else:
                    with file.open("r+b") as content:
                        content.seek(middle)
                        byte = content.read(1)[0]
                        content.seek(middle)
                        content.write(bytes([byte ^ 1]))
                code, words = Server({"FITTING_ROOM_DATA": str(data)}).refusal()
                expect(code != 0, f"it starts with {name} {harm}")
                expect(name in words, f"{name} {harm} is not named: {words[-600:]}")
                tried += 1
    return f"{tried} ways: the server refused to start each time and named the file"


FAKETIME = "usr/lib/*/faketime/libfaketimeMT.so.1"
"""Where Debian's libfaketime lies, from the root on."""

LIMIT = 12
"""Requests that the strict server allows."""

HOUR = 3600
"""Seconds."""

SLEEP = """
import select, time
time.sleep = lambda seconds: select.select([], [], [], seconds)
"""
"""Libfaketime 0.9.10 refuses the call with which Python 3.11 sleeps."""


def clock_jump() -> str:
    """The clock is set an hour forward and back, beneath a server that is at work."""
    found = sorted(Path("/").glob(FAKETIME))
    if not found:
        raise NotTried("libfaketime is missing: scripts/require.sh faketime brings it")
    with tempfile.TemporaryDirectory() as folder:
        ahead = Path(folder) / "ahead"
        ahead.write_text("+0")
        (Path(folder) / "sitecustomize.py").write_text(SLEEP)
        clock = {
            "PYTHONPATH": folder,
            "LD_PRELOAD": str(found[0]),
            "FAKETIME_TIMESTAMP_FILE": str(ahead),
            "FAKETIME_CACHE_DURATION": "1",
            # As where a clock is set: what only goes forward still does, and so do files' times.
            "FAKETIME_DONT_FAKE_MONOTONIC": "1",
            "NO_FAKE_STAT": "1",
        }
        busy = {"WORK_AT_ONCE": "1", "WORK_WAITING": "16"}
        limit = {"RATELIMIT_ENABLED": "1", "RATELIMIT_DEFAULT": f"{LIMIT} per 10 minutes"}
        limit |= {"WEB_CONCURRENCY": "1"}
        with Server({**clock, **busy}) as server, Server({**clock, **limit}) as strict:
            workers = [*server.workers(), *strict.workers()]
            requests = 0
            for hour in (HOUR, -HOUR):
                ahead.write_text("+0")
                requests += _jump(server, strict.port, partial(ahead.write_text, f"{hour:+d}"))
            expect([*server.workers(), *strict.workers()] == workers, "a process was ended")
    return (
        "an hour forward, an hour back: what was typed is kept, a form that was open is taken, "
        f"{requests} requests that waited for their turn were answered, none failed; limits are "
        "counted anew; no process is ended"
    )


def _jump(server: Server, strict: int, jump: Callable[[], object]) -> int:
    """Sets the clock; how many requests were answered about that time."""
    shopper = Shopper(server.port)
    expect(shopper.enter(body="female", stature="168").status == 303, "the form")
    open_form = shopper.get("/numbers")
    while ask(strict, "GET", "/numbers").status == 200:
        pass
    with shoppers(server.port, 6) as answers:
        until(lambda: answers["200"] >= 6, "no answers")
        jump()
        reached = answers["200"]
        until(lambda: answers["200"] >= reached + 12, "no answers afterwards")
    expect(sum(answers.values()) == answers["200"], f"{dict(answers)}")
    expect(shopper.fill_in(open_form, "/numbers", body="female", stature="169").status == 303, "it")
    shown = asked(shopper.get("/avatar"))
    expect(shown == {"stature": "169.0"}, f"{shown}")
    until(lambda: ask(strict, "GET", "/numbers").status == 200, "the limit stays", 30)
    return answers["200"]


TYPED = {"stature": "168", "weight": "64", "bust_girth": "92", "waist_girth": "74"}
"""What a shopper types in the wizard, in centimetres and kilograms; they skip the rest."""


def two_replicas() -> str:
    """A wizard's steps on two servers behind nginx in turn; then one is stopped under load."""
    key = {"SECRET_KEY": "one key for both of them", "TRUSTED_PROXIES": "1", "WEB_CONCURRENCY": "1"}
    with Server(key) as one, Server(key) as other, nginx((one.port, other.port)) as port:
        shopper = Shopper(port)
        reviewed = shopper.measure("female", TYPED)
        shown = shopper.get("/avatar")
        expect(entered(reviewed) == list(TYPED.values()), f"the review: {entered(reviewed)}")
        body = {name: f"{float(value):g}" for name, value in asked(shown).items()}
        expect(body == TYPED, f"the body's page: {body}")
        turns = list(shopper.answered_by)
        for method in ("GET", "POST"):
            servers = {server for asked_by, server in turns if asked_by == method}
            expect(len(servers) == 2, f"each {method} was answered by {servers}")
        with shoppers(port) as answers:
            until(lambda: answers["200"] >= 6, "no answers")
            one.signal(signal.SIGTERM)
            until(lambda: one.process is not None and one.process.poll() is not None, "it stays")
            reached = answers["200"]
            until(lambda: answers["200"] >= reached + 6, "no answers afterwards")
        failed = sum(answers.values()) - answers["200"]
        expect(failed == 0, f"{dict(answers)}")
        changes = sum(a != b for (_, a), (_, b) in itertools.pairwise(turns))
        return (
            f"a wizard of {len(turns)} requests went {changes} times from one server to the other, "
            "and review and body have what was typed; then one was stopped under load: "
            f"{answers['200']} requests, {failed} failed"
        )


def entered(review: Answer) -> list[str]:
    """The values on the wizard's last page."""
    return re.findall(r'class="entered-value">([^<]*?)\s*<', review.body.decode())


def asked(avatar: Answer) -> dict[str, str]:
    """The entered values on the body's page, by measurement."""
    table = avatar.body.decode().partition('id="numbers"')[2].partition("</table>")[0]
    return dict(re.findall(r'<tr data-measurement="(\w+)">.*?<td>([^<]*)</td>', table, re.DOTALL))


FAULTS = {
    "a process is killed in mid-request": killed_worker,
    "the server begins anew under load": graceful_restart,
    "the disk is full": full_disk,
    "OSMesa is missing": no_osmesa,
    "a picture hangs in the driver": hanging_picture,
    "an estimator's file is missing or damaged": damaged_files,
    "the clock jumps": clock_jump,
    "two servers behind nginx": two_replicas,
}
