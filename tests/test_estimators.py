from dataclasses import replace

import numpy as np
import pytest
from sklearn.linear_model import LinearRegression
from sklearn.utils.estimator_checks import parametrize_with_checks

from model.anthropometry import TAKEN, measure
from model.estimators import LinearBodyEstimator, load_estimator, load_estimators
from model.measurements import BODY_KINDS, MeasurementSet

KNOWN = {"stature": 1.68, "bust_girth": 0.92, "waist_girth": 0.74, "hip_girth": 1.0}


@parametrize_with_checks([LinearBodyEstimator(), LinearBodyEstimator(fit_intercept=False)])
def test_it_keeps_scikit_learns_contract(estimator, check) -> None:
    check(estimator)


@pytest.fixture
def planted() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    random = np.random.default_rng(0)
    measurements = random.normal(size=(200, 5)) * [0.1, 10, 0.2, 0.05, 1] + [1.7, 70, 1, 0.4, 3]
    law = random.normal(size=(7, 5))
    return measurements, measurements @ law.T, law


def test_equation_8_finds_a_planted_law(planted) -> None:
    measurements, coordinates, law = planted
    estimator = LinearBodyEstimator(fit_intercept=False).fit(measurements, coordinates)
    assert estimator.law(np.ones(5, dtype=bool)) == pytest.approx(law, abs=1e-6)
    pseudo = coordinates.T @ np.linalg.pinv(measurements.T)
    assert estimator.law(np.ones(5, dtype=bool)) == pytest.approx(pseudo, abs=1e-6)


def test_with_a_constant_it_is_ordinary_least_squares(planted) -> None:
    measurements, coordinates, _ = planted
    noisy = coordinates + np.random.default_rng(1).normal(size=coordinates.shape)
    ours = LinearBodyEstimator().fit(measurements, noisy).predict(measurements)
    theirs = LinearRegression().fit(measurements, noisy).predict(measurements)
    assert ours == pytest.approx(theirs, abs=1e-6)


@pytest.mark.parametrize("missing", [[1], [0, 3], [0, 1, 2, 3], [0, 1, 2, 3, 4]])
def test_any_subset_is_as_if_fitted_on_it_alone(planted, missing) -> None:
    measurements, coordinates, _ = planted
    noisy = coordinates + np.random.default_rng(1).normal(size=coordinates.shape)
    partly = measurements.copy()
    partly[:, missing] = np.nan
    ours = LinearBodyEstimator().fit(measurements, noisy).predict(partly)
    known = np.delete(measurements, missing, axis=1)
    theirs = (
        LinearRegression().fit(known, noisy).predict(known)
        if known.size
        else np.broadcast_to(noisy.mean(axis=0), noisy.shape)
    )
    assert ours == pytest.approx(theirs, abs=1e-6)


def test_what_is_missing_while_learning_is_left_out(planted) -> None:
    measurements, coordinates, _ = planted
    partly = measurements.copy()
    partly[::7, 2] = np.nan
    estimator = LinearBodyEstimator().fit(partly, coordinates)
    full = LinearBodyEstimator().fit(measurements, coordinates)
    there = ~np.isnan(partly[:, 2])
    assert estimator.moments_[0, 3] == pytest.approx(measurements[there, 2].mean())
    assert np.delete(estimator.moments_[0], 3) == pytest.approx(np.delete(full.moments_[0], 3))


@pytest.mark.parametrize("kind", BODY_KINDS)
def test_shipped_estimators_come_near_what_was_asked(kind) -> None:
    estimator = load_estimators()[kind]
    body = estimator.estimate(MeasurementSet(KNOWN))
    taken = measure(body).values
    assert body.kind == kind
    assert body.vertices[:, 1].min() == 0
    for name, asked in KNOWN.items():
        assert taken[name] == pytest.approx(asked, abs=0.03), name


def test_more_girth_asked_more_girth_taken() -> None:
    estimator = load_estimators()["female"]
    for name in ("bust_girth", "waist_girth", "hip_girth", "thigh_girth", "neck_girth"):
        low, high = estimator.limits[name]
        taken = [
            measure(estimator.estimate(MeasurementSet({"stature": 1.68, name: value}))).values[name]
            for value in np.linspace(0.7 * low + 0.3 * high, 0.3 * low + 0.7 * high, 5)
        ]
        assert taken == sorted(taken)


def test_ranges_narrow_as_more_is_known() -> None:
    estimator = load_estimators()["female"]
    few, more = MeasurementSet({"stature": 1.68}), MeasurementSet(KNOWN)
    taken = measure(estimator.estimate(more)).values
    wide, narrow = (estimator.ranges(asked, taken) for asked in (few, more))
    for name in TAKEN:
        low, high = narrow[name]
        assert low <= taken[name] <= high
        if name in KNOWN:
            assert low == high == taken[name]
        else:
            # Calibration goes with the index, of which more is known too: by little it may widen.
            assert high - low < 1.05 * (wide[name][1] - wide[name][0])


