"""What the documentation says is there is there: links, commands, tests, pages that commands write.

A command in a block of its own is a target of the Makefile, a script or a module of ours, and each
option of it is one that its ``--help`` tells. The section that it stands in has the day on which it
was run, or names the test that runs it; where it is none of ours it says that it was run on that
day, or that it was not.
"""

import collections
import contextlib
import functools
import io
import json
import re
import runpy
import shlex
import sys
import warnings
from pathlib import Path

import pytest

import api_page

ROOT = Path(__file__).resolve().parent.parent
PAGES = [
    str(file.relative_to(ROOT))
    for file in sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])
]
RULES = dict(
    re.findall(r"^([\w-]+):[^=\n]*\n((?:\t.*\n)*)", (ROOT / "Makefile").read_text(), re.MULTILINE)
)
"""The Makefile's targets, each with what it runs."""

ENVIRONMENT = r"(?:[A-Z_]+=(?:\$\([^)]*\)|\"[^\"]*\"|\S+) +)*"
PROGRAMS = r"(?:make|npm|npx|node|pip|curl|docker|gunicorn|(?:\S+/)?python3?|(?:\./)?scripts/\S+)"
COMMAND = re.compile(rf"{ENVIRONMENT}({PROGRAMS}(?: .+)?)$")
TOLD = re.compile(r"\b[Rr]un\s+on\s+\d{4}-\d\d-\d\d\b|\bnot\s+been\s+run\b")
DATED = re.compile(r"\b\d{4}-\d\d-\d\d\b")


def read(page):
    """A page's text without its remarks."""
    return re.sub(r"<!--.*?-->", "", (ROOT / page).read_text(), flags=re.DOTALL)


def vouched(section):
    """Whether a section has a day, or a test that is there."""
    tests = re.findall(r"`(tests/test_\w+\.py)`", section)
    return bool(DATED.search(section)) or any((ROOT / test).is_file() for test in tests)


def in_blocks(text):
    """The commands in a text's blocks, each with the remark behind it; broken lines are joined."""
    fenced = "".join(re.findall(r"^```\w*\n(.*?)^```", text, re.M | re.S)).splitlines()
    indented = re.findall(r"^ {4}(?! )((?:.*\\\n)*.*)", text, re.MULTILINE)
    for line in [*fenced, *indented]:
        command, _, remark = re.sub(r"\\\n *", "", line).partition("  # ")
        if found := COMMAND.match(command.strip()):
            yield found[1], remark


def in_lines(text):
    """The commands of ours that a text names in passing."""
    for code in re.findall(r"`([^`\n]+)`", text):
        if found := COMMAND.match(code):
            yield found[1], ""


@functools.cache
def help_of(*words):
    """What ``--help`` tells of a script of ours, or of a module after ``-m``."""
    told, arguments = io.StringIO(), sys.argv
    run, words = (runpy.run_module, words[1:]) if words[0] == "-m" else (runpy.run_path, words)
    sys.argv = [*words, "--help"]
    try:
        with (
            contextlib.redirect_stdout(told),
            contextlib.suppress(SystemExit),
            warnings.catch_warnings(),
        ):
            # Another test may have imported it: that it is there twice is told, and does no harm.
            warnings.simplefilter("ignore", RuntimeWarning)
            run(words[0], run_name="__main__")
    finally:
        sys.argv = arguments
    return told.getvalue()


def fault(command, remark=""):
    """What is wrong with a command; None where nothing is, "unknown" where it is none of ours."""
    program, *words = shlex.split(command)
    if program == "make":
        target = words[0] if words else "help"
        if target not in RULES:
            return f"no target {target}"
        runs = re.search(r"/python (-m [\w.]+(?: [a-z]+)?|\S+\.py)[^\n]* \$\(ARGS\)", RULES[target])
        given = " ".join(re.findall(r'ARGS="([^"]*)"', f"{command} {remark}"))
        words = [*(runs[1].split() if runs else []), *given.split()]
    elif program == "node":
        return None if (ROOT / words[0]).is_file() else f"no {words[0]}"
    elif not program.endswith(("python", "python3")) or words[:1] != ["-m"]:
        return "unknown"
    else:
        words += remark.split() if "--" in remark else []
    if words[:1] == ["-m"] and not (ROOT / words[1].replace(".", "/") / "__main__.py").is_file():
        return "unknown"
    named = 1 if words[:1] != ["-m"] else 2 + bool(re.fullmatch("[a-z]+", (*words, "", "", "")[2]))
    options = {word.partition("=")[0] for word in words if word.startswith("--")}
    known = help_of(*words[:named]) if words else ""
    return f"no option {options}" if any(option not in known for option in options) else None


