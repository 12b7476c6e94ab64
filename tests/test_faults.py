"""What cannot be broken here is said, and does not count as withstood."""

import sys

import pytest

import fault_ways
import faults


@pytest.fixture
def no_mounting(tmp_path, monkeypatch):
    """A machine on which nothing may be mounted."""
    (tmp_path / "mount").write_text("#!/bin/sh\necho 'mount: permission denied' >&2\nexit 32\n")
    (tmp_path / "mount").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")


def test_a_fault_that_was_not_tried_is_not_passed(no_mounting, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["faults.py", "full_disk"])
    with pytest.raises(SystemExit, match="1 not tried"):
        faults.main()
    assert "| the disk is full | **not tried**: " in capsys.readouterr().out


def test_what_is_not_as_it_should_be_stops_it():
    with pytest.raises(SystemExit, match="a picture"):
        fault_ways.expect(False, "a picture")