def test_a_noisy_tape_widens_ranges_and_the_bodys_own_value_lies_within() -> None:
    estimator = load_estimators()["male"]
    asked = MeasurementSet({"stature": 1.76, "weight": 80, "abdomen_girth": 0.9})
    taken = measure(estimator.estimate(asked)).values
    sure = estimator.ranges(asked, taken)
    unsure = estimator.ranges(asked, taken, noise={"abdomen_girth": 0.05})
    assert np.ptp(unsure["waist_girth"]) > 1.2 * np.ptp(sure["waist_girth"])
    far = MeasurementSet(dict(taken) | {"neck_girth": 0.6})
    assert estimator.ranges(asked, far)["neck_girth"][1] == 0.6


def test_a_noisy_value_is_followed_less() -> None:
    """From nothing but stature, over a doubtful bust, to a bust that is sure."""
    estimator = load_estimators()["male"]
    asked = MeasurementSet({"stature": 1.76, "bust_girth": 1.25})
    nothing, unsure, sure = (
        measure(estimator.body(coefficients)).values
        for coefficients in (
            estimator.likeliest(MeasurementSet({"stature": 1.76})),
            estimator.likeliest(asked, {"bust_girth": 0.15}),
            estimator.likeliest(asked),
        )
    )
    for name in ("bust_girth", "hip_girth", "waist_girth", "weight"):
        assert nothing[name] < unsure[name] < sure[name], name
    assert sure["bust_girth"] == pytest.approx(1.25, abs=0.02)


def test_limits_hold_every_body_learned_from() -> None:
    for estimator in load_estimators().values():
        assert set(estimator.limits) == set(TAKEN)
        assert estimator.limits["stature"][0] < 1.5 < 1.9 < estimator.limits["stature"][1]
        assert all(0 < low < high for low, high in estimator.limits.values())


def test_saving_and_loading_changes_nothing(tmp_path) -> None:
    estimator = load_estimators()["male"]
    estimator.save(tmp_path / "male.npz")
    again = load_estimator(tmp_path / "male.npz")
    asked = MeasurementSet({"stature": 1.8, "neck_girth": 0.39})
    assert (again.estimate(asked).vertices == estimator.estimate(asked).vertices).all()
    assert (again.names, again.limits, again.version, again.trained_on, again.kind) == (
        estimator.names,
        estimator.limits,
        estimator.version,
        estimator.trained_on,
        "male",
    )


def test_a_law_without_a_constant_stays_one(tmp_path) -> None:
    estimator = load_estimators()["male"]
    linear = LinearBodyEstimator(fit_intercept=False)
    vars(linear).update({k: v for k, v in vars(estimator.linear).items() if k.endswith("_")})
    replace(estimator, linear=linear).save(tmp_path / "male.npz")
    asked = MeasurementSet({"stature": 1.8, "neck_girth": 0.39})
    again = load_estimator(tmp_path / "male.npz").estimate(asked).vertices
    assert (again == replace(estimator, linear=linear).estimate(asked).vertices).all()
    assert (again != estimator.estimate(asked).vertices).any()


def test_an_estimator_of_another_basis_or_table_is_refused(tmp_path) -> None:
    estimator = load_estimators()["male"]
    other = replace(estimator, basis=replace(estimator.basis, fingerprint="another"))
    other.save(tmp_path / "basis.npz")
    with pytest.raises(ValueError, match=r"basis\.npz was trained on another shape basis"):
        load_estimator(tmp_path / "basis.npz")
    fewer = replace(
        estimator,
        names=TAKEN[:-1],
        limits={name: estimator.limits[name] for name in TAKEN[:-1]},
    )
    fewer.save(tmp_path / "names.npz")
    with pytest.raises(ValueError, match=r"names\.npz knows other measurements"):
        load_estimator(tmp_path / "names.npz")


def test_a_missing_or_broken_file_is_named(tmp_path) -> None:
    with pytest.raises(FileNotFoundError, match=r"nobody\.npz"):
        load_estimator(tmp_path / "nobody.npz")
    np.savez(tmp_path / "other.npz", kind="male")
    with pytest.raises(ValueError, match=r"other\.npz is not an estimator's file"):
        load_estimator(tmp_path / "other.npz")
    (tmp_path / "broken.npz").write_bytes(b"not an archive")
    with pytest.raises(ValueError, match=r"broken\.npz is not an estimator's file"):
        load_estimator(tmp_path / "broken.npz")
