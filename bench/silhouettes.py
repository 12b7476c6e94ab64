"""How well outlines tell bodies apart, and how much they help: ``python -m bench silhouettes``.

Held-out bodies of the population are seen by cameras that differ from person to person, their
arms turned as no avatar's are, their outlines moved at every point so that breadths are off by a
share. The comparison knows the camera, or has to estimate it; it never knows the arms.
"""

import argparse
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed
from threadpoolctl import threadpool_limits

from bench.outlines import CLOTHED, FINE_ROWS, TROUSERS, roughened, with_arms
from model.anthropometry import measure_batch
from model.camera_estimate import estimate_camera
from model.cameras import USUAL_CAMERA, Camera, Facing, Side
from model.comparison import Comparison, compare
from model.estimators import Estimator, load_estimators
from model.geometry import Booleans, Floats
from model.masks import Mask, person
from model.measurements import MeasurementSet
from model.refinement import Photo, refine
from model.silhouette import silhouette
from model.tape_fit import Likely, fit_to_tape
from model.template_mesh import Body
from model.training.population import load_population
from model.training.survey import SEXES
from model.training.validation import ENTERED

EIGHT = ENTERED["the eight that the paper evaluates"]

FEW = ("stature", "weight", "bust_girth", "hip_girth")
FEW_WORDS = "4 entered: stature, weight, bust, hips"

SIDES: tuple[Side, Side] = ("front", "profile")

DISTANCES, HEIGHTS = (2.0, 4.0), (0.6, 1.4)
"""Metres: where cameras stand."""

LIFTS, SWINGS = (-0.30, 0.15), (-0.10, 0.10)
"""Radians: how arms are turned from where the avatar has them."""

NOISE = 0.01
WAIST = 1.1
CLOTH, WIDE_CLOTH = 0.02, 0.03

ODD = 1.5
"""A waist or a thigh is unusual that is so many deviations from what the law of people leads to
expect of whoever has the entered values."""

MARK = "<!-- what follows is written by python -m bench silhouettes --write -->\n"
PAGE = Path(__file__).parent.parent / "docs" / "comparison.md"


@dataclass(frozen=True)
class Told:
    """One known body: by view, beside its own outline, its avatar's, and a stouter body's.

    rough : IoU of the outline with noise and the one without.
    true, avatar, unknown : IoU and mean outline distance in metres; the last of the true body,
        beside which the camera is estimated from the avatar.
    off : ndarray of shape (4,): by how many metres that camera's distance and height are off, and
        the usual camera's.
    waists : photo less the stouter body at the waist's level, in metres; NaN where it is hidden.
    """

    rough: Mapping[Side, float]
    true: Mapping[Side, tuple[float, float]]
    avatar: Mapping[Side, tuple[float, float]]
    unknown: Mapping[Side, tuple[float, float]]
    off: Floats
    waists: Mapping[Side, float]


@dataclass(frozen=True)
class Helped:
    """One body refined.

    before, after : mean distance of all vertices, and of trunk and legs, in metres.
    miss : the largest of an entered length, in metres.
    pull : see `model.refinement.Refined`.
    cloth : what was taken for cloth, the mean of all levels, in metres.
    """

    before: tuple[float, float]
    after: tuple[float, float]
    miss: float
    pull: float
    cloth: float


