"""Tapes as smooth functions of a body, for those who bend bodies.

A girth that is the widest or the narrowest of several planes has a kink wherever another
plane takes over. Plane by plane it is smooth: the pieces of the widest must not exceed a
value, and one of them must reach it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.anthropometry import read_tapes, tape_gradients
from model.geometry import Floats, Hulls, Integers
from model.girths import Girth, gradients, tie
from model.tapes import Tape
from model.template_mesh import Gradient, TemplateMesh


@dataclass(frozen=True, eq=False)
class Reading:
    """What the pieces of some tapes measure on one body.

    Attributes
    ----------
    values : ndarray of shape (P,), SI.
    chosen : ndarray of shape (n,), the piece that counts of each tape.
    hulls : of the girths' planes; None where there is no girth.
    slopes : derivatives of the tapes that are no girths, where they were wanted.
    """

    values: Floats
    chosen: Integers
    hulls: Hulls | None
    slopes: list[Gradient]


class TapePieces:
    """The smooth pieces of some tapes on one template: tapes that are no girths come first.

    Attributes
    ----------
    owner : ndarray of shape (P,), the tape that each piece belongs to, by its place.
    sense : ndarray of shape (P,), 1 for pieces of the widest, -1 of the narrowest, 0 of tapes
        with one piece.
    """

    def __init__(self, template: TemplateMesh, tapes: Sequence[Tape]) -> None:
        self.template = template
        girths = {i: tape for i, tape in enumerate(tapes) if isinstance(tape, Girth)}
        others = {i: tape for i, tape in enumerate(tapes) if i not in girths}
        self._girths, self._others = list(girths.values()), list(others.values())
        self._girth_places = np.array(list(girths), dtype=np.int64)
        self._other_places = np.array(list(others), dtype=np.int64)
        planes = np.array([girth.planes for girth in self._girths], dtype=np.int64)
        senses = [1.0 if girth.pick == "widest" else -1.0 for girth in self._girths]
        self._firsts = np.cumsum(planes) - planes
        self.owner = np.concatenate([self._other_places, np.repeat(self._girth_places, planes)])
        self.sense = np.concatenate([np.zeros(len(others)), np.repeat(senses, planes)])

    def read(self, vertices: Floats, *, with_slopes: bool = False) -> Reading:
        """Reads every piece on one body, vertices of shape (V, 3) in metres."""
        count = len(self._others)
        values = np.empty(len(self.owner))
        chosen = np.empty(count + len(self._girths), dtype=np.int64)
        slopes: list[Gradient] = []
        hulls = None
        if with_slopes:
            readings = tape_gradients(self.template, vertices, self._others)
            values[:count] = [value for value, _ in readings]
            slopes = [gradient for _, gradient in readings]
        elif self._others:
            values[:count] = read_tapes(self.template, vertices[None], self._others)[0]
        chosen[self._other_places] = np.arange(count)
        if self._girths:
            hulls, rows = tie(self.template, vertices[None], self._girths)
            values[count:] = hulls.perimeters
            chosen[self._girth_places] = count + rows[0]
        return Reading(values, chosen, hulls, slopes)

    def gradients(self, vertices: Floats, reading: Reading, pieces: Integers) -> list[Gradient]:
        """The derivatives of some pieces, in the order of `pieces`.

        Parameters
        ----------
        vertices : ndarray of shape (V, 3), metres.
        pieces : ndarray of shape (n,), which.
        reading : of the same body; with slopes, where pieces of tapes that are no girths are
            among those wanted.
        """
        count = len(self._others)
        wanted: dict[int, Gradient] = {
            piece: reading.slopes[piece] for piece in pieces.tolist() if piece < count
        }
        rows = pieces[pieces >= count] - count
        if reading.hulls is not None and len(rows):
            places = np.searchsorted(self._firsts, rows, side="right") - 1
            chosen = zip(places.tolist(), (rows - self._firsts[places]).tolist(), strict=True)
            slopes = gradients(self.template, vertices, self._girths, reading.hulls, list(chosen))
            wanted |= zip((rows + count).tolist(), slopes, strict=True)
        return [wanted[piece] for piece in pieces.tolist()]
