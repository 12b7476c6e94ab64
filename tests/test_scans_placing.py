import itertools

import numpy as np
import pytest
import trimesh

from model.estimators import load_estimators
from model.training.scans_files import ScanError
from model.training.scans_placing import (
    AXES,
    Frame,
    direction,
    on_the_ground,
    place,
    recognise_axes,
    recognise_unit,
)


@pytest.fixture(scope="module")
def estimator():
    return load_estimators()["neutral"]


@pytest.fixture(scope="module")
def some(estimator):
    """Six bodies, (6, V, 3)."""
    random = np.random.default_rng(0)
    return estimator.basis.vertices(random.normal(size=(6, len(estimator.basis.directions))) / 3)


WAYS = [(up, front) for up, front in itertools.product(AXES, AXES) if up[1] != front[1]]


def as_scans(bodies, unit, up, front):
    """Bodies in another unit and axes, anywhere."""
    return (bodies @ np.linalg.inv(Frame(unit, up, front).matrix).T + 0.3).astype(np.float32)


def names(scans):
    return [f"{i}.obj" for i in range(len(scans))]


@pytest.mark.parametrize(("up", "front"), WAYS)
def test_a_frame_turns_and_does_not_mirror(up, front):
    frame = Frame("cm", up, front)
    assert np.linalg.det(frame.matrix) == pytest.approx(1e-6)
    assert frame.matrix @ direction(up) == pytest.approx([0, 0.01, 0])
    assert frame.matrix @ direction(front) == pytest.approx([0, 0, 0.01])


@pytest.mark.parametrize(
    ("unit", "up", "front"),
    [
        ("m", "+z", "-y"),
        ("cm", "+y", "+z"),
        ("mm", "-x", "+y"),
        ("cm", "+z", "+x"),
        ("m", "-y", "-z"),
    ],
)
def test_unit_and_axes_are_recognised(estimator, some, unit, up, front):
    scans = as_scans(some, unit, up, front)
    assert recognise_unit(names(scans), scans, None, None) == (unit, "xyz".index(up[1]))
    faces = estimator.template.faces
    mean = scans.mean(axis=0, dtype=float)
    frame = recognise_axes(estimator, mean, faces, unit, "xyz".index(up[1]), (None, None))
    assert (frame.unit, frame.up, frame.front) == (unit, up, front)


def test_scans_are_laid_on_one_another(some):
    turned = some.copy()
    for row, angle in enumerate(np.radians([0, 5, -8, 20, -30, 13])):
        turn = np.array(
            [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
        )
        turned[row] = some[row] @ turn.T + [0.1 * row, row, -0.2]
    scans = as_scans(turned, "mm", "+z", "-y")
    most = place(names(scans), scans, Frame("mm", "+z", "-y"))
    assert most == pytest.approx(30, abs=4)
    assert np.abs(scans[:, :, 1].min(axis=1)).max() < 1e-5
    # But for how they lie together, the shapes are what they were.
    centred = scans - scans.mean(axis=1, keepdims=True)
    truth = some - some.mean(axis=1, keepdims=True)
    angle = np.arctan2(
        np.sum(truth[0, :, 0] * centred[0, :, 2] - truth[0, :, 2] * centred[0, :, 0]),
        np.sum(truth[0] * centred[0]) - np.sum(truth[0, :, 1] * centred[0, :, 1]),
    )
    back = np.array(
        [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
    )
    assert np.abs(centred @ back.T - truth).max() < 1e-4


# ---------------------------------------------------------------- refusals


def test_a_height_of_nobody_is_refused(some):
    for factor in (39.37, 3.28, 0.1):
        with pytest.raises(ScanError, match=r"^0.obj: \S+ high; in metres, centimetres or milli"):
            recognise_unit(names(some), (some * factor).astype(np.float32), None, None)


@pytest.mark.parametrize(
    ("factor", "said"), [(100, "is it in cm"), (1000, "is it in mm"), (0.3, "adults")]
)
def test_one_scan_in_another_unit_is_named(some, factor, said):
    scans = some.astype(np.float32)
    scans[3] *= factor
    with pytest.raises(ScanError, match=rf"^3.obj: \S+ m high, if in m as the set is: {said}"):
        recognise_unit(names(scans), scans, None, None)


def test_a_unit_that_is_said_is_checked(some):
    with pytest.raises(ScanError, match="if in mm as the set is"):
        recognise_unit(names(some), some.astype(np.float32), "mm", None)


def test_people_who_are_as_wide_as_high_need_up_said(some):
    wide = some.copy()
    wide[:, :, 0] *= 1.75
    with pytest.raises(ScanError, match=r"which way is up.*give --up"):
        recognise_unit(names(wide), wide.astype(np.float32), None, None)
    assert recognise_unit(names(wide), wide.astype(np.float32), None, "-y") == ("m", 1)


def test_what_faces_both_ways_needs_front_said(estimator):
    # A ball is the same from all sides.
    ball = trimesh.creation.icosphere(4, radius=0.85)
    with pytest.raises(
        ScanError, match=r"is up .* front .* or up .* front .* Give --up and --front"
    ):
        recognise_axes(estimator, ball.vertices, ball.faces.astype(np.int32), "m", 1, (None, None))


def test_up_and_front_along_one_axis_are_refused(estimator, some):
    with pytest.raises(ScanError, match="must be two axes"):
        recognise_axes(estimator, some[0], estimator.template.faces, "m", 1, ("+y", "-y"))


def test_one_scan_that_faces_elsewhere_is_named(some):
    scans = some.astype(np.float32)
    scans[2] *= [-1, 1, -1]
    with pytest.raises(ScanError, match=r"^2.obj: turned by 1[78]\d degrees"):
        place(names(scans), scans, Frame("m", "+y", "+z"))


def test_one_scan_that_does_not_correspond_is_named(some):
    scans = some.astype(np.float32)
    scans[4] = scans[4][np.random.default_rng(0).permutation(len(scans[4]))]
    with pytest.raises(ScanError, match=r"^4.obj: .*(do not correspond|degrees)"):
        place(names(scans), scans, Frame("m", "+y", "+z"))


def test_the_ground_is_at_zero():
    points = on_the_ground(np.array([[1.0, 2, 3], [3, 5, 9], [2, 3, 4]]))
    assert points.min(axis=0).tolist() == [-1, 0, -3]
    assert points.max(axis=0).tolist() == [1, 3, 3]
