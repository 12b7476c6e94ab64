"""A site whose files are not whole does not start, and names the file."""

import os
import shutil

import pytest

from model.estimators import load_estimators
from model.template_mesh import DATA

FILES = (
    *("estimators/female.npz", "estimators/neutral.npz", "shape_basis.npz", "strips.npz"),
    *("shape_directions.npy", "template_mesh.npz", "landmarks.json"),
)


@pytest.fixture
def data(tmp_path):
    """A folder of the shipped data, by links that a test may replace."""
    (tmp_path / "estimators").mkdir()
    for file in [*DATA.glob("*.*"), *DATA.glob("estimators/*.npz")]:
        (tmp_path / file.relative_to(DATA)).symlink_to(file)
    return tmp_path


@pytest.mark.parametrize("name", FILES)
def test_a_missing_file_is_named(data, name):
    (data / name).unlink()
    with pytest.raises(FileNotFoundError, match=name.replace(".", r"\.")):
        load_estimators(data)


@pytest.mark.parametrize("name", FILES)
def test_a_file_that_was_cut_off_is_named(data, name):
    file = data / name
    file.unlink()
    shutil.copy(DATA / name, file)
    os.truncate(file, file.stat().st_size // 2)
    with pytest.raises(ValueError, match=rf"{name.replace('.', r'[.]')} is (damaged|not)"):
        load_estimators(data)
