"""The rules of the house are held by linters, and each of these guards is shown to fire."""

import json
import re
import shutil
import subprocess
import sys
import tomllib
import warnings
from pathlib import Path

import pytest

import licences
from webapp import openapi

ROOT = Path(__file__).resolve().parent.parent
BIN = Path(sys.executable).parent
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
LOCKS = ["requirements.txt", "requirements-dev.txt", "requirements-population.txt"]
MEGABYTE = 2**20


# ---------------------------------------------------------------- style: ruff


def ruff(name, text):
    """What ruff says of a file of this name and text in the project."""
    return subprocess.run(
        [BIN / "ruff", "check", "--no-cache", "--output-format=concise", "--stdin-filename", name],
        input=text,
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize(
    ("name", "text", "rule"),
    [
        ("model/estimators.py", "import torch\n", "TID251"),
        ("model/training/survey.py", "import anny\n", "TID251"),
        ("webapp/avatars.py", "import pyrender\n", "TID251"),
        ("model/gltf.py", "from pyrender import Mesh\n", "TID251"),
        ("tests/test_gltf.py", "def test_it():\n    import pyrender\n", "TID251"),
        ("model/estimators.py", "import pickle\n", "TID251"),
        ("model/estimators.py", "from joblib import dump\n", "TID251"),
        ("model/geometry.py", 'print("a body")\n', "T201"),
        ("model/geometry.py", "def area(faces):\n    return 0\n", "D103"),
        (
            "model/geometry.py",
            '"""A."""\n\n\nclass Tape:\n    """A."""\n\n    def read(self): ...\n',
            "D102",
        ),
        ("model/geometry.py", "import math\n", "D100"),
        ("webapp/api.py", "try:\n    x = 1\nexcept Exception:\n    pass\n", "BLE001"),
        ("webapp/api.py", 'x = eval("1")\n', "S307"),
    ],
)
def test_ruff_refuses(name, text, rule):
    answer = ruff(name, text)
    assert answer.returncode == 1
    assert rule in answer.stdout


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("model/studio.py", "import pyrender\n"),
        ("model/training/anny_population.py", "import anny\nimport torch\n"),
    ],
)
def test_each_guarded_package_has_one_door(name, text):
    assert "TID251" not in ruff(name, text).stdout


# ---------------------------------------------------------------- imports: import-linter


BROKEN = {
    "The site stands on the model": [
        ("model/estimators.py", "webapp"),
        ("webapp/api.py", "bench"),
    ],
    "Inside the model": [
        ("model/geometry.py", "model.measurements"),
        ("model/measurements.py", "model.template_mesh"),
        ("model/template_mesh.py", "model.anthropometry"),
        ("model/anthropometry.py", "model.gltf"),
        ("model/gltf.py", "model.rendering"),
        ("model/estimators.py", "model.training"),
    ],
    "The model knows no web": [
        ("model/estimators.py", "flask"),
        ("model/training/validation.py", "jinja2"),
    ],
    "A running site does not learn": [
        ("webapp/api.py", "model.training"),
        ("model/geometry.py", "torch"),
    ],
}
"""By the beginning of a contract's name: files, and what they may not import."""


@pytest.fixture
def project(tmp_path):
    """A copy of the project's Python files and of its rules."""
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    for package in ("model", "webapp", "bench"):
        for file in (ROOT / package).rglob("*.py"):
            copy = tmp_path / file.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, copy)
    return tmp_path


