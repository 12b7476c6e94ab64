"""How smooth fitted bodies are beside the population's: no lump, no fold.

The tape fit bends bodies. What it could spoil shows in how faces meet: each edge's angle is
compared with the template's, and what differs is averaged over the neighbourhood, so that
a lump of some centimetres stands out from the form that all people have.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont
from scipy.sparse import csr_array

from model.appearance import BACKDROP, SKIN_COLOUR, vertex_normals
from model.cameras import SIDES, project
from model.estimators import Estimator, load_estimators
from model.geometry import Floats, Integers
from model.measurements import BodyKind, MeasurementSet
from model.rendering import Painted, photograph
from model.tape_fit import fit_to_tape
from model.template_mesh import TemplateMesh, load_template_mesh
from model.training.fit_report import EIGHT
from model.training.population import Population, bodies_of
from model.training.population_report import table
from model.training.survey import FROM_SURVEY, SEXES, SURVEY_TAPES, draw_people, load_statistics

PEOPLE = 1000
"""How many are fitted, half of them women."""

SEED = 20261123
"""Not the population's: these people are new."""

SPREADINGS = 8
"""Rounds of averaging with neighbours: on the trunk some 4 cm around."""

FOLDED = np.deg2rad(100)
"""Two faces that meet at a sharper angle than this, and on the template did not, are a fold."""

SHOWN = 6
"""So many of the worst are drawn."""

TILE = (170, 300)
"""Of one picture, in pixels."""


@dataclass(frozen=True, eq=False)
class Smoothness:
    """How bodies are bent.

    Attributes
    ----------
    bending : ndarray of shape (n,), root mean square difference from the template's angles
        between faces, over all edges by their length, in radians.
    lumps : ndarray of shape (n,), the largest such difference of a neighbourhood, in radians.
    places : ndarray of shape (n,), the vertex about which that is.
    folds : ndarray of shape (n,), how many edges of trunk and limbs are folded.
    """

    bending: Floats
    lumps: Floats
    places: Integers
    folds: Integers


class _Creases:
    """The inner edges of a template and the angles at which its faces meet there."""

    def __init__(self, template: TemplateMesh) -> None:
        faces = template.faces.astype(np.int64)
        count = len(template.vertices)
        half_edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
        owner = np.tile(np.arange(len(faces)), 3)
        keys = half_edges.min(axis=1) * count + half_edges.max(axis=1)
        order = np.argsort(keys, kind="stable")
        self.faces = faces
        # The template is closed: every edge comes up twice.
        self.ends = np.sort(half_edges[order[::2]], axis=1)
        self.sides = owner[order].reshape(-1, 2)
        edges = len(self.ends)
        tails, heads = self.ends.T
        self._at_ends = csr_array(
            (np.ones(2 * edges), (np.concatenate([tails, heads]), np.tile(np.arange(edges), 2))),
            shape=(count, edges),
        )
        ring = csr_array(
            (np.ones(2 * edges), (np.concatenate([tails, heads]), np.concatenate([heads, tails]))),
            shape=(count, count),
        )
        self._ring = csr_array(ring / ring.sum(axis=1)[:, None])
        # Ears, lips, fingers and toes are folds by nature.
        smooth = ~template.faces_of("head_neck", "hand", "foot")
        self.may_fold = smooth[self.sides].all(axis=1)
        self.usual = self.angles(template.vertices)
        self.usual_lengths = self._lengths(template.vertices)

    def _lengths(self, vertices: Floats) -> Floats:
        lengths: Floats = np.linalg.norm(np.diff(vertices[self.ends], axis=1)[:, 0], axis=1)
        return lengths

    def angles(self, vertices: Floats) -> Floats:
        """Of one mesh: ndarray of shape (E,), radians, 0 where faces meet flat."""
        a, b, c = (vertices[corner] for corner in self.faces.T)
        normals = np.cross(b - a, c - a)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        one, other = normals[self.sides.T]
        sines = np.linalg.norm(np.cross(one, other), axis=1)
        return np.arctan2(sines, np.einsum("ei,ei->e", one, other))

    def lumps(self, bent: Floats) -> Floats:
        """Root mean squares of what edges are bent, about each vertex: ndarray of shape (V,)."""
        weights = self.usual_lengths
        squares, sums = self._at_ends @ (weights * bent**2), self._at_ends @ weights
        for _ in range(SPREADINGS):
            squares, sums = (half + self._ring @ half for half in (squares, sums))
        pooled: Floats = np.sqrt(squares / sums)
        return pooled


def smoothness(template: TemplateMesh, vertices: Floats) -> Smoothness:
    """How some bodies, ndarray of shape (n, V, 3) in metres, are bent."""
    creases = _Creases(template)
    weights = creases.usual_lengths / creases.usual_lengths.sum()
    bending, lumps, places, folds = [], [], [], []
    for body in vertices:
        angles = creases.angles(body)
        bent = angles - creases.usual
        around = creases.lumps(bent)
        bending.append(np.sqrt(weights @ bent**2))
        lumps.append(around.max())
        places.append(around.argmax())
        new = (angles > FOLDED) & (creases.usual < FOLDED)
        folds.append(np.count_nonzero(new & creases.may_fold))
    return Smoothness(np.array(bending), np.array(lumps), np.array(places), np.array(folds))


