"""Sets of scans that are refused, and parts of the command, on small meshes."""

import operator

import numpy as np
import pytest
import trimesh
from made_scans import write_obj

from model.anthropometry import TAKEN
from model.shape_basis import load_shape_basis
from model.training import scans_workers
from model.training.scans import Known, Record, prepared, train_on_scans
from model.training.scans_files import ScanError
from model.training.scans_set import LEAST, find_files, find_folders, read_set
from model.training.scans_training import (
    outlier_lines,
    outliers,
    unflattened,
    write_basis,
    write_values,
)
from model.training.scans_workers import each, workers


def tall_ball(height=1.7):
    ball = trimesh.creation.icosphere(1, radius=0.5)
    return ball.vertices * [0.4, 0.3, height], ball.faces


@pytest.fixture
def folder(tmp_path):
    """Folders of each sex with scans of nobody: balls drawn out to a person's height."""
    for sex in ("FEMALE", "MALE"):
        own = tmp_path / "set" / f"SPRING_{sex}" / "mesh"
        own.mkdir(parents=True)
        for number in range(LEAST):
            write_obj(own / f"{number}.obj", *tall_ball(1.6 + 0.02 * number))
    return tmp_path / "set"


def scans_of(folder, **given):
    return find_files(find_folders(folder, given))


def read(folder, tmp_path):
    with workers(1, None):
        return read_set(scans_of(folder), tmp_path / "read")


def test_folders_are_told_by_their_names(folder, tmp_path):
    found = find_folders(folder, {})
    assert [path.name for path in found.values()] == ["SPRING_FEMALE", "SPRING_MALE"]
    given = {"female": folder / "SPRING_MALE", "male": folder / "SPRING_FEMALE"}
    assert find_folders(None, given) == given
    files = scans_of(folder)
    assert [sex for sex, _ in files] == ["female"] * LEAST + ["male"] * LEAST
    assert files[1][1].name == "1.obj"


def test_what_is_in_the_files_is_read(folder, tmp_path):
    scans = read(folder, tmp_path)
    points, faces = tall_ball(1.62)
    assert scans.sexes.tolist() == [0] * LEAST + [1] * LEAST
    assert np.abs(scans.vertices[1] - points).max() < 1e-6
    assert np.array_equal(scans.faces, faces)


def test_what_was_read_is_not_read_again_unless_it_changed(folder, tmp_path, capsys):
    read(folder, tmp_path)
    read(folder, tmp_path)
    assert "1 of 1 parts were read before" in capsys.readouterr().out
    write_obj(folder / "SPRING_MALE" / "mesh" / "0.obj", *tall_ball(1.8))
    assert np.ptp(read(folder, tmp_path).vertices[LEAST], axis=0)[2] == pytest.approx(1.8)
    assert "before" not in capsys.readouterr().out


# ---------------------------------------------------------------- refusals


def test_a_missing_folder_is_named(tmp_path, folder):
    with pytest.raises(ScanError, match=r"nowhere: no such folder"):
        train_on_scans(tmp_path / "nowhere", output=tmp_path)
    with pytest.raises(ScanError, match=r"no folder is named female there: give --female FOLDER"):
        find_folders(tmp_path, {})
    with pytest.raises(ScanError, match=r"male scans is missing: give --male FOLDER"):
        find_folders(None, {"female": folder})
    (folder / "male_too").mkdir()
    with pytest.raises(ScanError, match=r"several folders are named male there"):
        find_folders(folder, {})


def test_an_empty_folder_is_named(folder):
    for path in (folder / "SPRING_MALE" / "mesh").iterdir():
        path.rename(path.with_suffix(".txt"))
    with pytest.raises(ScanError, match=r"SPRING_MALE: no OBJ or PLY files, at least 5"):
        scans_of(folder)
    (folder / "SPRING_MALE" / "1.ply").touch()
    with pytest.raises(ScanError, match=r"SPRING_MALE: only 1 OBJ or PLY files"):
        scans_of(folder)


def test_the_odd_file_is_named_even_if_it_is_the_first(folder, tmp_path):
    points, faces = tall_ball()
    for name in ("0.obj", "2.obj"):
        path = folder / "SPRING_FEMALE" / "mesh" / name
        kept = path.read_bytes()
        write_obj(path, np.vstack([points, points[:1]]), faces)
        with pytest.raises(
            ScanError, match=rf"{name}: 43 vertices and 80 faces, where .* 42 and 80"
        ):
            read(folder, tmp_path)
        write_obj(path, points, faces[:-1])
        with pytest.raises(ScanError, match=rf"{name}: 42 vertices and 79 faces, where"):
            read(folder, tmp_path)
        write_obj(path, points, faces[::-1])
        with pytest.raises(ScanError, match=rf"{name}: .* but other faces; .* must correspond"):
            read(folder, tmp_path)
        path.write_bytes(kept)


