"""The paper's choice of seven, on people whose best seven are planted."""

import numpy as np
import pytest

from model.estimators import LinearBodyEstimator
from model.measurements import MEASUREMENTS
from model.training.feature_selection import (
    PAPER_DROPPED,
    SELECTED,
    TABLE_4,
    TOLD,
    TOP,
    best_for_shape,
    candidates,
    correlate,
    find_outliers,
    scaled_variances,
    select,
    stability,
)

SEXES = ("female", "male")
COUNT = 600


def spread_evenly(share, random):
    """Values of 0..1 of which all but the ends lie within this share of it.

    At shares above 0.6 the ends are within three deviations of the mean.
    """
    values = 0.5 + share * (random.permutation(np.linspace(0, 1, COUNT)) - 0.5)
    values[:10] = np.repeat([0, 1], 5)
    return values


def people(order, seed=0):
    """People in whom each measurement fills less of its range than the one before it."""
    random = np.random.default_rng(seed)
    shares = np.linspace(1.0, 0.62, len(order))
    ranks = np.stack([spread_evenly(share, random) for share in shares], axis=1)
    return 0.2 + 0.5 * ranks


def like(values, column, noise, random):
    """Another measurement that follows a column, in other units."""
    return 3 * values[:, column] + noise * random.normal(size=len(values)) * values[:, column].std()


def test_table_4_names_known_measurements() -> None:
    for sex in SEXES:
        assert len(TABLE_4[sex]) == SELECTED
        assert set(TABLE_4[sex]) | set(PAPER_DROPPED[sex]) <= set(MEASUREMENTS)
        assert len({*TABLE_4[sex], *PAPER_DROPPED[sex]}) == TOP
    assert len(set(TABLE_4["female"]) & set(TABLE_4["male"])) == 6


def test_weight_is_no_tape() -> None:
    assert set(MEASUREMENTS) - set(candidates(list(MEASUREMENTS))) == {"weight"}


def test_outliers_are_those_beyond_three_deviations() -> None:
    values = np.random.default_rng(0).normal(size=(COUNT, 2))
    values = (values - values.mean(axis=0)) / values.std(axis=0, ddof=1)
    values[5, 1] = np.nan
    found = find_outliers(values)
    assert (found[:, 0] == (np.abs(values[:, 0]) > 3)).all()
    assert not found[5, 1]
    far = np.vstack([values, [[50.0, 0.0]]])
    assert find_outliers(far)[-1].tolist() == [True, False]


def test_an_even_spread_has_the_variance_of_an_even_law() -> None:
    names = ("stature", "neck_girth")
    values = np.stack([np.linspace(1.5, 1.9, 5001), np.linspace(0.3, 0.5, 5001) ** 2], axis=1)
    choice = select(names, values)
    assert choice.variances[0] == pytest.approx(1 / 12, rel=1e-3)
    assert (choice.low[0], choice.high[0]) == (1.5, 1.9)
    assert choice.outliers.tolist() == [0, 0]


def test_variances_alone_are_those_of_the_choice() -> None:
    values = np.random.default_rng(10).standard_t(3, size=(400, 5)) * [1, 2, 3, 4, 5]
    choice = select((*TABLE_4["male"][1:5], "stature"), values)
    assert choice.outliers.sum() > 10
    assert scaled_variances(values) == pytest.approx(choice.variances)


def test_scale_and_origin_change_nothing() -> None:
    names = candidates(list(MEASUREMENTS))[:14]
    values = people(names)
    one, other = select(names, values), select(names, 40 * values - 3)
    assert one.variances == pytest.approx(other.variances)
    assert (one.top, one.selected) == (other.top, other.selected)


def test_the_planted_order_is_found() -> None:
    order = (*TABLE_4["female"], "neck_girth", "calf_girth", "head_girth", "wrist_girth")
    shuffled = np.random.default_rng(3).permutation(len(order))
    names = tuple(order[i] for i in shuffled)
    choice = select(names, people(order)[:, shuffled])
    assert choice.top == order[:TOP]
    assert choice.selected == TABLE_4["female"]
    assert choice.told == {}


def test_what_the_paper_drops_is_dropped() -> None:
    """Heights that stature tells and lengths that a girth tells; girths stay, however alike."""
    random = np.random.default_rng(4)
    kept = TABLE_4["male"]
    values = people(kept)
    values[:, 1] = like(values, 0, 0.01, random)  # two girths as good as one
    dropped = ("waist_height", "rise_length", "underbust_to_belly_button_length")
    tellers = (kept.index("stature"), kept.index("neck_girth"), kept.index("neck_girth"))
    more = [like(values, teller, 0.2, random) for teller in tellers]
    names = (*kept, *dropped)
    choice = select(names, np.column_stack([values, *more]))
    assert choice.told == dict(zip(dropped, ["stature", "neck_girth", "neck_girth"], strict=True))
    assert set(choice.selected) == set(kept)
    assert choice.correlation("hip_girth", "bust_girth") > 0.99
    assert choice.correlation("rise_length", "neck_girth") ** 2 > TOLD


