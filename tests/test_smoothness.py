"""A lump and a fold are found where they were put; a body's own size is neither."""

import numpy as np
import pytest

from model.geometry import Floats
from model.template_mesh import load_template_mesh
from model.training.smoothness import draw_worst, fitted_bodies, new_people, smoothness

TEMPLATE = load_template_mesh()


def with_a_lump(height: float) -> tuple[Floats, int]:
    """The template with a bump of 2 cm across on the belly, and the vertex in its middle."""
    navel = TEMPLATE.landmark_points(TEMPLATE.vertices, "omphalion")
    vertices = TEMPLATE.vertices.copy()
    away = np.linalg.norm(vertices - navel, axis=1)
    vertices[:, 2] += height * np.exp(-((away / 0.02) ** 2))
    return vertices, int(away.argmin())


def test_the_template_is_as_smooth_as_itself_at_any_size() -> None:
    found = smoothness(TEMPLATE, np.stack([TEMPLATE.vertices, 1.2 * TEMPLATE.vertices]))
    assert found.bending == pytest.approx(0, abs=1e-6)
    assert found.lumps == pytest.approx(0, abs=1e-6)
    assert found.folds.tolist() == [0, 0]


def test_a_lump_is_found_in_its_place_and_grows() -> None:
    low, middle = with_a_lump(0.01)
    high, _ = with_a_lump(0.03)
    found = smoothness(TEMPLATE, np.stack([low, high]))
    assert found.lumps[1] > 1.5 * found.lumps[0] > 0.1
    far = np.linalg.norm(TEMPLATE.vertices[found.places] - TEMPLATE.vertices[middle], axis=1)
    assert far.max() < 0.05


def test_a_fold_is_counted() -> None:
    vertices = TEMPLATE.vertices.copy()
    face = TEMPLATE.landmarks["omphalion"].face
    corner = TEMPLATE.faces[face, 0]
    vertices[corner] = 2 * vertices[TEMPLATE.faces[face, 1:]].mean(axis=0) - vertices[corner]
    assert smoothness(TEMPLATE, vertices[None]).folds[0] > 0


def test_new_people_are_fitted_and_drawn() -> None:
    people = new_people(4, seed=5)
    assert [kind for kind, _ in people] == ["female"] * 2 + ["male"] * 2
    bodies = fitted_bodies(people)
    assert bodies[:, :, 1].max(axis=1) == pytest.approx(
        [asked["stature"] for _, asked in people], abs=0.001
    )
    sheet = draw_worst(TEMPLATE, {"fitted": bodies[:2]})
    assert np.ptp(np.asarray(sheet)[:, :, 0]) > 100