def main(arguments: Sequence[str]) -> None:
    """Runs all trials and prints their tables."""
    parser = argparse.ArgumentParser(prog="python -m bench silhouettes", description=__doc__)
    parser.add_argument("--known", type=int, default=50, help="bodies to be told apart")
    parser.add_argument("--bodies", type=int, default=200, help="bodies to be refined")
    parser.add_argument("--others", type=int, default=40, help="bodies of each further trial")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--write", action="store_true", help=f"into {PAGE.name} too")
    options = parser.parse_args(arguments)
    rows = chosen(max(options.known, options.bodies), options.seed)
    told = _each("telling apart", tell, rows[: options.known], options)
    helped = _each("refining", help_with, rows[: options.bodies], options)
    few = _each("refining, few entered", help_with, rows[: options.bodies], options, entered=FEW)
    odd = unusual(rows[: options.bodies], FEW)
    trials = {"8 measurements entered": helped, FEW_WORDS: few}
    for words, wanted in (("unusual", True), ("usual", False)):
        trials[f"of those, {words} waist or thighs"] = [
            one for one, is_odd in zip(few, odd.tolist(), strict=True) if is_odd == wanted
        ]
    others: dict[str, dict[str, Any]] = {
        "8 entered, the camera estimated": {"told": False},
        "8 entered, three times the noise": {"noise": 3 * NOISE},
        f"8 entered, in clothes that stand off by {100 * CLOTH:.0f} cm": {"cloth": CLOTH},
        f"4 entered, in clothes that stand off by {100 * CLOTH:.0f} cm": {
            "cloth": CLOTH,
            "entered": FEW,
        },
        f"4 entered, in trousers that stand off by {100 * WIDE_CLOTH:.0f} cm": {
            "cloth": WIDE_CLOTH,
            "worn": TROUSERS,
            "entered": FEW,
        },
    }
    count = min(options.others, options.bodies)
    for words, how in others.items():
        trials[words] = _each(words, help_with, rows[:count], options, **how)
    text = "\n".join(
        [
            *_told_lines(told),
            "",
            *_helped_lines(trials),
            "",
            f"`python -m bench silhouettes {' '.join(arguments)}`".replace(" `", "`")
            + f", seed {options.seed}, {datetime.now(UTC).date()}, bodies of "
            f"{load_population().date}.",
            "",
        ]
    )
    print(text)
    if options.write:
        head = PAGE.read_text(encoding="utf-8").partition(MARK)[0]
        PAGE.write_text(f"{head}{MARK}\n{text}", encoding="utf-8")


def chosen(count: int, seed: int) -> list[int]:
    """Rows of held-out bodies.

    Raises
    ------
    ValueError
        For more than there are.
    """
    rows = np.flatnonzero(load_population().held_out)
    if not 1 <= count <= len(rows):
        raise ValueError(f"{count} bodies are not from 1 to {len(rows)}")
    picked: list[int] = np.random.default_rng(seed).permutation(rows)[:count].tolist()
    return picked


def tell(row: int, seed: int) -> Told:
    """Compares one body's outlines with itself, with its avatar and with a stouter body."""
    estimator, body, random = _person(row, seed)
    asked = _values(body, EIGHT)
    photos, rough = _photographed(body, random, NOISE)
    likely = Likely(load_population().coefficients[row], estimator.spread)
    kept = {name: asked[name] for name in ("stature", "inseam_height")}
    wanted = MeasurementSet(kept | {"waist_girth": WAIST * asked["waist_girth"]})
    stout = fit_to_tape(estimator, wanted, likely).body
    avatar = fit_to_tape(estimator, asked).body
    camera, found = (
        photos[0].camera,
        estimate_camera({one.side: one.mask for one in photos}, avatar),
    )
    elsewhere = [replace(photo, camera=found) for photo in photos]
    beside = (("true", photos, body), ("avatar", photos, avatar), ("stout", photos, stout))
    results: dict[str, dict[Side, Comparison]] = {
        name: {photo.side: _compared(photo, other) for photo in ones}
        for name, ones, other in (*beside, ("unknown", elsewhere, body))
    }
    pairs = {
        name: {side: (one.iou, one.distance) for side, one in ones.items()}
        for name, ones in results.items()
    }
    places = [(one.distance, one.height) for one in (camera, found, USUAL_CAMERA)]
    true, *others = np.array(places)
    return Told(
        rough=rough,
        true=pairs["true"],
        avatar=pairs["avatar"],
        unknown=pairs["unknown"],
        off=np.concatenate([other - true for other in others]),
        waists={side: _waist(one) for side, one in results["stout"].items()},
    )


