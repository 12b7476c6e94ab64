from dataclasses import replace

import numpy as np
import potpourri3d
import pytest

from model.geodesics import Bundle
from model.shape_basis import load_shape_basis
from model.template_mesh import Landmark, TemplateMesh, load_template_mesh
from model.training.population import load_population
from model.training.strips import TOLERANCE, find_strips

WAYS = [("acromion_left", "radiale_left"), ("cervicale", "waist_back"), ("abdomen_back", "crotch")]


@pytest.fixture(scope="module")
def sheet() -> TemplateMesh:
    """A flat sheet of 12 by 12 squares, cut crosswise and not evenly."""
    random = np.random.default_rng(5)
    across, up = np.meshgrid(np.arange(13.0), np.arange(13.0))
    inner = (across % 12 > 0) & (up % 12 > 0)
    across += inner * random.uniform(-0.3, 0.3, across.shape)
    up += inner * random.uniform(-0.3, 0.3, up.shape)
    vertices = np.stack([across, up, np.zeros_like(up)], axis=2).reshape(-1, 3) / 100
    corner = (np.arange(12)[:, None] * 13 + np.arange(12)).ravel()
    faces = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + 14], axis=1),
            np.stack([corner, corner + 14, corner + 13], axis=1),
        ]
    )
    # Closed by a single vertex far behind, over whose edges no way goes.
    border = [*range(13), *range(25, 169, 13), *range(167, 155, -1), *range(143, 0, -13)]
    back = [[b, a, 169] for a, b in zip(border, border[1:] + border[:1], strict=True)]
    third = (1 / 3, 1 / 3, 1 / 3)
    return TemplateMesh(
        vertices=np.vstack([vertices, [[0.06, 0.06, -9.0]]]),
        faces=np.concatenate([faces, back]).astype(np.int32),
        face_parts=np.zeros(len(faces) + len(back), dtype=np.uint8),
        part_names=("sheet",),
        mirror=np.arange(170, dtype=np.int32),
        landmarks={
            "here": Landmark(15, third),
            "beside": Landmark(15, (0.2, 0.3, 0.5)),
            "there": Landmark(270, third),
            "corner": Landmark(130, (1.0, 0.0, 0.0)),
        },
    )


@pytest.mark.parametrize("way", [("here", "there"), ("there", "here"), ("corner", "here")])
def test_on_a_flat_sheet_ways_are_straight(sheet: TemplateMesh, way: tuple[str, str]) -> None:
    strips = find_strips(sheet, sheet.vertices[None], [way])
    start, stop = (sheet.landmark_points(sheet.vertices, name) for name in way)
    length = Bundle([strips[way]]).lengths(sheet.vertices[None])[0, 0]
    assert length == pytest.approx(np.linalg.norm(stop - start), abs=1e-12)


def test_landmarks_on_one_triangle_are_refused_by_name(sheet: TemplateMesh) -> None:
    with pytest.raises(ValueError, match="here and beside lie on one triangle"):
        find_strips(sheet, sheet.vertices[None], [("here", "beside")])


def test_on_bodies_that_were_seen_no_local_geodesic_is_much_shorter() -> None:
    """Against another library: potpourri3d pulls paths straight by flipping edges."""
    template = replace(load_template_mesh(), strips={})
    bodies = load_shape_basis().vertices(load_population().coefficients[[3, 1500, 3000]])
    strips = find_strips(template, bodies, WAYS)
    lengths = Bundle([strips[way] for way in WAYS]).lengths(bodies)
    for body, taken in zip(bodies, lengths, strict=True):
        solver = potpourri3d.EdgeFlipGeodesicSolver(body, template.faces)
        for way, length in zip(WAYS, taken, strict=True):
            start, stop = (
                int(template.faces[template.landmarks[name].face][corner])
                for name in way
                for corner in [int(np.argmax(template.landmarks[name].weights))]
            )
            path = solver.find_geodesic_path(v_start=start, v_end=stop)
            local = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
            assert length < local + TOLERANCE
            assert length == pytest.approx(local, rel=0.01)
