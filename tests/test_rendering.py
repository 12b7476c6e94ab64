"""The pictures against the camera's own arithmetic."""

import io
from types import MappingProxyType

import numpy as np
import pytest
import trimesh
from PIL import Image

from model.appearance import BACKDROP, dress
from model.cameras import MARGIN, Camera, project
from model.rendering import (
    FINENESS,
    Painted,
    in_underwear,
    photograph,
    render_png,
)
from model.template_mesh import Body, Landmark, TemplateMesh, load_template_mesh

CAMERAS = [Camera(), Camera(1.0, 0.0), Camera(1.0, 3.0), Camera(10.0, 1.6), Camera(2.0, 1.2)]


@pytest.fixture(scope="module")
def body():
    template = load_template_mesh()
    return Body(template, template.vertices, "female")


def body_of(mesh):
    """Any closed mesh as a body that stands on the floor, bare but for what lies at its middle."""
    vertices = np.array(mesh.vertices)
    vertices[:, 1] -= vertices[:, 1].min()
    faces = np.asarray(mesh.faces, dtype=np.int32)
    heights = {
        "crotch": 0.4,
        "omphalion": 0.6,
        "axilla_left": 0.9,
        "axilla_right": 0.9,
        "thelion_left": 0.8,
        "thelion_right": 0.8,
        "underbust": 0.7,
    }
    tall = vertices[:, 1].max()
    nearest = {
        name: int(np.abs(vertices[faces][:, :, 1].mean(axis=1) - share * tall).argmin())
        for name, share in heights.items()
    }
    template = TemplateMesh(
        vertices=vertices,
        faces=faces,
        face_parts=np.zeros(len(faces), dtype=np.uint8),
        part_names=("torso", "upper_leg"),
        mirror=np.arange(len(vertices), dtype=np.int32),
        landmarks=MappingProxyType(
            {name: Landmark(face, (1 / 3, 1 / 3, 1 / 3)) for name, face in nearest.items()}
        ),
    )
    return Body(template, vertices, "male")


def mask(*args, **options):
    picture = Image.open(io.BytesIO(render_png(*args, silhouette=True, **options)))
    assert picture.mode == "L"
    pixels = np.asarray(picture)
    assert set(np.unique(pixels)) == {0, 255}
    return pixels == 255


def extent(pixels):
    """First and last column, first and last row; the last ones are the first ones outside."""
    columns, rows = np.flatnonzero(pixels.any(axis=0)), np.flatnonzero(pixels.any(axis=1))
    return np.array([columns[0], columns[-1] + 1, rows[0], rows[-1] + 1])


@pytest.mark.parametrize("camera", CAMERAS, ids=str)
@pytest.mark.parametrize("side", ["front", "profile"])
def test_the_outline_lies_where_the_camera_says_to_a_pixel(body, side, camera):
    found = extent(mask(body, side, camera=camera))
    points = project(body.vertices, side, camera=camera).pixels(body.vertices)
    low, high = points.min(axis=0), points.max(axis=0)
    np.testing.assert_allclose(found, [low[0], high[0], low[1], high[1]], atol=1)


@pytest.mark.parametrize("camera", CAMERAS, ids=str)
def test_the_whole_body_is_in_the_frame_with_a_margin(body, camera):
    width, height = 300, 600
    for side in ("front", "profile"):
        first, last, top, bottom = extent(mask(body, side, camera=camera, size=(width, height)))
        assert first >= MARGIN * width - 1
        assert last <= (1 - MARGIN) * width + 1
        assert top >= MARGIN * height - 1
        assert bottom <= (1 - MARGIN) * height + 1


def test_a_box_is_as_wide_and_as_tall_as_similar_triangles_say():
    wide, tall, deep = 0.5, 1.6, 0.3
    box = body_of(trimesh.creation.box((wide, tall, deep)))
    camera = Camera(distance=2.5, height=0.7)
    scale = project(box.vertices, "front", camera=camera).focal
    assert scale == project(box.vertices, "profile", camera=camera).focal
    for side, across, depth in (("front", wide, deep), ("profile", deep, wide)):
        first, last, top, bottom = extent(mask(box, side, camera=camera))
        near = camera.distance - depth / 2
        assert last - first == pytest.approx(scale * across / near, abs=1)
        assert bottom - top == pytest.approx(scale * tall / near, abs=1)


def test_a_balls_outline_is_an_ellipse_of_the_area_that_perspective_gives():
    """A ball of radius r whose middle is seen at an angle shows a conic; level, it is a circle."""
    radius = 0.5
    ball = body_of(trimesh.creation.icosphere(subdivisions=5, radius=radius))
    camera = Camera(distance=2.0, height=radius)
    pixels = mask(ball, "front", camera=camera)
    focal = project(ball.vertices, "front", camera=camera).focal
    seen = focal * radius / np.sqrt(camera.distance**2 - radius**2)
    assert pixels.sum() == pytest.approx(np.pi * seen**2, rel=5e-3)
    first, last, top, bottom = extent(pixels)
    assert last - first == pytest.approx(2 * seen, abs=1.5)
    assert bottom - top == pytest.approx(2 * seen, abs=1.5)


