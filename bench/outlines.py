"""Outlines as photos would give them, of bodies that are known: other arms, noise, cloth."""

from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from model.anthropometry import measure_batch
from model.cameras import Camera, Facing, Side
from model.estimators import Estimator, load_estimators
from model.geometry import Floats
from model.masks import LIGHT, Mask, person, runs
from model.measurements import BodyKind, MeasurementSet
from model.refinement import Photo
from model.silhouette import silhouette
from model.template_mesh import Body
from model.training.population import Population, load_population
from model.training.survey import SEXES

SIDES: tuple[Side, Side] = ("front", "profile")

DISTANCES, HEIGHTS = (2.0, 4.0), (0.6, 1.4)
"""Metres: where cameras stand."""

LIFTS, SWINGS = (-0.30, 0.15), (-0.10, 0.10)
"""Radians: how arms are turned from where the avatar has them."""

FINGERS = 0.15
"""By this share of itself at most a hand is shorter than the avatar's, as fingers are bent."""

NOISE = 0.01
"""By how much of itself a breadth is off, as a standard deviation."""

WAVES = 0.03
"""Metres: how far along an outline its errors are alike."""

CLOTHED = (0.2, 0.82)
TROUSERS = (0.06, 0.6)
SKIRT = (0.3, 0.62)
"""From the knees to the armpits, from the ankles to the waist, and from above the knees to there,
as shares of the height: what loose clothes hang on."""

FINE_ROWS = 1200
"""Pixels from crown to soles, as the page sends them."""

_SPACE = 30
"""Pixels around the person, and as many more as cloth takes."""

_COARSE = 4
_SHOULDER = (-0.04, 0.06)
"""Metres along the arm from its joint, over which a turn sets in."""


def held_out(row: int, seed: int) -> tuple[Estimator, Body, np.random.Generator]:
    """A body of the population, its kind's estimator, and a source of chance of its own."""
    population, estimators = _loaded()
    estimator = estimators[SEXES[population.sexes[row]]]
    body = estimator.body(population.coefficients[row])
    return estimator, body, np.random.default_rng([seed, row])


@cache
def _loaded() -> tuple[Population, Mapping[BodyKind, Estimator]]:
    return load_population(), load_estimators()


def values_of(body: Body, names: Sequence[str]) -> MeasurementSet:
    """What a body measures."""
    values = measure_batch(body.template, body.vertices[None], names)[0]
    return MeasurementSet(dict(zip(names, values, strict=True)))


