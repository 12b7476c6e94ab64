from collections.abc import Mapping

import numpy as np
import pytest

from model.anthropometry import TAKEN
from model.estimators import Estimator, load_estimators
from model.measurements import BODY_KINDS, MeasurementSet
from model.plausibility import AREAS, conflicts, doubts, expected, next_measurements

KNOWN = ("stature", "weight", "bust_girth", "waist_girth", "hip_girth", "inseam_height")


@pytest.fixture(scope="module", params=BODY_KINDS)
def estimator(request) -> Estimator:
    return load_estimators()[request.param]


def middling(estimator: Estimator, known: tuple[str, ...] = KNOWN) -> dict[str, float]:
    """Someone who is in every respect as the law expects."""
    means = dict(zip(estimator.law.names, np.exp(estimator.law.means).tolist(), strict=True))
    return {name: means[name] for name in known}


def only_doubt(estimator: Estimator, values: Mapping[str, float]):
    [doubt] = doubts(estimator, MeasurementSet(values))
    return doubt


def test_nobody_as_expected_is_bothered(estimator) -> None:
    everything = MeasurementSet(middling(estimator, TAKEN))
    assert doubts(estimator, everything) == []
    for name, value in everything.items():
        said = expected(estimator, everything, name)
        assert said.low < said.middle < said.high
        assert said.middle == pytest.approx(value, rel=0.002)


def test_a_value_has_no_say_in_its_own_expectation(estimator) -> None:
    values = middling(estimator)
    other = values | {"waist_girth": 1.2}
    assert expected(estimator, MeasurementSet(values), "waist_girth") == expected(
        estimator, MeasurementSet(other), "waist_girth"
    )


@pytest.mark.parametrize(
    ("name", "factor"),
    [
        ("bust_girth", 2.54),
        ("bust_girth", 1 / 2.54),
        ("waist_girth", 0.1),
        ("waist_girth", 0.01),
        ("stature", 1 / 2.54),
        ("inseam_height", 2.54),
        ("weight", 1 / 0.45359237),
        ("weight", 0.45359237),
        ("weight", 1 / 6.35029318),
        ("weight", 14.0),
    ],
)
def test_a_mixed_up_unit_is_recognised(estimator, name, factor) -> None:
    values = middling(estimator)
    values[name] *= 1.005
    right = values[name]
    doubt = only_doubt(estimator, values | {name: right * factor})
    assert (doubt.measurement, doubt.code, doubt.meant) == (name, "unit_mix_up", None)
    assert doubt.suggestion == pytest.approx(right)
    low, high = doubt.expected
    assert low < right < high


def test_an_inseam_to_the_floor_is_recognised(estimator) -> None:
    values = middling(estimator)
    foot = middling(estimator, ("foot_height",))["foot_height"]
    # Someone whose legs are a little long, so that the height of an ankle more is too much.
    right = 1.01 * values["inseam_height"]
    doubt = only_doubt(estimator, values | {"inseam_height": right + foot})
    assert (doubt.measurement, doubt.code) == ("inseam_height", "neighbouring_definition")
    assert doubt.meant == "inside_leg_height"
    assert doubt.suggestion == pytest.approx(right, abs=0.01)


def test_an_under_bust_for_a_bust_is_recognised() -> None:
    estimator = load_estimators()["female"]
    known = (*KNOWN, "abdomen_girth", "neck_girth")
    values = middling(estimator, known)
    under = 0.97 * middling(estimator, ("underbust_girth",))["underbust_girth"]
    doubt = only_doubt(estimator, values | {"bust_girth": under})
    assert doubt.code == "neighbouring_definition"
    assert doubt.meant == "underbust_girth"
    assert doubt.suggestion is not None
    assert doubt.suggestion > under + 0.05


def test_a_value_that_is_off_is_doubted_alone(estimator) -> None:
    values = middling(estimator, TAKEN)
    doubt = only_doubt(estimator, values | {"calf_girth": 1.3 * values["calf_girth"]})
    assert (doubt.measurement, doubt.code, doubt.suggestion) == ("calf_girth", "unusual", None)
    assert doubt.conflicts


def test_values_that_contradict_each_other_are_named_together(estimator) -> None:
    values = {"stature": 1.7, "bust_girth": 1.4, "underbust_girth": 0.7}
    found = {doubt.measurement: doubt for doubt in doubts(estimator, MeasurementSet(values))}
    assert set(found) == {"bust_girth", "underbust_girth"}
    assert found["bust_girth"].conflicts[0] == "underbust_girth"
    assert found["underbust_girth"].conflicts[0] == "bust_girth"


def test_heavy_and_slight_people_are_not_bothered(estimator) -> None:
    law = estimator.law
    for index in (17.0, 40.0, 48.0):
        stature = float(np.exp(law.means[0]))
        few = MeasurementSet({"stature": stature, "weight": index * stature**2})
        assert doubts(estimator, few) == []
        girths = ("bust_girth", "waist_girth", "hip_girth", "thigh_girth")
        wide = law.given(few, wide=True)
        more = {name: wide.range(name, 0.8)[1] for name in girths}
        assert doubts(estimator, MeasurementSet(dict(few) | more)) == []
        assert doubts(estimator, MeasurementSet({"stature": stature} | more)) == []


def test_what_to_measure_next_narrows_the_area_it_is_for(estimator) -> None:
    asked = MeasurementSet(middling(estimator, ("stature", "weight")))
    for area, names in AREAS.items():
        gains = next_measurements(estimator, asked, area)
        assert {gain.measurement for gain in gains} == set(TAKEN) - set(asked)
        assert [gain.after for gain in gains] == sorted(gain.after for gain in gains)
        assert gains[0].measurement in names
        for gain in gains:
            assert gain.after <= gain.before == gains[0].before
            assert gain.share == pytest.approx(1 - gain.after / gain.before)
    # What one more value is said to bring is what it brings.
    best = next_measurements(estimator, asked, "bottom")[0]
    value = expected(estimator, asked, best.measurement).middle
    known = MeasurementSet(dict(asked) | {best.measurement: value})
    assert next_measurements(estimator, known, "bottom")[0].before == pytest.approx(
        best.after, rel=0.02
    )


def test_the_fewest_that_speak_against_a_value_are_named(estimator) -> None:
    values = middling(estimator)
    sum_off = middling(estimator, ("upper_arm_length", "lower_arm_length", "arm_length"))
    asked = MeasurementSet(values | sum_off | {"arm_length": 1.12 * sum_off["arm_length"]})
    named = conflicts(estimator, asked, "arm_length")
    assert set(named) <= {"upper_arm_length", "lower_arm_length"}
    assert conflicts(estimator, MeasurementSet({"stature": 1.7}), "stature") == ()
