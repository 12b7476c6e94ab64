"""A site whose files are not whole does not start, and names the file."""

import os
import re
import shutil
import subprocess

import pytest

from model.checksums import FILES, SUMS_FILE, check_sums, write_sums
from model.estimators import load_estimators
from model.rig import load_rig
from model.template_mesh import DATA, DamagedFileError


@pytest.fixture
def data(tmp_path):
    """A folder of the shipped files, by links that a test may replace."""
    (tmp_path / "estimators").mkdir()
    for name in (*FILES, SUMS_FILE):
        (tmp_path / name).symlink_to(DATA / name)
    return tmp_path


@pytest.fixture
def own(data):
    """The same folder, in which a file is made one's own copy, which may be changed."""

    def copy(name):
        (data / name).unlink()
        return shutil.copy(DATA / name, data / name)

    return copy


@pytest.mark.parametrize("name", [*FILES, SUMS_FILE])
def test_a_missing_file_is_named(data, name, make_site):
    (data / name).unlink()
    with pytest.raises(FileNotFoundError, match=re.escape(name)):
        make_site(FITTING_ROOM_DATA=data)


@pytest.mark.parametrize("name", FILES)
def test_a_file_that_was_cut_off_is_named(data, own, name, make_site):
    file = own(name)
    os.truncate(file, file.stat().st_size // 2)
    with pytest.raises(ValueError, match=f"{re.escape(name)} is damaged"):
        make_site(FITTING_ROOM_DATA=data)


@pytest.mark.parametrize("name", FILES)
def test_a_file_with_one_changed_bit_is_named(data, own, name, make_site):
    file = own(name)
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(content)
    with pytest.raises(ValueError, match=f"{re.escape(name)} is damaged"):
        make_site(FITTING_ROOM_DATA=data)


@pytest.mark.parametrize("harm", ["cut off", "emptied", "changed", "another path"])
def test_sums_that_are_none_are_refused(data, own, harm):
    file = own(SUMS_FILE)
    lines = file.read_text().splitlines(keepends=True)
    file.write_text(
        {
            "cut off": "".join(lines)[:-9],
            "emptied": "",
            "changed": "".join(lines).replace("  rig.npz", "  rag.npz"),
            "another path": "".join([*lines, f"{'0' * 64}  ../../webapp/api.py\n"]),
        }[harm]
    )
    with pytest.raises(DamagedFileError, match=SUMS_FILE):
        load_estimators(data)


def test_sums_are_those_of_sha256sum(data):
    if shutil.which("sha256sum") is None:
        pytest.skip("sha256sum is missing")
    write_sums(data)
    check_sums(data)
    assert (data / SUMS_FILE).read_text() == (DATA / SUMS_FILE).read_text()
    subprocess.run(["sha256sum", "--strict", "--check", SUMS_FILE], cwd=data, check=True)


def test_a_file_that_fits_its_sum_and_is_none_of_ours_is_named_too(data):
    for name in ("shape_directions.npy", "rig.npz"):
        (data / name).unlink()
        (data / name).write_bytes(b"no arrays")
    write_sums(data)
    with pytest.raises(DamagedFileError, match=r"shape_directions\.npy"):
        load_estimators(data)
    with pytest.raises(DamagedFileError, match=r"rig\.npz"):
        load_rig(data)
