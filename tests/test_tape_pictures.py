"""Tapes in pictures: what is seen, where it is drawn, and that there are words for it."""

import io

import numpy as np
import pytest
import trimesh
from PIL import Image

from model.anthropometry import TAKEN, measure
from model.appearance import dress, vertex_normals
from model.cameras import Camera, Projection
from model.measurements import MEASUREMENTS
from model.rendering import Painted, in_underwear, photograph
from model.tape_pictures import (
    ACCENT,
    BACK,
    BACK_LEFT,
    FRONT,
    GAP,
    LEFT,
    PANEL,
    _dense,
    _frame,
    _steady,
    seen,
    tape_picture,
    text_alternative,
    views_of,
)
from model.template_mesh import Body, load_template_mesh


@pytest.fixture(scope="module")
def body():
    template = load_template_mesh()
    return Body(template, template.vertices, "female")


@pytest.fixture(scope="module")
def paths(body):
    return measure(body).paths


def accented(data):
    """Where a picture has the tapes' colour: ndarray of booleans (rows, columns)."""
    pixels = np.asarray(Image.open(io.BytesIO(data)).convert("RGB")).astype(int)
    return np.abs(pixels - ACCENT).max(axis=2) < 40


def test_a_loop_around_a_tube_is_seen_as_far_as_the_camera_sees_it():
    """From a distance d a tube of radius r is seen for arccos(r/d) to either side."""
    radius, distance = 0.2, 2.0
    tube = trimesh.creation.cylinder(radius, 1.0, sections=720)
    vertices = np.asarray(tube.vertices)[:, [0, 2, 1]] + (0, 0.5, 0)
    faces = np.asarray(tube.faces)[:, ::-1].astype(np.int32)
    painted = Painted(vertices, vertex_normals(vertices, faces), [(faces, (0.8, 0.7, 0.6))])
    camera = Camera(distance, 0.5)
    projection = Projection(camera, FRONT.right, FRONT.towards, 1200.0, 300.0, 300.0)
    depths = photograph(painted, projection, (600, 600)).depths
    angles = np.radians(np.arange(-180, 180, 1.0))
    height = np.full(360, 0.5)
    loop = np.column_stack([radius * np.sin(angles), height, radius * np.cos(angles)])
    flags = seen(loop, projection, depths)
    limit = np.arccos(radius / distance)
    # Within a few degrees, where the skin runs almost along the line of sight.
    assert flags[np.abs(angles) < limit - 0.12].all()
    assert not flags[np.abs(angles) > limit + 0.12].any()


def test_a_point_outside_the_picture_is_hidden_by_nothing(body):
    projection = Projection(Camera(), FRONT.right, FRONT.towards, 100.0, 50.0, 50.0)
    depths = np.zeros((200, 200), dtype=np.float32)
    points = np.array([[9.0, 9.0, 0.0], [0.0, 0.9, 0.0]])
    np.testing.assert_array_equal(seen(points, projection, depths), [True, False])


@pytest.mark.parametrize("view", [FRONT, BACK, LEFT, BACK_LEFT], ids=lambda view: view.words)
def test_a_view_looks_level_and_has_its_right_at_its_right(view):
    upright = np.cross(view.towards, view.right)
    np.testing.assert_allclose(upright, [0, 1, 0], atol=1e-12)


def test_the_camera_at_the_left_stands_at_the_persons_left():
    np.testing.assert_allclose(LEFT.towards, [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(BACK.right, [-1, 0, 0], atol=1e-12)


@pytest.mark.parametrize("name", TAKEN)
def test_every_measurement_is_drawn(body, paths, name):
    data = tape_picture(body, name, paths[name])
    picture = Image.open(io.BytesIO(data))
    count = len(views_of(name))
    assert (picture.format, picture.size) == (
        "WEBP",
        ((PANEL[0] + GAP) * count - GAP, PANEL[1]),
    )
    assert len(data) < 30_000
    marks = accented(data)
    for place in range(count):
        left = place * (PANEL[0] + GAP)
        assert marks[:, left : left + PANEL[0]].sum() > 200


@pytest.mark.parametrize("name", [n for n in TAKEN if MEASUREMENTS[n].kind in ("girth", "length")])
def test_the_views_of_a_tape_show_nearly_all_of_it(body, paths, name):
    kind = MEASUREMENTS[name].kind
    dense = _dense(paths[name], closed=kind == "girth")
    shown = np.zeros(len(dense), dtype=bool)
    for view in views_of(name):
        projection = _frame(body, kind, paths[name], view, 0.0, PANEL)
        depths = photograph(in_underwear(dress(body)), projection, PANEL).depths
        pixels = projection.pixels(dense)
        assert (pixels > 0).all() and (pixels < PANEL).all()
        shown |= seen(dense, projection, depths)
    assert shown.mean() > (0.6 if name == "armscye_girth" else 0.7)


@pytest.mark.parametrize("name", ["stature", "waist_height", "inseam_height"])
def test_a_dimension_line_is_as_long_as_the_height(body, paths, name):
    path = paths[name]
    marks = accented(tape_picture(body, name, path))
    column = marks.sum(axis=0).argmax()
    rows = np.flatnonzero(marks[:, column])
    view = views_of(name)[0]
    projection = _frame(body, "height", path, view, 0.6, PANEL)
    tops = projection.pixels(path)[:, 1]
    # The frame is as tall whatever the line's place beside the body, unless it is very wide.
    assert rows[-1] - rows[0] == pytest.approx(tops[1] - tops[0], rel=0.12)
    # In one piece.
    assert len(rows) > 0.95 * (rows[-1] - rows[0])


def test_the_same_picture_comes_out_again(body, paths):
    assert tape_picture(body, "waist_girth", paths["waist_girth"]) == tape_picture(
        body, "waist_girth", paths["waist_girth"]
    )


def test_short_runs_are_not_shown():
    flags = np.array([1] * 9 + [0] * 2 + [1] * 9 + [0] * 8, dtype=bool)
    np.testing.assert_array_equal(_steady(flags), np.array([1] * 20 + [0] * 8, dtype=bool))
    np.testing.assert_array_equal(_steady(~flags), np.array([0] * 20 + [1] * 8, dtype=bool))


def test_a_dense_loop_is_closed():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1.0]])
    dense = _dense(square, closed=True)
    np.testing.assert_allclose(dense[0], dense[-1])
    lengths = np.linalg.norm(np.diff(dense, axis=0), axis=1)
    assert lengths.max() <= 0.003 + 1e-12
    assert lengths.sum() == pytest.approx(4.0, abs=0.01)


def test_the_words_say_what_is_drawn_and_from_where():
    assert text_alternative("waist_girth", "female") == (
        "Waist: perimeter of the narrowest part of the torso; a tape on the body of a woman, "
        "seen from the front and from the back."
    )
    assert "waist (the narrowest part of the torso)" in text_alternative("waist_height", "female")
    assert text_alternative("weight", "male") == "Weight: a man standing on a scale."
    assert "a line beside a person" in text_alternative("stature", "neutral")
    words = [text_alternative(name, "female") for name in TAKEN]
    assert len(set(words)) == len(TAKEN)
