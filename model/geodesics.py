"""Shortest ways over triangle meshes of one topology, along strips of triangles.

A geodesic between two points crosses a sequence of triangles, its strip. On every mesh of
the same topology the shortest way within a strip follows by unfolding the strip into the
plane and pulling a thread taut through it (Lee and Preparata 1984, *Networks* 14; here not gate
by gate but for all strips at once). That length is the least of a convex function of where each
edge is crossed: it moves continuously with the mesh, and so does the least over several strips.
Knows no bodies.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from model.geometry import Floats, Integers

Complexes = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Strip:
    """The triangles that a way runs over, as the edges that it crosses in turn.

    Attributes
    ----------
    left, right : ndarrays of shape (n,), the end vertices of each crossed edge, as seen from
        outside the mesh by one who goes along. Neighbouring edges share one vertex.
    ends : ndarray of shape (2, 3), three vertices around the way's start and its stop.
    weights : ndarray of shape (2, 3), barycentric coordinates: start and stop as sums of these.
    """

    left: Integers
    right: Integers
    ends: Integers
    weights: Floats


Strips = Mapping[tuple[str, str], tuple[Strip, ...]]
"""The strips of a way, by the names of its start and stop."""


def save_strips(path: Path, strips: Strips) -> None:
    """Writes strips as npz."""
    every = [strip for several in strips.values() for strip in several]
    np.savez_compressed(
        path,
        names=np.array(list(strips)),
        counts=np.array([len(several) for several in strips.values()]),
        edges=np.array([len(strip.left) for strip in every]),
        left=np.concatenate([strip.left for strip in every]).astype(np.int32),
        right=np.concatenate([strip.right for strip in every]).astype(np.int32),
        ends=np.array([strip.ends for strip in every], dtype=np.int32),
        weights=np.array([strip.weights for strip in every]),
    )


def load_strips(path: Path) -> Strips:
    """Reads what :func:`save_strips` wrote.

    Raises
    ------
    FileNotFoundError
        Where the file is missing; the message names it.
    """
    with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
        cuts = np.cumsum(arrays["edges"])[:-1]
        every = [
            Strip(left, right, ends, weights)
            for left, right, ends, weights in zip(
                np.split(arrays["left"].astype(np.int64), cuts),
                np.split(arrays["right"].astype(np.int64), cuts),
                arrays["ends"].astype(np.int64),
                arrays["weights"],
                strict=True,
            )
        ]
        firsts = np.cumsum([0, *arrays["counts"]]).tolist()
        return {
            (str(start), str(stop)): tuple(every[firsts[i] : firsts[i + 1]])
            for i, (start, stop) in enumerate(arrays["names"])
        }


@dataclass(frozen=True)
class Way:
    """A shortest way within a strip.

    Attributes
    ----------
    length : in the mesh's unit.
    points : ndarray of shape (n + 2, 3), the start, where each edge is crossed, and the stop.
    fractions : ndarray of shape (n,), where each edge is crossed, from its left end.
    """

    length: float
    points: Floats
    fractions: Floats


def length_gradient(strip: Strip, way: Way) -> tuple[Integers, Floats]:
    """The derivative of a way's length by the mesh.

    Where edges are crossed is held: the length is least there, so that its slope is 0.

    Returns
    -------
    indices : ndarray of shape (2n + 6,), vertex indices; an index may come up repeatedly.
    gradient : ndarray of shape (2n + 6, 3), to be added up by vertex.
    """
    steps = np.diff(way.points, axis=0)
    lengths = np.linalg.norm(steps, axis=1, keepdims=True)
    towards = np.divide(steps, lengths, out=np.zeros_like(steps), where=lengths > 0)
    inner = towards[:-1] - towards[1:]
    fractions = way.fractions[:, None]
    gradient = np.concatenate(
        [
            (1 - fractions) * inner,
            fractions * inner,
            -strip.weights[0][:, None] * towards[0],
            strip.weights[1][:, None] * towards[-1],
        ]
    )
    return np.concatenate([strip.left, strip.right, *strip.ends]), gradient


@dataclass(frozen=True, eq=False)
class _Flat:
    """Unfolded strips of several meshes, as points of the complex plane.

    Attributes
    ----------
    starts, stops : ndarrays of shape (B, S).
    lefts, rights : ndarrays of shape (B, E), the ends of all edges, those of one strip after
        those of another.
    """

    starts: Complexes
    lefts: Complexes
    rights: Complexes
    stops: Complexes


class Bundle:
    """Several legs of a way, each with strips to choose from, unfolded together.

    Parameters
    ----------
    legs : the strips of each leg; of a leg's strips the one with the shortest way counts.
        Each strip crosses one edge at least.
    """

    def __init__(self, legs: Sequence[Sequence[Strip]]) -> None:
        self._legs = [slice(*ends) for ends in pairwise(accumulate(map(len, legs), initial=0))]
        self._strips = [strip for leg in legs for strip in leg]
        sizes = np.array([len(strip.left) for strip in self._strips])
        ends = np.cumsum(sizes)
        self._firsts, self._lasts = ends - sizes, ends - 1
        self._left = np.concatenate([strip.left for strip in self._strips])
        self._right = np.concatenate([strip.right for strip in self._strips])
        self._ends = np.stack([strip.ends for strip in self._strips])
        self._weights = np.stack([strip.weights for strip in self._strips])
        # Behind each edge lies a triangle. Its third corner is the new end of the next edge,
        # or, behind a strip's last edge, the stop.
        left, right = np.append(self._left[1:], -1), np.append(self._right[1:], -1)
        self._corner = np.where(left == self._left, right, left)
        self._keeps_left = left == self._left
        # Where each edge lies in a table of strips by gates.
        self._table = len(sizes), sizes.max()
        self._places = np.arange(ends[-1]) + np.repeat(
            np.arange(len(sizes)) * sizes.max() - self._firsts, sizes
        )
        # The gate since which the right end is the same vertex: rounded once, it stays one point.
        gates = np.arange(ends[-1]) - np.repeat(self._firsts, sizes)
        since = np.zeros(self._table, dtype=np.int64)
        new = (gates == 0) | np.roll(self._keeps_left, 1)
        since.ravel()[self._places] = np.where(new, gates, 0)
        since = np.maximum.accumulate(since, axis=1) + sizes.max() * np.arange(len(sizes))[:, None]
        self._right_since = since.ravel()[self._places]

    def lengths(self, vertices: Floats) -> Floats:
        """The length of every leg's shortest way.

        Parameters
        ----------
        vertices : ndarray of shape (B, V, 3).

        Returns
        -------
        ndarray of shape (B, number of legs).
        """
        lengths, _ = _taut(self._unfold(vertices), self._firsts)
        return np.stack([lengths[:, leg].min(axis=1) for leg in self._legs], axis=1)

    def ways(self, vertices: Floats) -> list[tuple[Strip, Way]]:
        """The shortest way of every leg on one mesh, vertices of shape (V, 3), and its strip."""
        (lengths,), (fractions,) = _taut(self._unfold(vertices[None]), self._firsts)
        points = vertices[self._left]
        points += fractions[:, None] * (vertices[self._right] - points)
        ends = self._end_points(vertices[None])[0]
        ways = []
        for leg in self._legs:
            strip = leg.start + int(lengths[leg].argmin())
            own = slice(self._firsts[strip], self._lasts[strip] + 1)
            path = np.concatenate([ends[strip, :1], points[own], ends[strip, 1:]])
            ways.append((self._strips[strip], Way(float(lengths[strip]), path, fractions[own])))
        return ways

    def _end_points(self, vertices: Floats) -> Floats:
        """The start and the stop of each strip: (B, V, 3) to (B, S, 2, 3)."""
        return np.einsum("bsekc,sek->bsec", vertices[:, self._ends], self._weights)

    def _unfold(self, vertices: Floats) -> _Flat:
        """Each strip in the plane, on meshes of shape (B, V, 3)."""
        left, right, corners = (
            vertices.take(ends, axis=1) for ends in (self._left, self._right, self._corner)
        )
        ends = self._end_points(vertices)
        corners[:, self._lasts] = ends[:, :, 1]
        ahead = _beyond(left, right, corners)
        left, right = left[:, self._firsts], right[:, self._firsts]
        behind = _beyond(left, right, ends[:, :, 0]).conj()
        # Seen from its left end, the next edge is this one turned and stretched.
        table = (len(vertices), *self._table)
        turns, shifts = np.ones(table, dtype=complex), np.zeros(table, dtype=complex)
        turns.reshape(len(vertices), -1)[:, self._places] = np.where(
            self._keeps_left, ahead, 1 - ahead
        )
        shifts.reshape(len(vertices), -1)[:, self._places] = np.where(self._keeps_left, 0, ahead)
        widths = np.linalg.norm(right - left, axis=-1)
        sides = np.empty(table, dtype=complex)
        sides[..., 0] = widths
        np.multiply(widths[..., None], np.cumprod(turns[..., :-1], axis=-1), out=sides[..., 1:])
        lefts = np.zeros(table, dtype=complex)
        np.cumsum(sides[..., :-1] * shifts[..., :-1], axis=-1, out=lefts[..., 1:])
        # From here on in rows of gates.
        rights = (lefts + sides).reshape(len(vertices), -1)[:, self._right_since]
        lefts, sides = (
            values.reshape(len(vertices), -1)[:, self._places] for values in (lefts, sides)
        )
        stops = lefts[:, self._lasts] + sides[:, self._lasts] * ahead[:, self._lasts]
        return _Flat(widths * behind, lefts, rights, stops)


def _beyond(left: Floats, right: Floats, corners: Floats) -> Complexes:
    """Third corners of triangles, in units of the side from left (0) to right (1).

    The corner lies ahead, on the positive imaginary side.
    """
    side = right - left
    arm = corners - left
    square = np.einsum("...i,...i->...", side, side)
    along = np.einsum("...i,...i->...", side, arm) / square
    across = np.einsum("...i,...i->...", arm, arm) / square - along**2
    return along + 1j * np.sqrt(np.maximum(across, 0.0))


def _taut(flat: _Flat, firsts: Integers) -> tuple[Floats, Floats]:
    """Pulls threads taut through the gates of strips, all of them together.

    Of the gates that a straight thread would miss, it bends at the one that lies furthest beside
    it, on either side: there a way must go at least that far aside, and where it goes furthest
    it turns around the end of a gate. The same holds of each piece between two bends. (Of a strip
    that turns back on itself, as over skin that is rough by millimetres from vertex to vertex, a
    longer way may be found.)

    Parameters
    ----------
    flat : S strips with E gates in all on B meshes.
    firsts : ndarray of shape (S,), the first gate of each strip.

    Returns
    -------
    lengths : ndarray of shape (B, S).
    fractions : ndarray of shape (B, E), where each gate is passed, from its left end.
    """
    meshes, gates = flat.lefts.shape
    strips = len(firsts)
    # Each thread begins before its gates and ends behind them, in points without width.
    begins = firsts + 2 * np.arange(strips)
    ends = np.append(begins[1:], gates + 2 * strips) - 1
    within = np.ones(gates + 2 * strips, dtype=bool)
    within[begins] = within[ends] = False
    lefts = np.empty((meshes, len(within)), dtype=complex)
    lefts[:, begins], lefts[:, within], lefts[:, ends] = flat.starts, flat.lefts, flat.stops
    rights = lefts.copy()
    rights[:, within] = flat.rights
    left, right = lefts.ravel(), rights.ravel()
    last = np.zeros(len(within), dtype=bool)
    last[ends] = True
    last = np.tile(last, meshes)
    bent = np.tile(~within, meshes)
    around_right = np.zeros(len(bent), dtype=bool)
    while True:
        bends = np.flatnonzero(bent)
        corners = left[bends]
        steps = np.append(corners[1:] - corners[:-1], 0)
        steps[last[bends]] = 0
        piece = np.cumsum(bent) - 1
        origin, along = corners[piece], steps.conj()[piece]
        # The imaginary part of conj(u) * v is positive where v points to the left of u.
        to_left, to_right = ((along * (end - origin)).imag for end in (left, right))
        beside_left = np.minimum(np.minimum.reduceat(to_left, bends), -1e-300)
        beside_right = np.maximum(np.maximum.reduceat(to_right, bends), 1e-300)
        new_left = np.flatnonzero(to_left <= beside_left[piece])
        new_right = np.flatnonzero(to_right >= beside_right[piece])
        if not len(new_left) and not len(new_right):
            break
        # Where a thread bends a gate has no width any more.
        right[new_left] = left[new_left]
        left[new_right] = right[new_right]
        around_right[new_right], around_right[new_left] = True, False
        bent[new_left] = bent[new_right] = True
    lengths = np.add.reduceat(np.abs(steps), np.append(0, np.flatnonzero(last[bends])[:-1] + 1))
    fractions = np.clip(to_left / np.maximum(to_left - to_right, 1e-300), 0.0, 1.0)
    fractions[around_right] = 1.0
    return lengths.reshape(meshes, strips), fractions.reshape(meshes, -1)[:, within]
