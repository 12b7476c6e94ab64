"""What containers, hosts and nginx are told, held to one another and to the site."""

import fnmatch
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from bench.serving import free_port, nginx_configuration, nginx_program
from webapp.settings import VARIABLES

ROOT = Path(__file__).resolve().parent.parent
KNOWN = {variable.name for variable in VARIABLES}
NOT_OURS = {"PATH", "PYTHONDONTWRITEBYTECODE", "PYTHONUNBUFFERED"}
"""Variables of Python and of the shell, which the Dockerfile sets too."""


def instructions():
    """The Dockerfile's: stage by stage, the name of each and its rest."""
    text = re.sub(r"^#.*\n", "", (ROOT / "Dockerfile").read_text(), flags=re.MULTILINE)
    lines = re.sub(r"\\\n\s*", "", text).splitlines()
    stages = []
    for line in filter(None, lines):
        name, _, rest = line.partition(" ")
        if name == "FROM":
            stages.append([])
        stages[-1].append((name, rest))
    return stages


def told(name):
    """What stands behind an instruction, in all stages."""
    return [rest for stage in instructions() for own, rest in stage if own == name]


COMPOSE = yaml.safe_load((ROOT / "compose.yaml").read_text())
SERVICES = COMPOSE["services"]


def given(path):
    """Whether the context of the build has a path: what .dockerignore leaves out is not there."""
    allowed = False
    for pattern in (ROOT / ".dockerignore").read_text().split():
        own = pattern.removeprefix("!")
        if own == "*" or fnmatch.fnmatch(path, own) or path.startswith(f"{own}/"):
            allowed = pattern.startswith("!")
    return allowed and (ROOT / path).exists()


def test_what_is_copied_is_there():
    copied = [rest.split() for rest in told("COPY")]
    assert len(copied) > 5
    for *sources, _ in copied:
        if not sources[0].startswith("--from="):
            for source in sources:
                assert given(source), source


def test_the_front_end_is_built_by_a_program_that_is_installed():
    """Each kind of machine has a package of its own for esbuild's program, optional in the lock;
    .npmrc keeps it from being fetched by a script of the package.
    """
    packages = json.loads((ROOT / "package-lock.json").read_text())["packages"]
    assert packages["node_modules/@esbuild/linux-x64"]["optional"]
    assert "ignore-scripts=true" in (ROOT / ".npmrc").read_text().split()
    front, *_ = instructions()
    assert [rest for name, rest in front if name == "RUN"] == [
        "npm ci --no-audit --no-fund",
        "npm run --silent build",
    ]


def test_stages_that_are_copied_from_are_there():
    names = {rest.partition(" AS ")[2] for rest in told("FROM")} - {""}
    used = set(re.findall(r"--from=(\S+)", "\n".join(told("COPY"))))
    assert used == names == {"front", "packages"}


def test_all_that_the_site_imports_and_shows_is_in_the_container():
    *_, runs = instructions()
    there = {rest.split()[-1] for name, rest in runs if name == "COPY"}
    assert there >= {"model", "webapp", "templates", "static", "/venv"}


ALONE = """
import sys

class OnlyTraining:
    def find_spec(self, name, path=None, target=None):
        if name in ("pygeodesic", "model.training"):
            raise ModuleNotFoundError(name)

sys.meta_path.insert(0, OnlyTraining())
import webapp
shopper = webapp.create_app().test_client()
body = {"body": "female", "measurements": {"stature": 168}}
print([shopper.post(f"/api/v1/avatars{end}", json=body).status_code for end in ("", ".glb")])
"""
"""A site that is asked for a body, where what only training needs is not installed."""