def test_what_is_wrong_in_a_file_is_said_with_file_and_line(folder, tmp_path):
    path = folder / "SPRING_MALE" / "mesh" / "3.obj"
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:6], "v 1 nan 2", *lines[7:]]))
    with pytest.raises(ScanError, match=r"SPRING_MALE/mesh/3.obj, line 7: not finite: '1 nan 2'"):
        read(folder, tmp_path)


def test_a_mesh_that_cannot_be_mended_is_refused_with_its_place(folder, tmp_path):
    for path in folder.rglob("*.obj"):
        path.write_text("\n".join(path.read_text().splitlines()[:-1]) + "\n")
    with pytest.raises(ScanError, match=r"0.obj, and all of its mesh: .* holes.* near -?\d"):
        prepared(read(folder, tmp_path), Known(), Record())


def test_no_scheduler_is_told(monkeypatch):
    monkeypatch.setattr(scans_workers, "ANSWERS_WITHIN", 0.5)
    with pytest.raises(OSError, match=r"127\.0\.0\.1:9"), workers(1, "tcp://127.0.0.1:9"):
        pass


# ---------------------------------------------------------------- parts


def test_workers_answer_in_order(capsys):
    with workers(2, None):
        assert [*each(operator.mul, ((2, i) for i in range(5)), "{} of {}", 5)] == [0, 2, 4, 6, 8]
    assert capsys.readouterr().out.endswith("5 of 5\n")


def test_values_beyond_three_deviations_of_their_sex_are_missing():
    random = np.random.default_rng(0)
    sexes = np.repeat([0, 1], 50).astype(np.uint8)
    values = random.normal(size=(100, len(TAKEN))).clip(-2, 2) * 0.01 + 1 + sexes[:, None]
    values[7, 3], values[60, 3], values[61, 5] = 1.2, 1.5, 2.2
    found = outliers(values, sexes)
    assert np.argwhere(found).tolist() == [[7, 3], [60, 3], [61, 5]]
    lines = outlier_lines(found, sexes)
    assert lines == [
        f"values beyond mean ± 3 sd are missing: 3 of {100 * len(TAKEN)}",
        f"  {TAKEN[3]}: 1 female, 1 male",
        f"  {TAKEN[5]}: 0 female, 1 male",
    ]


def test_what_could_not_be_measured_is_missing():
    sexes = np.repeat([0, 1], 20).astype(np.uint8)
    values = np.tile(np.linspace(1, 1.1, 20), (len(TAKEN), 2)).T
    values[3, 0], values[25, 1] = np.nan, 0
    assert np.argwhere(outliers(values, sexes)).tolist() == [[3, 0], [25, 1]]


def test_flat_faces_are_opened_and_nothing_else_is_moved():
    points, faces = tall_ball()
    spoilt = points.copy()
    a, b, c = faces[10]
    spoilt[a] = (points[b] + points[c]) / 2
    same, opened = unflattened(np.array([points, spoilt]), faces)
    assert np.array_equal(same, points)
    assert trimesh.Trimesh(opened, faces, process=False).area_faces.min() > 1e-3
    moved = np.linalg.norm(opened - spoilt, axis=1) > 0
    assert moved[a]
    assert moved.sum() < 10
    # All points in one place cannot be opened.
    assert unflattened(np.zeros((1, *points.shape)), faces).size == 0


def test_missing_values_are_written_as_nothing(tmp_path):
    values = np.full((1, len(TAKEN)), 1.5)
    values[0, 1] = np.nan
    write_values(tmp_path / "m.csv", ["a.obj"], np.array([1], np.uint8), values)
    assert (tmp_path / "m.csv").read_text().splitlines()[1].startswith("a.obj,male,1.50000,,1.5")


def test_the_basis_finds_what_was_planted(tmp_path):
    random = np.random.default_rng(0)
    points, _ = tall_ball()
    planted = random.normal(size=(3, *points.shape)) * 0.01
    weights = random.normal(size=(40, 3))
    scans = (points + np.einsum("nk,kvi->nvi", weights, planted)).astype(np.float32)
    coefficients, said = write_basis(scans, tmp_path)
    assert said.startswith("3 shape components, 0.0")
    assert coefficients.std(axis=0) == pytest.approx(np.ones(3))
    basis = load_shape_basis(tmp_path)
    again = basis.vertices(coefficients)
    assert np.abs(again - scans + [0, scans[..., 1].min(), 0])[..., [0, 2]].max() < 1e-4
