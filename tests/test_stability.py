"""Between two bodies every measurement changes steadily: no tape jumps from place to place."""

import numpy as np

from model.anthropometry import TAKEN, TAPES, read_tapes
from model.appearance import vertex_normals
from model.geometry import Floats
from model.girths import Girth
from model.measurements import MEASUREMENTS
from model.shape_basis import load_shape_basis
from model.tapes import Tape
from model.template_mesh import load_template_mesh
from model.training.population import load_population

STEPS = 100

LARGEST_JUMP = 0.001
"""Metres by which one step of a hundred may differ from both its neighbours. A place that is lost
or won costs several times that: tapes that once jumped did so by 4 to 88 mm. Where one place takes
over from another steps change too, but stay changed."""

TINY = 1e-5
"""A hundredth of a millimetre."""

MOST_BY_TINY = 1e-4
MOST_BY_TINY_OF_NECKS = 2e-4
"""What it may change: a hoop whose points all move outwards by a hundredth of a millimetre grows
by 6.3 hundredths, as 2 π is; a belly's that tapers, by a little more. Short necks widen steeply to
both sides of where they are taken."""

A_TAPE_THAT_JUMPS = Girth(
    ("torso", "upper_leg", "hand"),
    ("crotch",),
    ("midpatella_left",),
    (0.2, 0.2),
)
"""Level around the thighs, and around the hands where they hang low enough."""


def jumps(pairs: list[tuple[int, int]], tapes: list[Tape]) -> Floats:
    """By how much a step along lines between bodies differs from the step before and the next.

    Returns
    -------
    ndarray of shape (pairs, tapes), the largest of each line, SI.
    """
    coefficients, basis = load_population().coefficients, load_shape_basis()
    shares = np.linspace(0, 1, STEPS + 1)[:, None]
    largest = []
    for one, other in pairs:
        line = (1 - shares) * coefficients[one] + shares * coefficients[other]
        values = read_tapes(load_template_mesh(), basis.vertices(line), tapes)
        changes = np.abs(np.diff(values, 2, axis=0))
        largest.append(np.minimum(changes[:-1], changes[1:]).max(axis=0))
    return np.array(largest)


def heaviest(count: int, below: float = 60) -> list[int]:
    """The bodies with the largest body-mass index below one, in kg/m²."""
    population = load_population()
    index = population.taken[:, 1] / population.taken[:, 0] ** 2
    order = np.argsort(index)
    return order[index[order] < below][-count:].tolist()


def test_no_measurement_jumps_between_two_bodies() -> None:
    random = np.random.default_rng(3)
    people = len(load_population().sexes)
    pairs = [tuple(random.choice(people, 2, replace=False).tolist()) for _ in range(3)]
    # The heavy are where tapes have competing places.
    pairs += [tuple(random.choice(heaviest(60), 2, replace=False).tolist()) for _ in range(7)]
    found = jumps(pairs, [TAPES[name] for name in TAKEN]).max(axis=0)
    allowed = [0.2 if MEASUREMENTS[name].unit == "kg" else LARGEST_JUMP for name in TAKEN]
    assert {
        name: jump for name, jump, most in zip(TAKEN, found, allowed, strict=True) if jump > most
    } == {}


def test_a_hundredth_of_a_millimetre_changes_no_measurement_by_much_more() -> None:
    template, basis = load_template_mesh(), load_shape_basis()
    random = np.random.default_rng(0)
    # Beyond an index of 45 a neck may be no longer than a tape is wide.
    rows = heaviest(3000, below=45)[::-60]
    tapes = [TAPES[name] for name in TAKEN]
    most = np.zeros(len(TAKEN))
    for body in basis.vertices(load_population().coefficients[rows]):
        moved = np.stack([body, body, body])
        moved[1] += random.uniform(-TINY, TINY, body.shape)
        moved[2] += TINY * vertex_normals(body, template.faces)
        values = read_tapes(template, moved, tapes)
        most = np.maximum(most, np.abs(values[1:] - values[0]).max(axis=0))
    usual = {"weight": 0.05, "neck_girth": MOST_BY_TINY_OF_NECKS}
    assert {
        name: change
        for name, change in zip(TAKEN, most.tolist(), strict=True)
        if change > usual.get(name, MOST_BY_TINY)
    } == {}


def test_a_tape_that_jumps_is_found() -> None:
    stature = load_population().taken[:, 0]
    pair = int(stature.argmin()), int(stature.argmax())
    assert jumps([pair], [A_TAPE_THAT_JUMPS]).max() > 10 * LARGEST_JUMP