def new_people(count: int, seed: int) -> list[tuple[BodyKind, MeasurementSet]]:
    """People drawn from the survey's statistics as the population's were, and what they enter."""
    people: list[tuple[BodyKind, MeasurementSet]] = []
    columns = list(SURVEY_TAPES)
    for number, sex in enumerate(SEXES):
        random = np.random.default_rng([seed, number])
        drawn = draw_people(load_statistics(sex), count // 2, random).values
        for row in drawn:
            values = {}
            for name in EIGHT:
                column, *less = (row[columns.index(each)] for each in FROM_SURVEY[name])
                values[name] = float(column - sum(less))
            people.append((sex, MeasurementSet(values)))
    return people


def fitted_bodies(people: list[tuple[BodyKind, MeasurementSet]]) -> Floats:
    """The tape-fitted bodies of people: ndarray of shape (n, V, 3) of single floats, metres."""
    estimators = load_estimators()
    some: Estimator = next(iter(estimators.values()))
    vertices = np.empty((len(people), *some.template.vertices.shape), dtype=np.float32)
    for row, (kind, asked) in enumerate(people):
        vertices[row] = fit_to_tape(estimators[kind], asked).body.vertices
    return vertices


def smoothness_section(population: Population, docs: Path, count: int = PEOPLE) -> str:
    """The report's paragraphs on smoothness; draws the worst into ``docs/images``."""
    template = load_template_mesh()
    fitted = fitted_bodies(new_people(count, SEED))
    of_fits = smoothness(template, fitted)
    rows = np.arange(0, len(population.sexes), max(1, len(population.sexes) // count))
    bodies = np.concatenate([part.astype(np.float32) for _, part in bodies_of(population, rows)])
    of_bodies = smoothness(template, bodies)
    picture = docs / "images" / "smoothness.jpg"
    worst = {
        "fitted": fitted[np.argsort(-of_fits.lumps)[:SHOWN]],
        "population": bodies[np.argsort(-of_bodies.lumps)[:SHOWN]],
    }
    draw_worst(template, worst).save(picture, quality=80)
    return "\n\n".join(
        [
            f"{len(fitted)} people drawn anew from the survey's statistics (seed {SEED}; index 16 "
            f"to 50) enter {len(EIGHT)} values; their fitted bodies beside {len(bodies)} of the "
            "population. *Bending* is how the angles between faces differ from the template's, "
            "root mean square over the body in degrees; the *worst place* is the neighbourhood of "
            "some centimetres where that is largest; a *fold* is an edge bent by more than "
            f"{np.rad2deg(FOLDED):.0f}° that on the template is not, on trunk and limbs.",
            table(
                _HEAD,
                [_row("fitted to the tape", of_fits), _row("the population", of_bodies)],
            ),
            f"The {SHOWN} with the worst places, fitted (above) and of the population (below):",
            f"![The least smooth bodies, front and profile](images/{picture.name})",
        ]
    )


_HEAD = ["", "bending, mean", "99 %", "worst place, mean", "99 %", "largest", "folds, mean", "most"]


def _row(words: str, found: Smoothness) -> list[str]:
    degrees = np.rad2deg(found.bending), np.rad2deg(found.lumps)
    return [
        words,
        f"{degrees[0].mean():.1f}",
        f"{np.quantile(degrees[0], 0.99):.1f}",
        f"{degrees[1].mean():.1f}",
        f"{np.quantile(degrees[1], 0.99):.1f}",
        f"{degrees[1].max():.1f}",
        f"{found.folds.mean():.1f}",
        f"{found.folds.max()}",
    ]


def draw_worst(template: TemplateMesh, bodies: dict[str, Floats]) -> Image.Image:
    """A sheet of bodies: a row for each name, every body from the front and in profile.

    Parameters
    ----------
    bodies : by name, ndarrays of shape (n, V, 3), metres.

    Raises
    ------
    RenderingUnavailable
        If this machine lacks OSMesa; the message says what is missing.
    """
    wide, high = TILE
    across = max(len(some) for some in bodies.values())
    size = (across * 2 * wide, len(bodies) * (high + 24))
    sheet = Image.new("RGB", size, BACKDROP)
    pen = ImageDraw.Draw(sheet)
    for line, (name, some) in enumerate(bodies.items()):
        top = line * (high + 24)
        pen.text((8, top + 4), name, fill="black", font=ImageFont.load_default(15))
        for place, single in enumerate(some):
            body = single.astype(np.float64)
            normals = vertex_normals(body, template.faces)
            painted = Painted(body, normals, [(template.faces, SKIN_COLOUR)])
            for half, side in enumerate(SIDES):
                picture = photograph(painted, project(body, side, size=TILE), TILE).picture
                sheet.paste(picture, ((2 * place + half) * wide, top + 24))
    return sheet
