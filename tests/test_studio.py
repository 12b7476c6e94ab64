"""The one thread that draws: what breaks, hangs or waits in it, and who it draws for."""

import logging
import os
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace

import pytest

from model import studio
from model.rendering import render_png
from model.studio import RenderingTimedOut, RenderingUnavailable
from model.template_mesh import Body, load_template_mesh
from webapp import server

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def body():
    template = load_template_mesh()
    return Body(template, template.vertices, "female")


def resident():
    """Bytes of memory that this process holds."""
    statm = Path("/proc/self/statm")
    if not statm.exists():
        pytest.skip("this system does not tell how much memory a process holds")
    return int(statm.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_pictures_leave_no_memory_behind(body):
    """What is drawn with must be compiled once, not for every picture."""

    def grown_by(pictures):
        before = resident()
        for _ in range(pictures):
            render_png(body, "front", size=(150, 300))
        return resident() - before

    grown_by(10)
    assert grown_by(30) < 20e6  # Bytes; a program for each part of each picture would take 60.


def test_a_studio_that_broke_is_replaced(body):
    """As after a driver's failure: the next picture is the one that was drawn before."""

    def smash(opened):
        opened._renderer.delete()
        opened._renderer = None

    studio._in_studio(smash)
    first = render_png(body, "front", size=(150, 300))
    studio._in_studio(smash)
    assert render_png(body, "front", size=(150, 300)) == first


def test_drawing_that_always_fails_is_told_as_such():
    def fail(_):
        raise RuntimeError("no memory")

    with pytest.raises(RenderingUnavailable, match="failed twice: RuntimeError"):
        studio._in_studio(fail)
    assert "no memory" in studio.failure()
    studio._in_studio(lambda _: None)
    assert studio.failure() == ""


@pytest.fixture
def stuck():
    """Something hangs in the thread that draws, until this is set."""
    end = threading.Event()
    with pytest.raises(RenderingTimedOut, match=r"within 0\.1 seconds"):
        studio._in_studio(lambda _: end.wait(60), patience=0.1)
    while not studio.hangs():  # It is due this long after it began: a moment later than asked for.
        time.sleep(0.001)
    yield end
    end.set()
    while studio.hangs():
        time.sleep(0.001)


def test_what_hangs_is_not_waited_for(body, stuck):
    assert studio.hangs()
    assert studio.failure() != ""
    with pytest.raises(RenderingTimedOut, match="earlier picture"):
        render_png(body, "front", size=(60, 120))


def test_what_only_was_slow_is_forgiven(body, stuck):
    stuck.set()
    while studio.hangs():
        time.sleep(0.001)
    assert len(render_png(body, "front", size=(60, 120))) > 100
    assert studio.failure() == ""


def test_who_waits_for_too_long_behind_others_does_not_count_as_hanging():
    begun, end = threading.Event(), threading.Event()
    with ThreadPoolExecutor(1) as other:
        first = other.submit(studio._in_studio, lambda _: (begun.set(), end.wait(60)))
        begun.wait(60)
        with pytest.raises(RenderingTimedOut):
            studio._in_studio(lambda _: None, patience=0.1)
        assert not studio.hangs()
        end.set()
        first.result()
    assert studio.failure() == ""


def test_what_waited_for_long_and_has_just_begun_does_not_hang():
    there, first, begun, end = (threading.Event() for _ in range(4))
    worker = SimpleNamespace(alive=True, log=logging.getLogger("gunicorn.error"))
    with ThreadPoolExecutor(2) as others:
        before = others.submit(studio._in_studio, lambda _: (there.set(), first.wait(60)))
        assert there.wait(60)
        behind = others.submit(studio._in_studio, lambda _: (begun.set(), end.wait(60)), patience=4)
        time.sleep(3)
        first.set()
        before.result()
        assert begun.wait(60)
        with pytest.raises(RenderingTimedOut, match="within 4 seconds"):
            behind.result()
        server.post_request(worker, None, {}, None)
        assert worker.alive
        end.set()
    studio._in_studio(lambda _: None)
    assert studio.failure() == ""


def test_a_process_whose_drawing_hangs_is_let_go(stuck):
    worker = SimpleNamespace(alive=True, log=logging.getLogger("gunicorn.error"))
    server.post_request(worker, None, {}, None)
    assert not worker.alive


def test_a_process_that_draws_stays():
    worker = SimpleNamespace(alive=True, log=logging.getLogger("gunicorn.error"))
    server.post_request(worker, None, {}, None)
    server.worker_exit(None, worker)
    assert worker.alive


def test_all_is_drawn_in_one_thread():
    def drawing_thread(_):
        return studio._in_studio(lambda _: threading.current_thread().name)

    with ThreadPoolExecutor(4) as threads:
        assert len(set(threads.map(drawing_thread, range(8)))) == 1


def test_many_threads_get_the_pictures_that_one_gets(body):
    jobs = [(side, silhouette) for side in ("front", "profile") for silhouette in (True, False)]

    def draw(job):
        return render_png(body, job[0], silhouette=job[1], size=(150, 300))

    alone = [draw(job) for job in jobs]
    with ThreadPoolExecutor(8) as threads:
        together = list(threads.map(draw, jobs * 4))
    assert together == alone * 4


def run(code):
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


BODY = """
import os, sys
from model.rendering import render_png
from model.studio import RenderingUnavailable
from model.template_mesh import Body, load_template_mesh
template = load_template_mesh()
body = Body(template, template.vertices, "male")
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs a system that forks")
def test_a_forked_process_draws_even_if_its_parent_has_drawn():
    code = f"""{BODY}
first = render_png(body, "front", size=(150, 300))
child = os.fork()
if child == 0:
    os._exit(0 if render_png(body, "front", size=(150, 300)) == first else 1)
sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""
    result = run(code)
    assert result.returncode == 0, result.stderr
    assert result.stderr == ""


def test_importing_the_module_does_not_open_a_context():
    result = run("import model.rendering, sys; sys.exit('pyrender' in sys.modules)")
    assert result.returncode == 0, result.stderr


def test_no_system_of_windows_is_needed():
    """Where only OSMesa is installed, pyglet cannot be imported: it wants libGL and X."""
    code = f"""{BODY}
sys.modules["pyglet"] = None
render_png(body, "front", size=(150, 300))
"""
    result = run(code)
    assert result.returncode == 0, result.stderr


def test_nothing_is_written_to_the_disk(tmp_path):
    """Mesa would keep its compiled programs in a folder of the user's."""
    code = f"""{BODY}
os.environ["HOME"] = os.environ["XDG_CACHE_HOME"] = {str(tmp_path)!r}
render_png(body, "front", size=(150, 300))
"""
    result = run(code)
    assert result.returncode == 0, result.stderr
    assert not list(tmp_path.iterdir())


def test_a_machine_that_cannot_draw_says_why():
    code = f"""{BODY}
sys.modules["pyrender"] = None
for attempt in range(2):
    try:
        render_png(body, "front")
    except RenderingUnavailable as error:
        assert "libosmesa6" in str(error) and "pyrender" in str(error), error
    else:
        sys.exit("it drew")
"""
    result = run(code)
    assert result.returncode == 0, result.stderr


def test_unavailable_is_a_runtime_error():
    assert issubclass(RenderingUnavailable, RuntimeError)
