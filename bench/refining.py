"""How much outlines help, in clothes and without: the second part of `bench.silhouettes`.

The same photos of a person are tried with more and with fewer entered values, and with and without
the person's word on what is worn.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bench.outlines import CLOTHED, NOISE, SIDES, SKIRT, TROUSERS, held_out, photographed, values_of
from model.anthropometry import measure_batch
from model.camera_estimate import estimate_camera
from model.cameras import Side
from model.comparison import EDGE_LEVELS
from model.geometry import Booleans, Floats
from model.refinement import Worn, refine
from model.tape_fit import fit_to_tape
from model.training.validation import ENTERED

EIGHT = ENTERED["the eight that the paper evaluates"]
FEW = ("stature", "weight", "bust_girth", "hip_girth")

JUDGED = ("waist_girth", "thigh_girth")
ODD = 1.5
"""A waist or a thigh is unusual that is so many deviations from what the law of people leads to
expect of whoever has the entered values."""


@dataclass(frozen=True)
class Scene:
    """How people are photographed; see `bench.outlines.roughened`."""

    noise: float = NOISE
    cloth: float = 0.0
    hangs: tuple[float, float] = CLOTHED


@dataclass(frozen=True)
class Try:
    """What is done with their photos.

    entered : what they entered.
    said : what they say they wear, if anything.
    sides : the photos that are used.
    placed : whether the camera is told.
    """

    entered: Sequence[str] = EIGHT
    said: Worn | None = None
    sides: Sequence[Side] = SIDES
    placed: bool = True


PLAIN = Scene()
EVERYBODY = {
    "8 measurements entered": Try(),
    "4 entered: stature, weight, bust, hips": Try(FEW),
}
FURTHER: Sequence[tuple[Scene, Mapping[str, Try]]] = (
    (
        PLAIN,
        {
            "8 entered, the camera estimated": Try(placed=False),
            "4 entered, from the front alone": Try(FEW, sides=("front",)),
        },
    ),
    (Scene(noise=3 * NOISE), {"8 entered, three times the noise": Try()}),
    (
        Scene(cloth=0.02),
        {
            "8 entered, in clothes that stand off by 2 cm": Try(),
            "8 entered, in those clothes, told to be loose": Try(said="loose"),
            "4 entered, in clothes that stand off by 2 cm": Try(FEW),
            "4 entered, in those clothes, told to be loose": Try(FEW, "loose"),
        },
    ),
    (
        Scene(cloth=0.03, hangs=TROUSERS),
        {
            "4 entered, in trousers that stand off by 3 cm": Try(FEW),
            "4 entered, in those trousers, told to be loose": Try(FEW, "loose_legs"),
        },
    ),
    (
        Scene(cloth=0.04, hangs=SKIRT),
        {
            "4 entered, in a skirt that stands off by 4 cm": Try(FEW),
            "4 entered, in that skirt, told to be loose": Try(FEW, "loose_legs"),
            "4 entered, in that skirt, from the front alone": Try(FEW, sides=("front",)),
            "4 entered, in that skirt, from the front alone, told": Try(
                FEW, "loose_legs", ("front",)
            ),
        },
    ),
)


@dataclass(frozen=True)
class Helped:
    """One body refined.

    before, after : mean distance of all vertices, of trunk and legs, and how far waist and thigh
        are off, their mean, in metres.
    miss : the largest of an entered length, in metres.
    pull : see `model.refinement.Refined`.
    cloth : what was taken for cloth, the mean of all levels, in metres.
    wider : by how much the worst girth of trunk and legs is larger than it was before, and than
        the person's, in metres; 0 where none is.
    """

    before: tuple[float, float, float]
    after: tuple[float, float, float]
    miss: float
    pull: float
    cloth: float
    wider: float


def help_with(row: int, seed: int, scene: Scene, tries: Mapping[str, Try]) -> dict[str, Helped]:
    """Refines one body by the same photos in several ways."""
    estimator, body, random = held_out(row, seed)
    photos, _ = photographed(body, random, scene.noise, scene.cloth, scene.hangs)
    template = body.template
    seen = np.unique(template.faces[template.faces_of("torso", "upper_leg", "lower_leg")])
    results = {}
    for words, way in tries.items():
        asked = values_of(body, way.entered)
        used = [photo for photo in photos if photo.side in way.sides]
        first = fit_to_tape(estimator, asked).body
        if not way.placed:
            camera = estimate_camera({photo.side: photo.mask for photo in used}, first)
            used = [replace(photo, camera=camera) for photo in used]
        refined = refine(estimator, asked, used, way.said)
        bodies = np.stack([one.vertices for one in (body, first, refined.fit.body)])
        girths = measure_batch(template, bodies, EDGE_LEVELS)
        off = np.abs(girths[1:] - girths[0])[:, [EDGE_LEVELS.index(name) for name in JUDGED]]
        before, after = (
            (float(apart.mean()), float(apart[seen].mean()), float(miss.mean()))
            for apart, miss in zip(np.linalg.norm(bodies[1:] - bodies[0], axis=2), off, strict=True)
        )
        lengths = [abs(miss) for name, miss in refined.fit.misses.items() if name != "weight"]
        results[words] = Helped(
            before,
            after,
            miss=max(lengths),
            pull=refined.pull,
            cloth=float(refined.cloth.mean()),
            wider=max(0.0, float((girths[2] - girths[:2].max(axis=0)).max())),
        )
    return results


def unusual(rows: Sequence[int], entered: Sequence[str]) -> Booleans:
    """Which bodies have a waist or a thigh unlike what their entered values lead to expect."""
    odd = []
    for row in rows:
        estimator, body, _ = held_out(row, 0)
        given = estimator.law.given(values_of(body, entered))
        own = values_of(body, JUDGED)
        odd.append(max(abs(given.score(name, value)) for name, value in own.items()) > ODD)
    return np.array(odd)


def left_over(before: Floats, after: Floats) -> tuple[float, float]:
    """The share of the mean distance, (n,) each, that is left, and its standard error.

    That is of a ratio of sums (Cochran 1977, *Sampling Techniques*, chapter 6).
    """
    share = float(after.sum() / before.sum())
    return share, float(np.linalg.norm(after - share * before) / before.sum())


def table(trials: Mapping[str, Sequence[Helped]]) -> Iterable[str]:
    """Its lines."""
    yield (
        "| | bodies | all vertices, mm | falls by | trunk and legs, mm | falls by "
        "| waist and thigh off by, mean, mm | nearer "
        "| largest miss of an entered length, mm | outlines given less pull "
        "| taken for cloth, mean, mm | worst girth too wide by, mean (most), mm |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|---|---|"
    for words, ones in trials.items():
        if ones:
            yield _row(words, ones)


def _row(words: str, ones: Sequence[Helped]) -> str:
    before, after = (np.array([getattr(one, when) for one in ones]) for when in ("before", "after"))
    cells = [words, str(len(ones))]
    for one, other in zip(before.T[:2], after.T[:2], strict=True):
        left, error = left_over(one, other)
        cells.append(f"{1e3 * one.mean():.2f} → {1e3 * other.mean():.2f}")
        cells.append(f"{100 * (1 - left):.0f} ± {100 * error:.0f} %")
    cells.append(f"{1e3 * before[:, 2].mean():.1f} → {1e3 * after[:, 2].mean():.1f}")
    cells.append(f"{(after[:, 0] < before[:, 0]).sum()} of {len(ones)}")
    cells.append(f"{1e3 * max(one.miss for one in ones):.2f}")
    cells.append(str(sum(one.pull < 1 for one in ones)))
    cells.append(f"{1e3 * np.mean([one.cloth for one in ones]):.1f}")
    wider = 1e3 * np.array([one.wider for one in ones])
    cells.append(f"{wider.mean():.0f} ({wider.max():.0f})")
    return "| " + " | ".join(cells) + " |"
