"""People drawn anew: none of the population's own, and the form of a back as it was planted."""

import numpy as np
import pytest

from model.template_mesh import load_template_mesh
from model.training.fresh_people import back_of, write_stance_report
from model.training.population import load_population


def test_the_populations_own_people_are_not_new(tmp_path) -> None:
    with pytest.raises(ValueError, match="itself is of seed"):
        write_stance_report(load_population().seed, tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_back_is_as_round_and_as_hollow_as_it_was_made() -> None:
    template = load_template_mesh()
    before = template.vertices
    neck, waist = (template.landmark_points(before, n) for n in ("cervicale", "waist_back"))
    heights = before[:, 1]
    rounder = before.copy()
    between = (heights > waist[1] + 0.08) & (heights < neck[1] - 0.08)
    rounder[between, 2] -= 0.02
    grown = back_of(template, rounder) - back_of(template, before)
    upright = (neck - waist)[1] / np.linalg.norm((neck - waist)[1:])
    assert grown[0] == pytest.approx(0.02 * upright, abs=0.001)
    hollower = before.copy()
    hollower[np.abs(heights - waist[1]) < 0.03, 2] += 0.02
    assert back_of(template, hollower)[1] - back_of(template, before)[1] > 0.018
