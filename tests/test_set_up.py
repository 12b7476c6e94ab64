"""The set-up finds what the machine provides, and names what is missing."""

import os
import re
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
    ("thing", "package"),
    [
        ("python", "python3"),
        ("node", "nodejs"),
        ("chromium", "chromium"),
        ("redis", "redis-server"),
    ],
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


@pytest.mark.parametrize("name", ["chromium", "chromium-browser", "google-chrome"])
def test_a_browser_of_the_family_is_taken(bare, name):
    put(bare, name, "exit 0")
    assert require(bare, "chromium").returncode == 0


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


# ---------------------------------------------------------------- installing


def put_installer(bare, package, command):
    """Put an apt-get that notes how it was called and, installing the package, brings a command."""
    for name in ("chmod", "true"):
        (bare / name).symlink_to(shutil.which(name))
    put(
        bare,
        "apt-get",
        f'echo "$@" >>"{bare}/apt.log"\n'
        f'case "$*" in *install*{package}*)\n'
        f'    echo "#!{shutil.which("sh")}" >"{bare}/{command}"; chmod +x "{bare}/{command}";;\n'
        "esac",
    )


@pytest.mark.parametrize("user", ["root", "sudo"])
def test_what_is_missing_is_installed_where_that_is_allowed(bare, user):
    put_installer(bare, "chromium", "chromium")
    (bare / "id").unlink()
    put(bare, "id", "echo 0" if user == "root" else "echo 1000")
    put(bare, "sudo", 'shift; exec "$@"')
    answer = require(bare, "chromium", NO_INSTALL="")
    assert answer.returncode == 0
    assert "Installing system packages: chromium" in answer.stderr
    assert "--no-install-recommends chromium" in (bare / "apt.log").read_text()


def test_nothing_is_installed_that_is_there(bare):
    put_installer(bare, "chromium", "chromium")
    put(bare, "chromium", "exit 0")
    assert require(bare, "chromium", NO_INSTALL="").returncode == 0
    assert not (bare / "apt.log").exists()


def test_nothing_is_installed_where_sudo_would_ask(bare):
    put_installer(bare, "chromium", "chromium")
    (bare / "id").unlink()
    put(bare, "id", "echo 1000")
    put(bare, "sudo", "exit 1")
    answer = require(bare, "chromium", NO_INSTALL="")
    assert answer.returncode == 1
    assert "Install the package chromium" in answer.stderr
    assert not (bare / "apt.log").exists()


def test_an_installation_that_fails_names_the_package(bare):
    put(bare, "apt-get", "exit 100")
    (bare / "id").unlink()
    put(bare, "id", "echo 0")
    answer = require(bare, "chromium", NO_INSTALL="")
    assert answer.returncode == 1
    assert "Install the package chromium" in answer.stderr


# ---------------------------------------------------------------- the commands


def test_make_alone_lists_every_command():
    makefile = (ROOT / "Makefile").read_text()
    targets = set(re.search(r"^\.PHONY: (.*)$", makefile, re.MULTILINE)[1].split()) - {"help"}
    answer = subprocess.run(["make"], cwd=ROOT, capture_output=True, text=True, check=True)
    assert set(re.findall(r"^  make ([\w-]+) ", answer.stdout, re.MULTILINE)) == targets


def test_the_server_is_the_one_of_the_procfile():
    procfile = (ROOT / "Procfile").read_text()
    assert procfile == "web: gunicorn --config webapp/server.py 'webapp:create_app()'\n"
    assert "Procfile" in (ROOT / "Makefile").read_text()


def test_continuous_integration_runs_the_command_of_the_readme():
    script = ROOT / ".ci" / "run"
    assert os.access(script, os.X_OK)
    assert script.read_text().rstrip().endswith("exec make test </dev/null")
    assert "make test" in (ROOT / "README.md").read_text()
