"""Between two bodies every measurement changes steadily: no tape jumps from place to place."""

import numpy as np

from model.anthropometry import TAKEN, TAPES
from model.girths import Girth
from model.measurements import MEASUREMENTS
from model.training.population import load_population
from model.training.steadiness import changes_by_tiny, heaviest, jumps

LARGEST_JUMP = 0.0012
"""Metres by which one step of a hundred may differ from both its neighbours. A place that is lost
or won costs several times that: tapes that once jumped did so by 2 to 88 mm. Where one place takes
over from another steps change too, but stay changed."""

MOST_BY_CHANCE = 6e-5
MOST_OUTWARDS = 1.5e-4
"""What a hundredth of a millimetre may change. A hoop whose points all move outwards by that much
grows by 6.3 hundredths, as 2 π is; where a body widens steeply, as between a short neck and the
shoulders or from the waist to the hips, by twice that."""

A_TAPE_THAT_JUMPS = Girth(
    ("torso", "upper_leg", "hand"),
    ("crotch",),
    ("midpatella_left",),
    (0.2, 0.2),
)
"""Level around the thighs, and around the hands where they hang low enough."""


def test_no_measurement_jumps_between_two_bodies() -> None:
    random = np.random.default_rng(3)
    population = load_population()
    pairs = [random.choice(len(population.sexes), 2, replace=False) for _ in range(3)]
    # The heavy are where tapes have competing places.
    pairs += [random.choice(heaviest(population, 60), 2, replace=False) for _ in range(7)]
    ones, others = population.coefficients[np.array(pairs).T]
    found = jumps(ones, others, [TAPES[name] for name in TAKEN]).max(axis=0)
    allowed = [0.2 if MEASUREMENTS[name].unit == "kg" else LARGEST_JUMP for name in TAKEN]
    assert {
        name: jump for name, jump, most in zip(TAKEN, found, allowed, strict=True) if jump > most
    } == {}


def test_a_hundredth_of_a_millimetre_changes_no_measurement_by_much_more() -> None:
    population = load_population()
    rows = heaviest(population, 3000)[::-60]
    changes = changes_by_tiny(population.coefficients[rows], seed=0).max(axis=0)
    for most, allowed in zip(changes, (MOST_BY_CHANCE, MOST_OUTWARDS), strict=True):
        assert {
            name: change
            for name, change in zip(TAKEN, most.tolist(), strict=True)
            if change > (0.05 if MEASUREMENTS[name].unit == "kg" else allowed)
        } == {}


def test_a_tape_that_jumps_is_found() -> None:
    population = load_population()
    stature = population.taken[:, 0]
    ends = population.coefficients[[stature.argmin(), stature.argmax()]]
    assert jumps(ends[:1], ends[1:], [A_TAPE_THAT_JUMPS]).max() > 10 * LARGEST_JUMP
