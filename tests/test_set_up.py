"""The set-up finds what the machine provides, and names what is missing."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture
def bare(tmp_path):
    """A machine with a shell and nothing else: a folder that stands for PATH."""
    for name in ("bash", "env", "id", "sed"):
        (tmp_path / name).symlink_to(shutil.which(name))
    return tmp_path


def require(path, *arguments, **environment):
    """Run the set-up for one thing with this PATH, never installing anything."""
    return subprocess.run(
        [ROOT / "scripts" / "require.sh", *arguments],
        env={"PATH": str(path), "NO_INSTALL": "1", **environment},
        capture_output=True,
        text=True,
        check=False,
        stdin=subprocess.DEVNULL,
    )


def put(folder, name, text):
    """Put a command into a folder."""
    (folder / name).write_text(f"#!{shutil.which('sh')}\n{text}\n")
    (folder / name).chmod(0o755)


@pytest.mark.parametrize(
    ("thing", "package"), [("python", "python3"), ("node", "nodejs"), ("chromium", "chromium")]
)
def test_what_is_missing_is_named_with_its_package(bare, thing, package):
    answer = require(bare, thing)
    assert answer.returncode == 1
    assert answer.stdout == ""
    assert answer.stderr.startswith("error: ")
    assert package in answer.stderr
    assert "nstall" in answer.stderr


def test_a_missing_osmesa_is_named_with_its_package(bare):
    put(bare, "python3", 'case "$2" in *OSMesa*) exit 1;; esac')
    answer = require(bare, "osmesa")
    assert answer.returncode == 1
    assert "libosmesa6" in answer.stderr


def test_a_python_without_venv_is_named_with_its_package(bare):
    put(bare, "python3", 'case "$2" in *ensurepip*) exit 1;; *print*) echo python3.11-venv;; esac')
    answer = require(bare, "venv", str(bare / "new"))
    assert answer.returncode == 1
    assert "apt-get install python3.11-venv" in answer.stderr
    assert not (bare / "new").exists()


def test_an_old_python_is_passed_over(bare):
    put(bare, "python3", "exit 1")
    answer = require(bare, "python")
    assert answer.returncode == 1
    assert "3.11 or newer" in answer.stderr


def test_a_new_enough_python_is_found(bare):
    (bare / "python3.11").symlink_to(sys.executable)
    answer = require(bare, "python")
    assert answer.returncode == 0
    assert Path(answer.stdout.strip()).exists()


def test_an_old_node_is_refused_with_its_version(bare):
    put(bare, "node", 'case "$1" in --version) echo v18.20.4;; *) echo 18;; esac')
    put(bare, "npm", "exit 0")
    answer = require(bare, "node")
    assert answer.returncode == 1
    assert "found: v18.20.4" in answer.stderr


def test_a_new_enough_node_is_taken(bare):
    put(bare, "node", "echo 20")
    put(bare, "npm", "exit 0")
    assert require(bare, "node").returncode == 0


def test_a_browser_may_be_anywhere(bare):
    put(bare, "chrome", "exit 0")
    assert require(bare, "chromium", CHROMIUM=str(bare / "chrome")).returncode == 0


def test_a_working_environment_is_left_alone(tmp_path):
    environment = Path(sys.executable).parent.parent
    before = (environment / "pyvenv.cfg").stat().st_mtime_ns
    answer = require(os.environ["PATH"], "venv", str(environment))
    assert answer.returncode == 0
    assert (environment / "pyvenv.cfg").stat().st_mtime_ns == before


def test_an_unknown_request_is_answered_with_the_usage(bare):
    answer = require(bare, "wings")
    assert answer.returncode == 2
    assert "usage:" in answer.stderr