def help_with(
    row: int,
    seed: int,
    entered: Sequence[str] = EIGHT,
    noise: float = NOISE,
    cloth: float = 0.0,
    worn: tuple[float, float] = CLOTHED,
    told: bool = True,
) -> Helped:
    """Refines one body by its outlines, with or without being told of the camera."""
    estimator, body, random = _person(row, seed)
    asked = _values(body, entered)
    photos, _ = _photographed(body, random, noise, cloth, worn)
    first = fit_to_tape(estimator, asked).body
    if not told:
        camera = estimate_camera({photo.side: photo.mask for photo in photos}, first)
        photos = [replace(photo, camera=camera) for photo in photos]
    refined = refine(estimator, asked, photos)
    template = body.template
    seen = np.unique(template.faces[template.faces_of("torso", "upper_leg", "lower_leg")])
    before, after = (
        (float(apart.mean()), float(apart[seen].mean()))
        for apart in (
            np.linalg.norm(other.vertices - body.vertices, axis=1)
            for other in (first, refined.fit.body)
        )
    )
    lengths = [abs(miss) for name, miss in refined.fit.misses.items() if name != "weight"]
    return Helped(before, after, max(lengths), refined.pull, float(refined.cloth.mean()))


def unusual(rows: Sequence[int], entered: Sequence[str]) -> Booleans:
    """Which bodies have a waist or a thigh unlike what their entered values lead to expect."""
    odd = []
    for row in rows:
        estimator, body, _ = _person(row, 0)
        given = estimator.law.given(_values(body, entered))
        own = _values(body, ("waist_girth", "thigh_girth"))
        odd.append(max(abs(given.score(name, value)) for name, value in own.items()) > ODD)
    return np.array(odd)


def _person(row: int, seed: int) -> tuple[Estimator, Body, np.random.Generator]:
    population = load_population()
    estimator = load_estimators()[SEXES[population.sexes[row]]]
    body = estimator.body(population.coefficients[row])
    return estimator, body, np.random.default_rng([seed, row])


def _values(body: Body, names: Sequence[str]) -> MeasurementSet:
    values = measure_batch(body.template, body.vertices[None], names)[0]
    return MeasurementSet(dict(zip(names, values, strict=True)))


