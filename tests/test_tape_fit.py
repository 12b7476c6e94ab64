"""The tape fit: what is asked is measured, and what cannot be is told."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from model.anthropometry import TAKEN, TAPES, measure, measure_batch
from model.estimators import Estimator, load_estimators
from model.geometry import Floats, Integers
from model.measurements import BODY_KINDS, MEASUREMENTS, MeasurementSet
from model.tape_fit import TapeFit, fit_to_tape, furthest
from model.tape_pieces import TapePieces
from model.training.population import load_population
from model.training.survey import SEXES
from model.training.train import reach_of, spread_of

EIGHT = (
    "stature",
    "weight",
    "bust_girth",
    "hip_girth",
    "neck_girth",
    "thigh_girth",
    "abdomen_girth",
    "inseam_height",
)
COUNT = 12
"""Of held-out bodies of each kind."""


def rows_of(kind: str) -> Integers:
    """Bodies of the population that no estimator saw, evenly through it: (COUNT,)."""
    population = load_population()
    rows = np.flatnonzero(population.held_out)
    if kind != "neutral":
        rows = rows[population.sexes[rows] == SEXES.index(kind)]
    return rows[:: len(rows) // COUNT][:COUNT]


@lru_cache
def held_out(kind: str) -> tuple[Floats, list[MeasurementSet]]:
    """Those bodies, and what they measure."""
    estimator = load_estimators()["neutral"]
    vertices = estimator.basis.vertices(load_population().coefficients[rows_of(kind)])
    values = measure_batch(estimator.template, vertices)
    return vertices, [MeasurementSet(dict(zip(TAKEN, row, strict=True))) for row in values]


def only(values: MeasurementSet, names: tuple[str, ...]) -> MeasurementSet:
    return MeasurementSet({name: values[name] for name in names})


def unmet(fit: TapeFit) -> dict[str, float]:
    """Misses of more than a millimetre or a tenth of a kilogram."""
    allowed = {"m": 0.001, "kg": 0.1}
    return {
        name: miss
        for name, miss in fit.misses.items()
        if abs(miss) > allowed[MEASUREMENTS[name].unit]
    }


def apart(one: Floats, other: Floats) -> float:
    """Mean distance of vertices, in metres."""
    return float(np.linalg.norm(one - other, axis=-1).mean())


@pytest.fixture(scope="module", params=BODY_KINDS)
def kind(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture(scope="module")
def estimator(kind: str) -> Estimator:
    return load_estimators()[kind]


def test_all_that_planted_bodies_measure_is_met_at_no_cost_in_likeness() -> None:
    fitted, linear = [], []
    for kind, estimator in load_estimators().items():
        for vertices, values in zip(*held_out(kind), strict=True):
            fit = fit_to_tape(estimator, values)
            assert unmet(fit) == {}
            fitted.append(apart(fit.body.vertices, vertices))
            linear.append(apart(estimator.estimate(values).vertices, vertices))
    assert np.mean(fitted) < 1.03 * np.mean(linear)


@pytest.mark.parametrize("names", [("stature",), ("stature", "weight"), EIGHT], ids=len)
def test_any_values_of_a_planted_body_are_met(kind, estimator, names) -> None:
    for values in held_out(kind)[1]:
        asked = only(values, names)
        fit = fit_to_tape(estimator, asked)
        taken = measure(fit.body).values
        assert unmet(fit) == {}
        assert fit.body.kind == kind
        assert fit.misses == pytest.approx({n: taken[n] - asked[n] for n in names}, abs=1e-6)
        assert fit.body.vertices[:, 1].min() == 0


def test_the_linear_estimate_misses_what_the_fit_meets(estimator) -> None:
    """So that the tests above cannot pass by doing nothing."""
    asked = only(held_out(estimator.kind)[1][0], EIGHT)
    taken = measure(estimator.estimate(asked)).values
    assert max(abs(taken[name] - asked[name]) for name in EIGHT) > 0.002
    assert fit_to_tape(estimator, asked).rounds > 0


@pytest.mark.parametrize("again", [EIGHT, TAKEN], ids=["the same values", "all values"])
def test_a_fit_of_what_a_fit_measures_is_the_same_body(estimator, again) -> None:
    """The likeliest body with some values is nearly the likeliest with all that it measures."""
    asked = only(held_out(estimator.kind)[1][3], EIGHT)
    once = fit_to_tape(estimator, asked)
    twice = fit_to_tape(estimator, only(measure(once.body).values, again))
    assert apart(once.body.vertices, twice.body.vertices) < 0.002
    assert twice.distance == pytest.approx(once.distance, rel=0.2, abs=0.2)


def test_a_fit_is_the_same_each_time(estimator) -> None:
    asked = only(held_out(estimator.kind)[1][1], EIGHT)
    first, second = (fit_to_tape(estimator, asked) for _ in range(2))
    assert (first.body.vertices == second.body.vertices).all()
    assert first.misses == second.misses


def test_of_bodies_with_the_values_it_is_the_nearest_to_the_mean(estimator) -> None:
    """The held-out body has the values too, and lies further out."""
    people = held_out(estimator.kind)[1]
    fits = [fit_to_tape(estimator, only(values, EIGHT)) for values in people]
    for fit, row in zip(fits, rows_of(estimator.kind), strict=True):
        apart = load_population().coefficients[row] - estimator.mean
        planted = float((np.linalg.solve(estimator.spread, apart) ** 2).sum())
        assert 0 < fit.distance < planted
        assert fit.distance <= fit.furthest * (1 + 1e-9)


CONTRADICTORY = {
    "a huge bust over a tiny underbust": {
        "stature": 1.7,
        "bust_girth": 1.4,
        "underbust_girth": 0.7,
    },
    "very heavy and very thin": {"stature": 1.6, "weight": 160.0, "waist_girth": 0.6},
    "an arm that is not the sum of its parts": {
        "stature": 1.7,
        "arm_length": 0.65,
        "upper_arm_length": 0.30,
        "lower_arm_length": 0.20,
    },
}


@pytest.mark.parametrize("values", CONTRADICTORY.values(), ids=CONTRADICTORY)
def test_what_contradicts_is_told_and_the_body_stays_a_body(estimator, values) -> None:
    fit = fit_to_tape(estimator, MeasurementSet(values))
    taken = measure(fit.body).values
    assert unmet(fit)
    assert fit.misses == pytest.approx({n: taken[n] - values[n] for n in values}, abs=1e-6)
    assert fit.distance <= fit.furthest * (1 + 1e-9)


def test_stature_gives_way_last() -> None:
    estimator = load_estimators()["female"]
    values = {"stature": 1.6, "weight": 160.0, "waist_girth": 0.6}
    fit = fit_to_tape(estimator, MeasurementSet(values))
    assert abs(fit.misses["waist_girth"]) > 0.1
    assert abs(fit.misses["stature"]) < 0.005


def test_what_is_not_asked_is_as_the_law_of_people_expects(estimator) -> None:
    names = ("calf_girth", "mid_thigh_girth", "wrist_girth", "underbust_girth")
    scores = []
    for values in held_out(estimator.kind)[1]:
        asked = only(values, EIGHT)
        taken = measure(fit_to_tape(estimator, asked).body).values
        given = estimator.law.given(asked)
        scores.append([abs(given.score(name, taken[name])) for name in names])
    # People's own values are two thirds of a deviation from what is expected, in the middle.
    assert dict(zip(names, np.median(scores, axis=0), strict=True)) == pytest.approx(
        dict.fromkeys(names, 0), abs=0.5
    )
    assert np.max(scores) < 2


def test_an_impossible_value_leaves_the_possible_ones_nearly_met() -> None:
    estimator = load_estimators()["female"]
    possible = {"stature": 1.7, "head_girth": 0.56, "calf_girth": 0.36}
    arms = {"arm_length": 0.57, "upper_arm_length": 0.33, "lower_arm_length": 0.25}
    fit = fit_to_tape(estimator, MeasurementSet(possible | arms))
    assert {name: abs(fit.misses[name]) < 0.001 for name in possible} == dict.fromkeys(
        possible, True
    )
    # A centimetre too much is shared by the three that contradict each other.
    assert all(0.001 < abs(fit.misses[name]) < 0.008 for name in arms)


def test_the_corners_of_all_ranges_make_bodies(estimator) -> None:
    random = np.random.default_rng(5)
    for _ in range(6):
        ends = random.integers(0, 2, len(TAKEN))
        values = {name: estimator.limits[name][end] for name, end in zip(TAKEN, ends, strict=True)}
        fit = fit_to_tape(estimator, MeasurementSet(values))
        assert unmet(fit)
        assert fit.distance <= fit.furthest * (1 + 1e-9)
        measure(fit.body)


def test_nothing_asked_is_refused() -> None:
    with pytest.raises(ValueError, match="one measurement at least"):
        fit_to_tape(load_estimators()["male"], MeasurementSet({}))


def test_more_values_may_lie_further_out() -> None:
    estimator = load_estimators()["female"]
    reaches = [furthest(estimator, count) for count in range(1, 42)]
    assert reaches == sorted(reaches)
    assert furthest(replace(estimator, reach=1.0), 1) == pytest.approx(10.83, abs=0.01)


def test_slopes_by_coefficients_are_difference_quotients() -> None:
    """Every plane of every girth, and all other tapes, chained through the shape basis."""
    estimator, population = load_estimators()["neutral"], load_population()
    pieces = TapePieces(estimator.template, [TAPES[name] for name in TAKEN])
    random = np.random.default_rng(0)
    for row in (100, 2000):
        at = population.coefficients[row]
        direction = random.normal(size=len(at))
        body = estimator.body(at).vertices
        reading = pieces.read(body, with_slopes=True)
        every = np.arange(len(pieces.owner))
        slopes = estimator.basis.by_coefficients(pieces.gradients(body, reading, every))
        step = 1e-3
        forth, back = (
            pieces.read(estimator.body(at + sign * step * direction).vertices).values
            for sign in (1, -1)
        )
        quotients = (forth - back) / (2 * step)
        off = np.abs(slopes @ direction - quotients) > 2e-3 * np.abs(quotients) + 2e-4
        # A corner of a hull may come or go within the step.
        assert off.mean() < 0.05


def test_pieces_read_as_the_tapes_do() -> None:
    estimator = load_estimators()["male"]
    body = estimator.estimate(MeasurementSet({"stature": 1.8}))
    pieces = TapePieces(estimator.template, [TAPES[name] for name in TAKEN])
    for slopes in (True, False):
        reading = pieces.read(body.vertices, with_slopes=slopes)
        taken = dict(zip(TAKEN, reading.values[reading.chosen], strict=True))
        assert taken == pytest.approx(dict(measure(body).values))
    assert (pieces.owner[reading.chosen] == np.arange(len(TAKEN))).all()


def test_a_normal_law_reaches_as_far_as_it_says() -> None:
    random = np.random.default_rng(0)
    law = random.normal(size=(10, 10))
    normal = random.normal(size=(4000, 10)) @ law
    assert reach_of(normal) == pytest.approx(1.0, abs=0.08)
    assert reach_of(np.sinh(normal)) > 1.5


def test_the_spread_of_few_bodies_is_one_too() -> None:
    few = np.random.default_rng(0).normal(size=(5, 20))
    spread = spread_of(few)
    assert spread @ spread.T == pytest.approx(np.cov(few.T), abs=1e-3)


def test_two_girths_and_a_height_do_not_explode(estimator) -> None:
    """Where they are seldom together, the rest stays what people have."""
    apart_girths = {"stature": 1.7, "bust_girth": 1.15, "underbust_girth": 0.84}
    body = fit_to_tape(estimator, MeasurementSet(apart_girths)).body
    for name, value in measure(body).values.items():
        low, high = estimator.limits[name]
        assert low < value < high, name