def test_the_person_in_profile_faces_the_pictures_right(body):
    """Toes point where the person faces: there is more foot in front of the ankle."""
    for facing, sign in (("right", 1), ("left", -1)):
        projection = project(body.vertices, "profile", facing=facing)
        toe = body.template.landmark_points(body.vertices, "toe_tip_left")
        heel = body.template.landmark_points(body.vertices, "heel_left")
        column = projection.pixels(np.stack([toe, heel]))[:, 0]
        assert sign * (column[0] - column[1]) > 100


def test_facing_left_is_the_mirror_of_facing_right_for_a_body_of_two_equal_sides(body):
    vertices = (body.vertices + body.vertices[body.template.mirror] * (-1, 1, 1)) / 2
    even = Body(body.template, vertices, "female")
    right, left = (mask(even, "profile", facing=facing) for facing in ("right", "left"))
    assert (right == left[:, ::-1]).mean() > 0.9999
    front = mask(even, "front")
    assert (front == front[:, ::-1]).mean() > 0.9999


def test_the_front_picture_shows_the_persons_left_at_its_right(body):
    points = body.template.landmark_points(body.vertices, "acromion_left")[None]
    assert project(body.vertices, "front").pixels(points)[0, 0] > 300


def test_the_picture_is_a_picture(body):
    picture = Image.open(io.BytesIO(render_png(body, "front")))
    assert (picture.mode, picture.size, picture.format) == ("RGB", (600, 1200), "PNG")
    pixels = np.asarray(picture).astype(int)
    shape = mask(body, "front")
    assert (pixels[:20] == BACKDROP).all()
    # The body stands out from its backdrop, and its form from itself.
    assert np.abs(pixels[shape] - BACKDROP).max(axis=1).min() > 10
    assert pixels[shape].std(axis=0).min() > 20
    # Its edge is smooth: no pixel of the outline jumps from backdrop to skin all at once.
    row = pixels[600, :, 0]
    assert len(np.unique(row)) > 30


def test_the_same_body_gives_the_same_bytes(body):
    assert render_png(body, "profile") == render_png(body, "profile")
    assert render_png(body, "front", silhouette=True) == render_png(body, "front", silhouette=True)


def test_a_picture_larger_than_any_before_is_drawn_and_so_is_the_next_small_one(body):
    small = mask(body, "front", size=(200, 400))
    large = mask(body, "front", size=(1500, 3000))
    assert (mask(body, "front", size=(200, 400)) == small).all()
    assert large.mean() == pytest.approx(small.mean(), abs=0.01)


def test_a_photograph_knows_how_far_away_everything_is():
    """A box shows the camera one flat side: each of its points is as deep as that side."""
    box = body_of(trimesh.creation.box((0.5, 1.6, 0.3)))
    projection = project(box.vertices, "front", size=(150, 300), camera=Camera(2.5, 0.7))
    painted = in_underwear(dress(box))
    depths = photograph(painted, projection, (150, 300)).depths
    assert depths.shape == (300 * FINENESS, 150 * FINENESS)
    seen = np.isfinite(depths)
    # The outline as at full size, to within the pixels that it crosses.
    outline = mask(box, "front", size=(150, 300), camera=Camera(2.5, 0.7))
    assert (seen[::FINENESS, ::FINENESS] == outline).mean() > 0.98
    np.testing.assert_allclose(depths[seen], 2.5 - 0.15, atol=1e-4)


def test_a_surface_may_have_a_colour_for_each_point():
    box = body_of(trimesh.creation.box((0.5, 1.6, 0.3)))
    dressed = dress(box)
    low = dressed.positions[:, 1] < 0.8
    red, blue = (0.9, 0.2, 0.2), (0.2, 0.2, 0.9)
    colours = np.where(low[:, None], red, blue)
    faces = np.concatenate([dressed.skin, dressed.garment])
    painted = Painted(dressed.positions, dressed.normals, [(faces, colours)])
    projection = project(box.vertices, "front", size=(150, 300))
    pixels = np.asarray(photograph(painted, projection, (150, 300)).picture).astype(int)
    top, bottom = pixels[30, 75], pixels[270, 75]
    assert top[2] > top[0] + 50
    assert bottom[0] > bottom[2] + 50


@pytest.mark.parametrize(
    "values", [(0.99, 0.9), (10.1, 0.9), (3, -0.1), (3, 3.1), (float("nan"), 0.9)], ids=str
)
def test_a_camera_from_where_nobody_takes_a_photo_is_refused(values):
    with pytest.raises(ValueError, match=r"camera (distance|height) .* m is not from"):
        Camera(*values)