def lint_imports(folder):
    """What import-linter says of the project in a folder."""
    return subprocess.run(
        [BIN / "lint-imports", "--no-logo", "--no-cache"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_imports_are_those_of_the_house(project):
    answer = lint_imports(project)
    assert answer.returncode == 0, answer.stdout


def test_import_linter_refuses_every_import_that_no_contract_allows(project):
    for name, imported in [broken for rows in BROKEN.values() for broken in rows]:
        with (project / name).open("a") as file:
            file.write(f"\nimport {imported}\n")
    answer = lint_imports(project)
    assert answer.returncode == 1
    for contract, rows in BROKEN.items():
        assert re.search(rf"^{contract}.* BROKEN$", answer.stdout, re.MULTILINE), answer.stdout
        told = re.search(
            rf"^{contract}[^\n]*\n-+\n(.*?)(?=^[^\n]+\n---|\Z)", answer.stdout, re.M | re.S
        )
        for name, imported in rows:
            module = name.removesuffix(".py").replace("/", ".")
            assert f" {module} -> {imported} (l." in told[1], (contract, name, imported)


def test_import_linter_refuses_a_file_without_a_place(project):
    (project / "model" / "utils.py").write_text("import math\n")
    answer = lint_imports(project)
    assert answer.returncode == 1
    assert re.search(r"Inside the model.* BROKEN", answer.stdout), answer.stdout
    assert "utils" in answer.stdout


# ---------------------------------------------------------------- types, warnings


def test_mypy_refuses(tmp_path):
    file = tmp_path / "room.py"
    file.write_text('def untyped(x):\n    return x\n\n\nx: int = "one"\n')
    answer = subprocess.run(
        [BIN / "mypy", "--config-file", ROOT / "pyproject.toml", "--no-incremental", file],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert answer.returncode == 1
    assert "room.py:1: error" in answer.stdout
    assert "room.py:5: error" in answer.stdout


def test_a_warning_is_an_error():
    with pytest.raises(DeprecationWarning, match="old"):
        warnings.warn("old", DeprecationWarning, stacklevel=1)


def test_every_file_of_ours_is_checked():
    checked = PYPROJECT["tool"]["mypy"]["files"]
    assert set(checked) >= set(PYPROJECT["tool"]["importlinter"]["root_packages"])
    assert "exclude" not in PYPROJECT["tool"]["ruff"]


# ---------------------------------------------------------------- names and sizes


def tracked():
    """The files that git holds."""
    if not (ROOT / ".git").exists():
        pytest.skip("not a git checkout")
    listed = subprocess.run(
        # A checkout may belong to someone else, as one does that is mounted into a container.
        ["git", "-c", f"safe.directory={ROOT}", "ls-files", "-z"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    return [ROOT / name for name in listed.stdout.split("\0") if name and (ROOT / name).exists()]


def test_no_file_is_too_large_for_git():
    large = [file for file in tracked() if file.stat().st_size > 16 * MEGABYTE]
    assert large == []


def test_shipped_data_stay_small():
    data = sum(f.stat().st_size for f in (ROOT / "model" / "data").rglob("*") if f.is_file())
    assert data < 25 * MEGABYTE


def test_no_environment_or_secret_is_in_git():
    roots = {file.relative_to(ROOT).parts[0] for file in tracked()}
    assert roots.isdisjoint({".venv", ".venv-population", "node_modules", "instance"})


def python_files():
    """Every Python file of the project."""
    return [
        file
        for room in ("model", "webapp", "bench", "scripts", "tests")
        for file in (ROOT / room).rglob("*.py")
    ]


def test_every_file_has_a_subject():
    vague = {"utils", "util", "helpers", "common", "core", "manager", "services", "misc"}
    assert [file for file in python_files() if file.stem in vague] == []


LONGEST = 450
"""Lines of a file at most."""


def test_no_file_eats_the_project():
    own = [
        file
        for pattern in ("static/**/*.js", "static/**/*.css", "tests/browser/*.js", "scripts/*.mjs")
        for file in ROOT.glob(pattern)
        if "build" not in file.relative_to(ROOT).parts
    ]
    assert len(own) > 20
    lines = {
        str(file.relative_to(ROOT)): file.read_text().count("\n")
        for file in [*python_files(), *own]
    }
    long = {name: count for name, count in lines.items() if count > LONGEST}
    assert long == {}


def test_the_packages_are_named():
    packages = PYPROJECT["tool"]["setuptools"]["packages"]
    found = {
        ".".join(file.parent.relative_to(ROOT).parts)
        for room in ("model", "webapp")
        for file in (ROOT / room).rglob("__init__.py")
    }
    assert set(packages) == found


def test_the_tests_are_flat():
    assert list((ROOT / "tests").rglob("__init__.py")) == []
    assert list((ROOT / "tests").glob("*/test_*.py")) == []


# ---------------------------------------------------------------- lock files


@pytest.mark.parametrize("lock", [*LOCKS, "package-lock.json"])
def test_a_lock_file_names_no_host(lock):
    text = (ROOT / lock).read_text()
    assert not re.search(r"://|--index|--find-links|--trusted|^file:|\"resolved\"", text, re.M)


@pytest.mark.parametrize("lock", LOCKS)
def test_a_lock_file_pins_every_line(lock):
    text = (ROOT / lock).read_text()
    for line in re.findall(r"^[^\s#].*$", text, re.MULTILINE):
        assert re.match(r"[\w.-]+==\S+", line)


@pytest.mark.parametrize("lock", LOCKS[:2])
def test_every_package_of_a_site_has_hashes(lock):
    entries = re.split(r"^(?=\w)", (ROOT / lock).read_text(), flags=re.MULTILINE)[1:]
    assert all("--hash=sha256:" in entry for entry in entries)


def names(requirements):
    """Names of packages in requirement lines such as `flask>=3.1`, and in groups named there."""
    groups = [line["include-group"] for line in requirements if isinstance(line, dict)]
    lines = [line for line in requirements if isinstance(line, str)]
    lines += [line for group in groups for line in PYPROJECT["dependency-groups"][group]]
    return {re.match(r"[\w.-]+", line)[0].lower() for line in lines}


def test_the_lock_files_cover_what_is_declared():
    runtime, dev, population = (dict(licences.locked((ROOT / lock).read_text())) for lock in LOCKS)
    declared = names(PYPROJECT["project"]["dependencies"])
    groups = PYPROJECT["dependency-groups"]
    assert declared <= runtime.keys()
    assert declared | names(groups["dev"]) <= dev.keys()
    assert declared | names(groups["population"]) <= population.keys()
    assert runtime.items() <= dev.items()
    assert runtime.items() <= population.items()


def test_a_site_installs_neither_anny_nor_pytorch():
    for lock in LOCKS[:2]:
        packages = dict(licences.locked((ROOT / lock).read_text()))
        assert packages.keys().isdisjoint({"anny", "torch"})


def test_a_site_installs_nothing_that_only_training_needs():
    runtime, dev, population = (dict(licences.locked((ROOT / lock).read_text())) for lock in LOCKS)
    assert "pygeodesic" not in runtime
    training = names(PYPROJECT["dependency-groups"]["training"])
    assert training <= dev.keys()
    assert training <= population.keys()


def test_pyopengl_is_the_one_that_renders():
    runtime = dict(licences.locked((ROOT / "requirements.txt").read_text()))
    assert runtime["pyrender"] == "0.1.45"
    assert runtime["pyopengl"] == "3.1.10"


def test_npm_packages_are_pinned():
    package = re.findall(r'"[^"]+": "([\^~><*][^"]*)"', (ROOT / "package.json").read_text())
    assert package == [">=20"]


# ---------------------------------------------------------------- the version


def test_every_place_names_the_same_version():
    node, lock = (json.loads((ROOT / f"package{end}.json").read_text()) for end in ("", "-lock"))
    newest = re.search(
        r"^## \[(.*?)\] - \d{4}-\d\d-\d\d$", (ROOT / "CHANGELOG.md").read_text(), re.M
    )
    assert {
        PYPROJECT["project"]["version"],
        node["version"],
        lock["version"],
        lock["packages"][""]["version"],
        openapi.VERSION,
    } == {newest[1]}