def test_stature_stands_in_for_the_heights_that_it_tells() -> None:
    random = np.random.default_rng(5)
    order = ("waist_height", *TABLE_4["male"][:5], "neck_girth", "calf_girth", "knee_girth")
    order = (*order, "elbow_girth", "wrist_girth", "ankle_girth")
    values = people(order)
    stature = 1.7 + 0.1 * (2 * (values[:, 0] - 0.45) + 0.02 * random.normal(size=COUNT))
    # Nobody else comes near these ends, so that its variance is small.
    stature[:2] = 1.7 + np.array([-2.9, 2.9]) * stature.std()
    choice = select((*order, "stature"), np.column_stack([values, stature]))
    assert "stature" not in choice.top
    assert choice.told == {"waist_height": "stature"}
    assert choice.selected[0] == "stature"
    assert "waist_height" not in choice.selected


def test_where_much_is_dropped_the_next_follow() -> None:
    random = np.random.default_rng(6)
    heights = ("waist_height", "inseam_height", "torso_height", "hip_to_ankle_height")
    order = ("stature", *TABLE_4["male"][:5], "calf_girth", "knee_girth", "elbow_girth")
    values = people(order)
    more = [like(values, 0, 0.1, random) for _ in heights]
    choice = select((*order, *heights), np.column_stack([values, *more]))
    assert set(choice.told) <= set(heights)
    assert len(choice.selected) == SELECTED
    assert set(choice.selected).isdisjoint(heights)


def test_what_has_many_outliers_is_left_out() -> None:
    order = (*TABLE_4["male"], "calf_girth", "knee_girth", "elbow_girth", "wrist_girth")
    values = people(order)
    values[:10, 0] += 8
    choice = select(order, values)
    assert choice.outliers[0] == 10
    assert choice.error_prone == (order[0],)
    assert order[0] not in choice.top
    values[3:10, 0] -= 8
    again = select(order, values)
    assert again.error_prone == ()
    assert again.high[0] < 1


def test_unknown_values_take_no_part_in_correlations() -> None:
    values = np.random.default_rng(7).normal(size=(50, 3))
    values[:10, 0] = np.nan
    expected = np.corrcoef(values[10:].T)
    assert correlate(values)[0] == pytest.approx(expected[0])
    assert correlate(values)[1, 2] == pytest.approx(np.corrcoef(values[:, 1:].T)[0, 1])


@pytest.mark.parametrize(
    ("names", "width", "words"),
    [(("neck_girth",), 1, "stature, which is not among"), (("stature",), 2, "not of 1 meas")],
)
def test_it_refuses(names, width, words) -> None:
    with pytest.raises(ValueError, match=words):
        select(names, np.ones((9, width)))


def test_a_clear_choice_is_stable_and_an_even_one_is_not() -> None:
    order = (*TABLE_4["female"], "neck_girth", "calf_girth", "head_girth", "wrist_girth")
    shares = stability(order, people(order), seed=1, rounds=20)
    assert shares.selected["bust_girth"] == 1
    assert shares.top["wrist_girth"] < 0.2
    assert sum(shares.selected.values()) == pytest.approx(SELECTED)
    again = stability(order, people(order), seed=1, rounds=20)
    assert again.selected == shares.selected
    alike = np.random.default_rng(8).uniform(size=(COUNT, len(order)))
    unsettled = stability(order, alike, seed=1, rounds=20)
    assert max(unsettled.selected.values()) < 1 or min(unsettled.selected.values()) > 0


def test_weights_choose_whom_to_draw() -> None:
    """Two kinds of people; the choice follows those that are drawn."""
    order = (*TABLE_4["female"], "neck_girth", "calf_girth", "head_girth", "wrist_girth")
    values = np.concatenate([people(order), people(order[::-1])[:, ::-1]])
    first = np.repeat([1.0, 0.0], COUNT)
    shares = [stability(order, values, seed=2, weights=w, rounds=10) for w in (first, 1 - first)]
    assert shares[0].selected["bust_girth"] == shares[1].selected["wrist_girth"] == 1
    assert shares[0].selected["wrist_girth"] == shares[1].selected["bust_girth"] == 0


def test_the_best_for_shape_are_those_that_shape_follows() -> None:
    random = np.random.default_rng(9)
    names = ("stature", "waist_girth", "neck_girth", "hip_girth", "calf_girth")
    measured = random.normal(size=(400, 5))
    law = np.array([[0, 0, 3, 0, 0], [5, 0, 0, 0, 0], [0, 0, 0, 0, 1.0]])
    linear = LinearBodyEstimator().fit(measured, measured @ law.T)
    best = best_for_shape(linear, names, names, 3)
    assert best == ("stature", "neck_girth", "calf_girth")
    assert best_for_shape(linear, names, names[1:], 2) == ("neck_girth", "calf_girth")
