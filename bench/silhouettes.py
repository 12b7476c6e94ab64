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
from joblib import Memory, Parallel, delayed
from threadpoolctl import threadpool_limits

from bench.outlines import SIDES, held_out, photographed, values_of
from bench.refining import EIGHT, EVERYBODY, FEW, FURTHER, PLAIN, Helped, help_with, table, unusual
from model.camera_estimate import estimate_camera
from model.cameras import USUAL_CAMERA, Side
from model.comparison import Comparison, compare
from model.geometry import Floats
from model.measurements import MeasurementSet
from model.refinement import Photo
from model.tape_fit import Likely, fit_to_tape
from model.template_mesh import Body
from model.training.population import load_population

WAIST = 1.1

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


def main(arguments: Sequence[str]) -> None:
    """Runs all trials and prints their tables."""
    parser = argparse.ArgumentParser(prog="python -m bench silhouettes", description=__doc__)
    parser.add_argument("--known", type=int, default=50, help="bodies to be told apart")
    parser.add_argument("--bodies", type=int, default=200, help="bodies to be refined")
    parser.add_argument("--others", type=int, default=40, help="bodies of each further trial")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--keep", metavar="FOLDER", help="goes on from what is there: --keep=FOLDER"
    )
    parser.add_argument("--write", action="store_true", help=f"into {PAGE.name} too")
    options = parser.parse_args(arguments)
    rows = chosen(max(options.known, options.bodies), options.seed)
    told = _each("telling apart", tell, rows[: options.known], options)
    # What is tried with everybody, and with some.
    trials = _together(
        _each("refining", help_with, rows[: options.bodies], options, PLAIN, EVERYBODY)
    )
    odd, few = unusual(rows[: options.bodies], FEW), list(trials.values())[-1]
    for words, wanted in (("unusual", True), ("usual", False)):
        trials[f"of those, {words} waist or thighs"] = [
            one for one, is_odd in zip(few, odd.tolist(), strict=True) if is_odd == wanted
        ]
    count = min(options.others, options.bodies)
    for scene, tries in FURTHER:
        words = next(iter(tries))
        trials |= _together(_each(words, help_with, rows[:count], options, scene, tries))
    said = [one for one in arguments if not one.startswith("--keep")]
    text = "\n".join(
        [
            *_told_lines(told),
            "",
            *table(trials),
            "",
            f"`python -m bench silhouettes {' '.join(said)}`".replace(" `", "`")
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
    estimator, body, random = held_out(row, seed)
    asked = values_of(body, EIGHT)
    photos, rough = photographed(body, random)
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
    *how: Any,
) -> list[Any]:
    """A task for every row, side by side, with the progress on the error stream."""
    results = []
    # Remembered by what was asked, not by the code that answers: a new code needs a new folder.
    remembered = Memory(options.keep, verbose=0).cache(task)
    jobs = (delayed(_alone)(remembered, row, options.seed, *how) for row in rows)
    for done in Parallel(n_jobs=options.processes, return_as="generator")(jobs):
        results.append(done)
        print(f"\r{words}: {len(results)} of {len(rows)} ", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return results


def _alone(task: Callable[..., Any], row: int, seed: int, *how: Any) -> Any:
    with threadpool_limits(1):
        return task(row, seed, *how)


def _together(ones: Sequence[Mapping[str, Helped]]) -> dict[str, list[Helped]]:
    """What was tried with each body, by what was tried."""
    return {words: [one[words] for one in ones] for words in ones[0]}


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