def photographed(
    body: Body,
    random: np.random.Generator,
    noise: float = NOISE,
    cloth: float = 0.0,
    hangs: tuple[float, float] = CLOTHED,
) -> tuple[list[Photo], dict[Side, float]]:
    """A body's rough outlines by one camera, its arms turned; IoU of each with the smooth one."""
    camera = Camera(random.uniform(*DISTANCES), random.uniform(*HEIGHTS))
    hands = random.spawn(1)[0].uniform(0, FINGERS, (2, 2))
    photos, rough = [], {}
    for side, bent in zip(SIDES, hands.tolist(), strict=True):
        arms = [(random.uniform(*LIFTS), random.uniform(*SWINGS)) for _ in range(2)]
        turned = with_arms(with_fingers(body, bent[0], bent[1]), arms[0], arms[1])
        facing: Facing = "left" if side == "profile" and random.random() < 0.5 else "right"
        mask: Mask = silhouette(turned, side, camera=camera, facing=facing, rows=FINE_ROWS)
        height = float(np.ptp(body.vertices[:, 1]))
        cover = roughened(mask, noise, height, random, cloth, hangs)
        covers = cover, np.pad(mask.cover, (np.array(cover.shape) - mask.cover.shape)[0] // 2)
        rough[side] = float(np.minimum(*covers).sum() / np.maximum(*covers).sum())
        photos.append(Photo(person(cover), side, camera, facing))
    return photos, rough


def with_arms(body: Body, left: tuple[float, float], right: tuple[float, float]) -> Body:
    """A body whose arms are turned about the shoulders.

    Parameters
    ----------
    left, right : by how much each is lifted sideways and swung forwards, in radians.
    """
    template, vertices = body.template, body.vertices.copy()
    for side, (lift, swing), sense in (("left", left, 1), ("right", right, -1)):
        parts = [f"{part}_{side}" for part in ("upper_arm", "lower_arm", "hand")]
        own = np.unique(template.faces[template.faces_of(*parts)])
        names = (f"acromion_{side}", f"axilla_{side}"), (f"radiale_{side}",)
        joint, elbow = (template.landmark_points(body.vertices, *each) for each in names)
        along = (body.vertices[own] - joint) @ (elbow - joint) / np.linalg.norm(elbow - joint)
        share = np.clip((along - _SHOULDER[0]) / (_SHOULDER[1] - _SHOULDER[0]), 0, 1)
        share = share * share * (3 - 2 * share)
        moved = _turned(vertices[own] - joint, sense * lift * share, (0, 1))
        vertices[own] = joint + _turned(moved, -swing * share, (1, 2))
    return Body(template, vertices, body.kind)


def with_fingers(body: Body, left: float, right: float) -> Body:
    """A body whose hands are shorter by a share, from the wrist along the arm."""
    template, vertices = body.template, body.vertices.copy()
    for side, share in (("left", left), ("right", right)):
        own = np.unique(template.faces[template.faces_of(f"hand_{side}")])
        elbow, wrist = (
            template.landmark_points(body.vertices, f"{name}_{side}")
            for name in ("radiale", "stylion")
        )
        along = (wrist - elbow) / np.linalg.norm(wrist - elbow)
        beyond = np.maximum((vertices[own] - wrist) @ along, 0)
        vertices[own] -= share * beyond[:, None] * along
    return Body(template, vertices, body.kind)


def roughened(
    mask: Mask,
    share: float,
    height: float,
    random: np.random.Generator,
    cloth: float = 0.0,
    hangs: tuple[float, float] = CLOTHED,
) -> NDArray[np.float32]:
    """A mask whose outline is moved at every point, so that breadths are off by a share.

    Parameters
    ----------
    share : of the row's run of pixels that ends there, as a standard deviation: each of its two
        edges has its part.
    height : of the person, in metres.
    cloth : metres by which the figure is thicker all around where it hangs.
    hangs : from where to where that is, as shares of the height.

    Returns
    -------
    ndarray of shape (h, w), with space around the person.
    """
    thick = cloth / height * len(mask.cover)
    space = _SPACE + int(np.ceil(thick))
    inside = np.pad(mask.cover, space) >= LIGHT
    rows, starts, ends = runs(inside)
    breadths = np.zeros(inside.shape)
    for row, start, end in zip(rows, starts, ends, strict=True):
        breadths[row, start:end] = end - start
    outwards, nearest = ndimage.distance_transform_edt(~inside, return_indices=True)
    depths = ndimage.distance_transform_edt(inside) - outwards
    depths -= 0.5 * np.sign(depths)  # between two pixels' middles lies the edge
    # Waves are long: a coarse grid of them is enough.
    coarse = tuple(-(-size // _COARSE) + 1 for size in inside.shape)
    length = WAVES / height * len(mask.cover) / _COARSE
    waves = ndimage.gaussian_filter(random.normal(size=coarse), length)
    waves = ndimage.zoom(waves / waves.std(), _COARSE, order=1)
    waves = waves[: inside.shape[0], : inside.shape[1]]
    depths += share / np.sqrt(2) * breadths[tuple(nearest)] * waves
    above = 1 - (np.arange(len(inside)) - space) / len(mask.cover)
    clothed = (above > hangs[0]) & (above < hangs[1])
    depths += clothed[:, None] * thick
    return np.clip(depths + 0.5, 0, 1).astype(np.float32)


def _turned(points: Floats, angles: Floats, axes: tuple[int, int]) -> Floats:
    """Points turned in the plane of two axes, each by its angle."""
    turned = points.copy()
    first, second = points[:, axes[0]], points[:, axes[1]]
    turned[:, axes[0]] = np.cos(angles) * first - np.sin(angles) * second
    turned[:, axes[1]] = np.sin(angles) * first + np.cos(angles) * second
    return turned