def test_the_container_has_what_the_site_needs_and_nothing_of_training(tmp_path):
    for name in ("webapp", "templates", "static"):
        (tmp_path / name).symlink_to(ROOT / name)
    files = [path.relative_to(ROOT) for path in (ROOT / "model").rglob("*") if path.is_file()]
    copied = [path for path in files if given(str(path))]
    for path in copied:
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).symlink_to(ROOT / path)
    assert not [path for path in copied if path.parts[1] == "training"]
    answer = subprocess.run(
        [sys.executable, "-c", ALONE],
        cwd=tmp_path,
        env={**os.environ, "FITTING_ROOM_LOCAL": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert answer.stdout == "[200, 200]\n", answer.stderr


def test_every_package_comes_as_a_wheel():
    """None is compiled where it is installed: that would want a compiler, and run its set-up."""
    (install,) = [rest for rest in told("RUN") if "-r requirements.txt" in rest]
    assert "--only-binary :all:" in install
    assert "--require-hashes" in install


def test_the_container_runs_what_the_procfile_runs():
    (web,) = (ROOT / "Procfile").read_text().splitlines()
    (command,) = told("CMD")[-1:]
    assert json.loads(command) == shlex.split(web.removeprefix("web: "))


def test_its_health_is_asked_where_the_site_tells_it(client):
    (check,) = told("HEALTHCHECK")
    path = re.search(r"127\.0\.0\.1:\{.*?\}(/\w+)", check)[1]
    assert client.get(path).status_code == 200
    program = json.loads(check.partition("CMD ")[2])
    compile(program[2], "HEALTHCHECK", "exec")
    assert set(re.findall(r'environ\.get\("(\w+)"\)', program[2])) <= KNOWN
    (port,) = told("EXPOSE")
    assert port == next(variable.default for variable in VARIABLES if variable.name == "PORT")


def test_it_has_no_rights():
    (user,) = told("USER")
    assert int(user) > 0
    assert f"useradd --system --no-create-home --uid {user} site" in " ".join(told("RUN"))


def test_system_packages_are_those_of_the_aptfile():
    (install,) = [rest for rest in told("RUN") if "apt-get install" in rest]
    assert "xargs apt-get install -y --no-install-recommends <Aptfile" in install
    (drawing,) = (ROOT / "Aptfile").read_text().split()
    assert drawing in (ROOT / "scripts" / "require.sh").read_text()


def test_variables_are_those_of_the_table():
    set_here = {
        pair.partition("=")[0] for rest in told("ENV") for pair in rest.split() if "=" in pair
    }
    assert set_here - NOT_OURS <= KNOWN
    asked = set(re.findall(r"\$\{(\w+)", (ROOT / "compose.yaml").read_text()))
    assert asked <= KNOWN
    for service in SERVICES.values():
        assert set(service.get("environment", {})) <= KNOWN


def test_two_replicas_stand_behind_one_nginx():
    replicas = {name for name, service in SERVICES.items() if service.get("build") == "."}
    assert len(replicas) == 2
    configuration = (ROOT / "deploy" / "nginx.conf").read_text()
    port = next(variable.default for variable in VARIABLES if variable.name == "PORT")
    upstreams = set(re.findall(r"^\s+server (\S+?)[ ;]", configuration, re.MULTILINE))
    assert upstreams == {f"{name}:{port}" for name in replicas}
    (mounted,) = SERVICES["nginx"]["volumes"]
    assert (ROOT / mounted.partition(":")[0]).samefile(ROOT / "deploy" / "nginx.conf")
    (published,) = SERVICES["nginx"]["ports"]
    assert f"listen {published.rpartition(':')[2]};" in configuration


def test_replicas_trust_nginx_and_count_in_one_redis():
    for name, service in SERVICES.items():
        if service.get("build") != ".":
            continue
        told = service["environment"]
        assert told["TRUSTED_PROXIES"] == "${TRUSTED_PROXIES:-1}"
        store = re.fullmatch(r"redis://(\w+):6379/0", told["RATELIMIT_STORAGE_URI"])[1]
        assert store in service["depends_on"], name
        assert store in SERVICES
        assert service["read_only"] is True
        assert service["cap_drop"] == ["ALL"]
        assert "ports" not in service


@pytest.mark.skipif(
    nginx_program() is None, reason="nginx is missing: scripts/require.sh nginx brings it"
)
def test_nginx_takes_its_configuration(tmp_path):
    file = nginx_configuration(tmp_path, free_port(), (free_port(), free_port()))
    answer = subprocess.run(
        [nginx_program(), "-t", "-c", file], capture_output=True, text=True, check=False
    )
    assert answer.returncode == 0, answer.stderr
    file.write_text(file.read_text().replace("server_tokens off", "server_tokens perhaps"))
    answer = subprocess.run(
        [nginx_program(), "-t", "-c", file], capture_output=True, text=True, check=False
    )
    assert (answer.returncode, "perhaps" in answer.stderr) == (1, True)