@pytest.mark.parametrize("page", PAGES)
def test_every_command_can_be_run_or_says_when_it_was(page):
    for section in re.split(r"^(?=#+ )", read(page), flags=re.MULTILINE):
        for command, remark in in_blocks(section):
            if command.startswith("curl"):
                continue  # See below.
            found = fault(command, remark)
            assert found is None or (found == "unknown" and TOLD.search(section)), (command, found)
            assert vouched(section), f"{command}: run when, or by which test?"
    for command, remark in in_lines(read(page)):
        assert fault(command, remark) in (None, "unknown"), command


@pytest.mark.parametrize(
    ("command", "remark", "found"),
    [
        ("make nonsense", "", "no target nonsense"),
        ("make fuzz", 'ARGS="--nonsense 7" for others', "no option {'--nonsense'}"),
        ("make fuzz", 'ARGS="--seed 7" for others', None),
        (
            ".venv/bin/python -m model.training scans FOLDER --nonsense",
            "",
            "no option {'--nonsense'}",
        ),
        (".venv/bin/python -m model.training scans FOLDER --jobs 2", "", None),
        ("python -m bench load", "--nonsense 500", "no option {'--nonsense'}"),
        ("node scripts/nonsense.mjs", "", "no scripts/nonsense.mjs"),
        ("docker compose up", "", "unknown"),
    ],
)
def test_a_command_that_is_not_there_is_found(command, remark, found):
    assert fault(command, remark) == found


def test_a_section_without_a_day_or_a_test_is_found():
    assert vouched("run on 2026-11-22")
    assert vouched("`tests/test_docs.py` runs it")
    assert not vouched("`tests/test_nonsense.py` runs it")


def test_the_examples_of_calls_are_answered(client):
    calls = [command for page in PAGES for command, _ in in_blocks(read(page)) if "curl" in command]
    assert calls
    for call in calls:
        words = shlex.split(call)
        path = re.search(r"127\.0\.0\.1:8000(\S+)", call)[1]
        answer = client.post(path, json=json.loads(words[words.index("-d") + 1]))
        assert answer.status_code == 200, call


def anchors(page):
    """The places on a page that a link can lead to: its own, and its headings."""
    titles = re.findall(r"^#+ +(.+)$", read(page), re.MULTILINE)
    return set(re.findall(r'<a id="(\w+)">', read(page))) | {
        re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles
    }


@pytest.mark.parametrize("page", PAGES)
def test_every_link_within_the_project_leads_somewhere(page):
    for link in re.findall(r"\]\(([^)\s:]+)\)", read(page)):
        file, _, place = link.partition("#")
        there = ((ROOT / page).parent / file).resolve() if file else ROOT / page
        assert there.exists(), link
        if place:
            assert place in anchors(there.relative_to(ROOT)), link


def test_the_readme_leads_to_every_page():
    linked = set(re.findall(r"\]\((docs/\w+\.md)\)", read("README.md")))
    assert linked == {page for page in PAGES if page.startswith("docs/")}


def test_the_page_of_the_api_is_what_the_command_writes():
    assert (ROOT / "docs" / "api.md").read_text() == api_page.page(), "run: make api"


def test_every_requirement_has_a_finding_and_every_test_that_it_names_exists():
    page = read("docs/asvs.md")
    rows = re.findall(r"^\| (\d+\.\d+\.\d+) \| .+? \| (.+) \|$", page, re.MULTILINE)
    assert len(rows) == len(dict(rows)) == 128
    found = collections.Counter(
        re.match(r"(Held|Not applicable|The host's|Not held)", row[1])[1] for row in rows
    )
    told = re.findall(r"^\| (held|not applicable|the host's|not held) \| (\d+) \|$", page, re.M)
    assert {words.capitalize(): int(count) for words, count in told} == found
    tests = "".join(file.read_text() for file in (ROOT / "tests").glob("*.py"))
    browser = {file.name: file.read_text() for file in (ROOT / "tests" / "browser").glob("*.js")}
    for name in re.findall(r"`(test_\w+)`", page):
        assert f"def {name}(" in tests, name
    for name, title in re.findall(r"`(\w+\.spec\.js)`: ([^;)]+)", page):
        assert f'test("{title}"' in browser[name], title