def _photographed(
    body: Body,
    random: np.random.Generator,
    noise: float,
    cloth: float = 0.0,
    worn: tuple[float, float] = CLOTHED,
) -> tuple[list[Photo], dict[Side, float]]:
    """A body's rough outlines by one camera, its arms turned; IoU of each with the smooth one."""
    camera = Camera(random.uniform(*DISTANCES), random.uniform(*HEIGHTS))
    photos, rough = [], {}
    for side in SIDES:
        arms = [(random.uniform(*LIFTS), random.uniform(*SWINGS)) for _ in range(2)]
        turned = with_arms(body, arms[0], arms[1])
        facing: Facing = "left" if side == "profile" and random.random() < 0.5 else "right"
        mask: Mask = silhouette(turned, side, camera=camera, facing=facing, rows=FINE_ROWS)
        height = float(np.ptp(body.vertices[:, 1]))
        cover = roughened(mask, noise, height, random, cloth, worn)
        covers = cover, np.pad(mask.cover, (np.array(cover.shape) - mask.cover.shape)[0] // 2)
        rough[side] = float(np.minimum(*covers).sum() / np.maximum(*covers).sum())
        photos.append(Photo(person(cover), side, camera, facing))
    return photos, rough


def _compared(photo: Photo, body: Body) -> Comparison:
    return compare(photo.mask, body, photo.side, camera=photo.camera)


def _waist(comparison: Comparison) -> float:
    """Photo less body at the waist."""
    for level in comparison.levels:
        if level.measurement == "waist_girth":
            return level.photo - level.avatar
    return float("nan")


def _each(
    words: str,
    task: Callable[..., Any],
    rows: Sequence[int],
    options: argparse.Namespace,
    **how: Any,
) -> list[Any]:
    """A task for every row, side by side, with the progress on the error stream."""
    results = []
    jobs = (delayed(_alone)(task, row, options.seed, **how) for row in rows)
    for done in Parallel(n_jobs=options.processes, return_as="generator")(jobs):
        results.append(done)
        print(f"\r{words}: {len(results)} of {len(rows)} ", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return results


def _alone(task: Callable[..., Any], row: int, seed: int, **how: Any) -> Any:
    with threadpool_limits(1):
        return task(row, seed, **how)


def _told_lines(told: Sequence[Told]) -> Iterable[str]:
    yield f"| {len(told)} known bodies | front | profile |"
    yield "|---|---|---|"
    rough = {side: np.array([one.rough[side] for one in told]) for side in SIDES}
    cells = [f"{np.median(one):.4f} ({one.min():.4f})" for one in rough.values()]
    yield f"| with noise and without it: overlap, median (least) | {' | '.join(cells)} |"
    for name, words in (
        ("true", "the true body"),
        ("unknown", "the true body, the camera estimated"),
        ("avatar", "its avatar, from 8 measurements"),
    ):
        pairs = {side: np.array([getattr(one, name)[side] for one in told]) for side in SIDES}
        yield (
            "| "
            + " | ".join(
                [f"{words}: overlap, median (least; above 0.98)"]
                + [
                    f"{np.median(p[:, 0]):.4f} ({p[:, 0].min():.4f}; {(p[:, 0] > 0.98).sum()})"
                    for p in pairs.values()
                ]
            )
            + " |"
        )
        yield (
            "| "
            + " | ".join(
                [f"{words}: outline distance, median (most), mm"]
                + [
                    f"{1e3 * np.median(p[:, 1]):.1f} ({1e3 * p[:, 1].max():.1f})"
                    for p in pairs.values()
                ]
            )
            + " |"
        )
    waists = {side: np.array([one.waists[side] for one in told]) for side in SIDES}
    yield (
        "| "
        + " | ".join(
            ["10 % more waist: sign of the waist's level right"]
            + [
                f"{(w < 0).sum()} of {np.isfinite(w).sum()}"
                + (f", {np.isnan(w).sum()} hidden" if np.isnan(w).any() else "")
                for w in waists.values()
            ]
        )
        + " |"
    )
    yield (
        "| "
        + " | ".join(
            ["10 % more waist: mean (least) of that level, mm"]
            + [f"{-1e3 * np.nanmean(w):.1f} ({-1e3 * np.nanmax(w):.1f})" for w in waists.values()]
        )
        + " |"
    )
    off = np.sqrt(np.mean([one.off**2 for one in told], axis=0))
    yield ""
    yield (
        f"A camera that is not told is estimated from both outlines and the avatar. It is off by "
        f"{off[0]:.2f} m in its distance and {off[1]:.2f} m in its height (root mean squares); "
        f"the usual camera by {off[2]:.2f} m and {off[3]:.2f} m."
    )


def _helped_lines(trials: Mapping[str, Sequence[Helped]]) -> Iterable[str]:
    yield (
        "| | bodies | all vertices, mm | falls by | trunk and legs, mm | falls by | nearer "
        "| largest miss of an entered length, mm | outlines given less pull "
        "| taken for cloth, mean, mm |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|"
    for words, ones in trials.items():
        if ones:
            yield _row(words, ones)


def _row(words: str, ones: Sequence[Helped]) -> str:
    before, after = (np.array([getattr(one, when) for one in ones]) for when in ("before", "after"))
    means: tuple[Floats, Floats] = before.mean(axis=0) * 1e3, after.mean(axis=0) * 1e3
    cells = [words, str(len(ones))]
    for part in (0, 1):
        cells.append(f"{means[0][part]:.2f} → {means[1][part]:.2f}")
        cells.append(f"{100 * (1 - means[1][part] / means[0][part]):.0f} %")
    cells.append(f"{(after[:, 0] < before[:, 0]).sum()} of {len(ones)}")
    cells.append(f"{1e3 * max(one.miss for one in ones):.2f}")
    cells.append(str(sum(one.pull < 1 for one in ones)))
    cells.append(f"{1e3 * np.mean([one.cloth for one in ones]):.1f}")
    return "| " + " | ".join(cells) + " |"
