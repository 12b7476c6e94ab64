"""Fitting drawn people, on shapes made here: stretches and bulges of the template.

Anny itself is not needed; what is planted must be found again.
"""

from dataclasses import replace

import numpy as np
import pytest

from model.anthropometry import read_tapes
from model.template_mesh import load_template_mesh
from model.training.anny_population import ANCESTRIES, ANCHORS, PHENOTYPES, BlendShapes
from model.training.person_fit import (
    LOCAL_END,
    SLIDER_ENDS,
    draw_sliders,
    fit_body,
    local_deviations,
    targets,
)
from model.training.stance import in_one_stance
from model.training.survey import SURVEY_TAPES, load_statistics

VARIATIONS = (*ANCESTRIES, *(name for names in ANCHORS.values() for name in names))


@pytest.fixture(scope="module")
def shapes() -> BlendShapes:
    template = load_template_mesh()
    rest = template.vertices
    x, y, z = rest.T
    zero = np.zeros_like(x)
    taller = np.stack([zero, 0.2 * y, zero], axis=1)
    wider = np.stack([0.3 * x, zero, 0.3 * z], axis=1)
    masks = np.zeros((2, len(VARIATIONS)), dtype=bool)
    masks[0, VARIATIONS.index("maxheight")] = True
    masks[1, VARIATIONS.index("maxweight")] = True
    level = np.abs(rest[:, [1]] - 1.0) < 0.15
    belly = np.stack([zero, zero, 0.05 * np.maximum(z, 0)], axis=1) * level
    return BlendShapes(
        rest=rest,
        phenotype_shapes=np.stack([taller, wider]).astype(np.float32),
        phenotype_mask=masks,
        variations=VARIATIONS,
        local_shapes=np.stack([belly, -belly])[None].astype(np.float32),
        local_names=("belly",),
        faces=template.faces,
        parts=np.zeros(len(rest), dtype=np.uint8),
        part_names=("all",),
    )


def sliders(**changed: float) -> dict[str, float]:
    return dict.fromkeys((*ANCHORS, *ANCESTRIES), 0.5) | changed


def test_sliders_weigh_their_shapes_piecewise_linearly(shapes: BlendShapes) -> None:
    assert shapes.weights(sliders(height=0.3, weight=0.5))[0] == pytest.approx([0.3, 0.0])
    assert shapes.weights(sliders(height=1.0, weight=0.75))[0] == pytest.approx([1.0, 0.5])
    beyond = shapes.weights(sliders(height=1.2, weight=1.1))[0]
    assert beyond == pytest.approx([1.2, 1.2])


@pytest.mark.parametrize("name", PHENOTYPES)
def test_slopes_are_difference_quotients(shapes: BlendShapes, name: str) -> None:
    at = sliders(height=0.31, weight=0.62)
    _, slopes = shapes.weights(at)
    step = 1e-6
    forth, back = (shapes.weights(at | {name: at[name] + s})[0] for s in (step, -step))
    assert slopes[name] == pytest.approx((forth - back) / (2 * step), abs=1e-6)


def test_a_planted_body_is_found_again(shapes: BlendShapes) -> None:
    template = load_template_mesh()
    weights, _ = shapes.weights(sliders(height=0.7, weight=0.8))
    planted = shapes.rest + np.tensordot(weights, shapes.phenotype_shapes, 1)
    planted = in_one_stance(template, planted + 0.4 * shapes.local_shapes[0, 0])
    taken = read_tapes(template, planted[None], list(SURVEY_TAPES.values()))[0]
    asked = taken / (targets(np.ones(len(taken))))
    draw = draw_sliders("female", asked, local_deviations(shapes), np.random.default_rng(0))
    fitted = fit_body(shapes, template, asked, replace(draw, spread=draw.spread * 100))
    assert fitted.taken == pytest.approx(taken, rel=2e-3)
    assert fitted.vertices[:, 1].min() == 0
    assert np.ptp(fitted.vertices[:, 1]) == pytest.approx(np.ptp(planted[:, 1]), abs=1e-3)


def test_a_fit_never_leaves_its_bounds(shapes: BlendShapes) -> None:
    """Asked for the impossible, every slider stays within its ends."""
    asked = np.exp(load_statistics("female").means) * 3
    draw = draw_sliders("female", asked, local_deviations(shapes), np.random.default_rng(0))
    fitted = fit_body(shapes, load_template_mesh(), asked, draw)
    ends = np.array([SLIDER_ENDS[name] for name in PHENOTYPES])
    assert (fitted.parameters[: len(ends)] >= ends[:, 0] - 1e-9).all()
    assert (fitted.parameters[: len(ends)] <= ends[:, 1] + 1e-9).all()
    assert (fitted.parameters[len(ends) :] >= -1e-9).all()
    assert (fitted.parameters[len(ends) :] <= LOCAL_END + 1e-9).all()


def test_draws_differ_between_people_and_repeat_with_the_seed() -> None:
    asked = np.exp(load_statistics("male").means)
    first, again, other = (
        draw_sliders("male", asked, np.full(2, 0.2), np.random.default_rng(seed))
        for seed in (1, 1, 2)
    )
    assert (first.start == again.start).all()
    assert (first.start != other.start).any()
    assert first.fixed["gender"] == 0
    assert ((first.start >= first.low) & (first.start <= first.high)).all()
