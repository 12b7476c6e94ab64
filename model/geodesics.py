"""Shortest ways over triangle meshes of one topology, along strips of triangles.

A geodesic between two points crosses a sequence of triangles, its strip. On every mesh of
the same topology the shortest way within a strip follows by unfolding the strip into the
plane and pulling a thread taut through it (the funnel algorithm of Lee and Preparata 1984,
*Networks* 14). That length is the least of a convex function of where each edge is crossed:
it moves continuously with the mesh, and so does the least over several strips. Knows no
bodies.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from model.geometry import Floats, Integers

Turns = list[tuple[int, bool]]
"""Where a taut thread bends: the crossed edge, and whether at its left end."""

_Flat = tuple[complex, list[complex], list[complex], complex]
"""An unfolded strip: start, left ends and right ends of its edges, stop."""


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


class Bundle:
    """Several legs of a way, each with strips to choose from, unfolded together.

    Parameters
    ----------
    legs : the strips of each leg; of a leg's strips the one with the shortest way counts.
        Each strip crosses one edge at least.
    """

    def __init__(self, legs: Sequence[Sequence[Strip]]) -> None:
        self._spans = list(pairwise(np.cumsum([0, *(len(leg) for leg in legs)]).tolist()))
        self._strips = [strip for leg in legs for strip in leg]
        self._starts = np.cumsum([0, *(len(strip.left) for strip in self._strips)]).tolist()
        self._left = np.concatenate([strip.left for strip in self._strips])
        self._right = np.concatenate([strip.right for strip in self._strips])
        self._ends = np.stack([strip.ends for strip in self._strips])
        self._weights = np.stack([strip.weights for strip in self._strips])
        # Behind each edge lies a triangle. Its third corner is the new end of the next edge,
        # or, behind a strip's last edge, the stop.
        left, right = np.append(self._left[1:], -1), np.append(self._right[1:], -1)
        self._corner = np.where(left == self._left, right, left)
        self._keeps_left = (left == self._left).tolist()
        self._gates = [np.arange(first, last) for first, last in pairwise(self._starts)]

    def lengths(self, vertices: Floats) -> Floats:
        """The length of every leg's shortest way.

        Parameters
        ----------
        vertices : ndarray of shape (B, V, 3).

        Returns
        -------
        ndarray of shape (B, number of legs).
        """
        bodies = (self._shortest(list(self._unfold(body))) for body in vertices)
        return np.array([[length for _, length, _ in legs] for legs in bodies])

    def ways(self, vertices: Floats) -> list[tuple[Strip, Way]]:
        """The shortest way of every leg on one mesh, vertices of shape (V, 3), and its strip."""
        flats = list(self._unfold(vertices))
        chosen, lengths, turns = zip(*self._shortest(flats), strict=True)
        fractions = _crossings([flats[i] for i in chosen], turns)
        edges = np.concatenate([self._gates[i] for i in chosen])
        points = vertices[self._left[edges]]
        points += fractions[:, None] * (vertices[self._right[edges]] - points)
        own_ends = list(chosen)
        ends = np.einsum("sekc,sek->sec", vertices[self._ends[own_ends]], self._weights[own_ends])
        ways = []
        gate = 0
        for i, length, (start, stop) in zip(chosen, lengths, ends, strict=True):
            own = slice(gate, gate + len(self._gates[i]))
            gate = own.stop
            path = np.concatenate([start[None], points[own], stop[None]])
            ways.append((self._strips[i], Way(length, path, fractions[own])))
        return ways

    def _shortest(self, flats: Sequence[_Flat]) -> list[tuple[int, float, Turns]]:
        """Of each leg, the strip with the shortest way, its length and where it bends."""
        found = []
        chords = [abs(stop - start) for start, _, _, stop in flats]
        for first, last in self._spans:
            nearest, *others = sorted(range(first, last), key=chords.__getitem__)
            best = nearest, *_taut(*flats[nearest])
            for strip in others:
                # No thread is shorter than the straight line between its ends.
                if chords[strip] >= best[1]:
                    break
                length, turns = _taut(*flats[strip])
                if length < best[1]:
                    best = strip, length, turns
            found.append(best)
        return found

    def _unfold(self, vertices: Floats) -> Iterator[_Flat]:
        """Each strip in the plane: start, left ends, right ends, stop."""
        left, right, corners = vertices[self._left], vertices[self._right], vertices[self._corner]
        ends = np.einsum("sekc,sek->sec", vertices[self._ends], self._weights)
        firsts, lasts = np.array(self._starts[:-1]), np.array(self._starts[1:]) - 1
        corners[lasts] = ends[:, 1]
        ahead = _beyond(left, right, corners).tolist()
        behind = _beyond(left[firsts], right[firsts], ends[:, 0]).conj().tolist()
        widths = np.linalg.norm(right[firsts] - left[firsts], axis=1).tolist()
        for start, width, first, last in zip(
            behind, widths, firsts.tolist(), lasts.tolist(), strict=True
        ):
            a, b = 0j, complex(width)
            lefts, rights = [a], [b]
            for edge in range(first, last):
                corner = a + (b - a) * ahead[edge]
                if self._keeps_left[edge]:
                    b = corner
                else:
                    a = corner
                lefts.append(a)
                rights.append(b)
            yield width * start, lefts, rights, a + (b - a) * ahead[last]


def _crossings(flats: Sequence[_Flat], turns: Sequence[Turns]) -> Floats:
    """Where taut threads cross their gates, as shares from the left: all gates in one row."""
    # Between two bends a thread is straight; at a bend it passes through the vertex.
    bends: list[complex] = []
    gates: list[int] = []
    at_ends: list[tuple[int, bool]] = []
    count = 0
    for (start, lefts, rights, stop), own in zip(flats, turns, strict=True):
        places = [-1, *(gate for gate, _ in own), len(lefts) - 1]
        corners = [lefts[gate] if at_left else rights[gate] for gate, at_left in own]
        bends += [start, *corners, stop]
        gates += [*(last - first for first, last in pairwise(places)), 0]
        at_ends += [(count + gate, at_left) for gate, at_left in own]
        count += len(lefts)
    left = np.array([point for _, lefts, _, _ in flats for point in lefts])
    right = np.array([point for _, _, rights, _ in flats for point in rights])
    corners_of = np.array(bends)
    origin = np.repeat(corners_of, gates)
    along = np.repeat(np.append(np.diff(corners_of), 0), gates).conj()
    to_left, to_right = ((along * (end - origin)).imag for end in (left, right))
    fractions = np.clip(to_left / np.maximum(to_left - to_right, 1e-300), 0.0, 1.0)
    for gate, at_left in at_ends:
        fractions[gate] = 0.0 if at_left else 1.0
    return fractions


def _beyond(left: Floats, right: Floats, corners: Floats) -> NDArray[np.complex128]:
    """Third corners of triangles, in units of the side from left (0) to right (1).

    The corner lies ahead, on the positive imaginary side.
    """
    side = right - left
    arm = corners - left
    square = np.einsum("ni,ni->n", side, side)
    along = np.einsum("ni,ni->n", side, arm) / square
    across = np.einsum("ni,ni->n", arm, arm) / square - along**2
    return along + 1j * np.sqrt(np.maximum(across, 0.0))


def _taut(
    start: complex, lefts: list[complex], rights: list[complex], stop: complex
) -> tuple[float, Turns]:
    """The length of the thread from start to stop through all gates, and where it bends."""
    lefts, rights = [*lefts, stop], [*rights, stop]
    total = 0.0
    turns: Turns = []
    tip = start
    left, right, left_at, right_at = lefts[0], rights[0], 0, 0
    gate = 1
    while gate < len(lefts):
        # The imaginary part of conj(u) * v is positive where v points to the left of u.
        arm = rights[gate] - tip
        if ((right - tip).conjugate() * arm).imag >= 0:
            if right == tip or ((left - tip).conjugate() * arm).imag < 0:
                right, right_at = rights[gate], gate
            else:
                total += abs(left - tip)
                turns.append((left_at, True))
                tip = right = left
                gate = right_at = left_at
                gate += 1
                continue
        arm = lefts[gate] - tip
        if ((left - tip).conjugate() * arm).imag <= 0:
            if left == tip or ((right - tip).conjugate() * arm).imag > 0:
                left, left_at = lefts[gate], gate
            else:
                total += abs(right - tip)
                turns.append((right_at, False))
                tip = left = right
                gate = left_at = right_at
                gate += 1
                continue
        gate += 1
    # The last gate is the stop, where a thread ends and does not bend.
    return total + abs(stop - tip), [turn for turn in turns if turn[0] < len(lefts) - 1]
