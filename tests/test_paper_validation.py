"""The paper's validation on models whose errors are known."""

from dataclasses import replace

import numpy as np
import pytest

from model.anthropometry import TAKEN, measure_batch
from model.shape_basis import load_shape_basis
from model.template_mesh import load_template_mesh
from model.training.feature_selection import TABLE_4, candidates, select
from model.training.paper_models import PaperSpace
from model.training.paper_validation import (
    ALLOWED,
    PAPER_TDE,
    evaluated,
    held_out,
    learned_from,
    people_errors,
    shape_errors,
    small_and_large,
    subsets,
    total_distance_error,
)
from model.training.population import load_population

NAMES = candidates(TAKEN)


@pytest.fixture(scope="module")
def space():
    return PaperSpace.of(load_shape_basis(), load_template_mesh())


@pytest.fixture(scope="module")
def population():
    return load_population()


@pytest.fixture(scope="module")
def bodies(space, population):
    """Three women's coordinates, and what they measure."""
    coordinates = space.coordinates(population.coefficients[held_out(population, "female")[:3]])
    return coordinates, measure_batch(space.template, space.vertices(coordinates))


def test_subsets_are_the_papers() -> None:
    values = np.random.default_rng(0).uniform(0.5, 1.0, size=(50, len(NAMES)))
    selection = select(NAMES, values)
    seven = selection.selected
    other = replace(selection, selected=(seven[1], seven[4], seven[5]))
    chosen = subsets({"female": selection, "male": other}, "female")
    assert list(chosen) == [
        *(f"top {count}" for count in (2, 4, 6, 8, 10)),
        "selected 3",
        "selected 7",
        "Table 4",
    ]
    assert chosen["top 4"] == selection.top[:4]
    assert chosen["selected 3"] == (seven[1], seven[4], seven[5])
    assert chosen["selected 7"] == seven
    assert set(chosen["Table 4"]) <= set(TABLE_4["female"])


def test_a_small_and_a_large_body_are_held_out(population) -> None:
    values = np.random.default_rng(1).uniform(40, 150, size=(len(population.sexes), len(TAKEN)))
    weights = values[:, TAKEN.index("weight")]
    for sex in ("female", "male"):
        small, large = small_and_large(population, values, sex)
        assert {small, large} <= set(held_out(population, sex))
        lighter = (weights[held_out(population, sex)] < weights[small]).mean()
        heavier = (weights[held_out(population, sex)] > weights[large]).mean()
        assert (lighter, heavier) == pytest.approx((0.03, 0.03), abs=0.01)


def test_nothing_is_both_learned_from_and_held_out(population) -> None:
    parts = [
        part(population, sex) for sex in ("female", "male") for part in (learned_from, held_out)
    ]
    together = np.concatenate(parts)
    assert np.sort(together).tolist() == list(range(len(population.sexes)))


def test_shape_errors_are_those_of_the_vertices(space, bodies) -> None:
    coordinates, _ = bodies
    estimated = coordinates + np.random.default_rng(2).normal(size=coordinates.shape) * 0.02
    errors = shape_errors(space, estimated, coordinates)
    apart = space.vertices(estimated) - space.vertices(coordinates)
    far = np.linalg.norm(apart, axis=2)
    assert errors.squared == pytest.approx((apart**2).mean(axis=(1, 2)), rel=1e-4)
    assert errors.mean == pytest.approx(far.mean(axis=1), rel=1e-4)
    assert errors.largest == pytest.approx(far.max(axis=1), rel=1e-3)
    assert (errors.shifted < errors.mean + 1e-3).all()
    # Coordinates are such that squared distances are theirs: but for the mean's, all are.
    squared = ((estimated - coordinates)[:, 1:] ** 2).sum(axis=1) / apart[0].size
    exact = shape_errors(space, np.c_[np.ones(3), estimated[:, 1:]], coordinates)
    assert exact.squared == pytest.approx(squared, rel=1e-3)


def test_many_bodies_are_reckoned_as_few_are(space, bodies) -> None:
    coordinates, _ = bodies
    many = np.repeat(coordinates, 30, axis=0)
    moved = many + np.random.default_rng(3).normal(size=many.shape) * 0.01
    together = shape_errors(space, moved, many)
    alone = shape_errors(space, moved[70:71], many[70:71])
    assert together.mean.shape == (90,)
    assert together.mean[70] == pytest.approx(alone.mean[0], rel=1e-5)


def test_a_body_moved_as_a_whole_has_the_right_shape(space, bodies) -> None:
    """In a space whose first coordinate moves bodies to the right."""
    coordinates, _ = bodies
    rows = space.rows.copy()
    rows[0] = np.tile([0.03, 0, 0], rows.shape[1] // 3)
    errors = shape_errors(
        replace(space, rows=rows), coordinates + np.eye(1, coordinates.shape[1]), coordinates
    )
    assert errors.mean == pytest.approx(0.03, rel=1e-5)
    assert errors.largest == pytest.approx(0.03, rel=1e-5)
    assert errors.shifted == pytest.approx(0, abs=1e-5)


def test_the_total_distance_error_is_a_sum() -> None:
    missed = np.zeros((2, len(TAKEN)))
    missed[0, TAKEN.index("stature")] = -0.02
    missed[0, TAKEN.index("hip_girth")] = 0.03
    missed[1, TAKEN.index("weight")] = 5
    assert total_distance_error(missed, ("stature", "hip_girth")) == pytest.approx([0.05, 0])


@pytest.mark.parametrize("name", ["weight", "shoe_size"])
def test_only_lengths_are_summed(name) -> None:
    with pytest.raises(ValueError, match=f"{name} is not a length"):
        total_distance_error(np.zeros((1, len(TAKEN))), ("stature", name))


def test_the_evaluation_enters_eight_of_ten() -> None:
    for sex in ("female", "male"):
        entered, summed = evaluated(sex)
        assert set(entered) <= set(summed) <= set(ALLOWED) & set(TAKEN)
        assert set(TABLE_4[sex]) <= set(entered)
        assert len(entered) <= 8
        assert len(summed) <= 10
    assert sorted(PAPER_TDE)[0] == 0.27
    assert sorted(PAPER_TDE)[-1] == 0.84


def test_a_perfect_model_errs_by_what_people_misread(space, bodies) -> None:
    coordinates, values = bodies
    _, summed = evaluated("female")

    def perfect(rows):
        return coordinates

    exact = people_errors(space, perfect, values, "female").total
    assert exact == pytest.approx(0, abs=1e-4)
    expert = people_errors(space, perfect, values, "female", tape=1, seed=4).total
    alone = people_errors(space, perfect, values, "female", tape=4, seed=4).total
    assert alone == pytest.approx(4 * expert, abs=1e-4)
    usual = np.sqrt(2 / np.pi) * sum(ALLOWED[name] for name in summed)
    assert 0.4 * usual < expert.mean() < 1.6 * usual


def test_the_model_is_told_what_was_entered(space, bodies) -> None:
    coordinates, values = bodies
    told = []

    def listening(rows):
        told.append(rows)
        return coordinates

    unknown = np.where(np.array(TAKEN) == "waist_girth", np.nan, values)
    errors = people_errors(space, listening, unknown, "female")
    entered, summed = evaluated("female")
    known = [name for name, column in zip(TAKEN, told[0].T, strict=True) if not np.isnan(column[0])]
    assert set(known) == set(entered) - {"waist_girth"}
    sums = [np.abs(errors.missed[:, TAKEN.index(n)]) for n in summed if n != "waist_girth"]
    assert errors.total == pytest.approx(np.sum(sums, axis=0))
