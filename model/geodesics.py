"""Shortest ways over triangle meshes of one topology, along strips of triangles.

A geodesic between two points crosses a sequence of triangles, its strip. On every mesh of
the same topology the shortest way within a strip follows by unfolding the strip into the
plane and pulling a thread taut through it (the funnel algorithm of Lee and Preparata 1984,
*Networks* 14). That length is the least of a convex function of where each edge is crossed:
it moves continuously with the mesh, and so does the least over several strips. Knows no
bodies.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from model.geometry import Booleans, Floats, Integers

Complexes = NDArray[np.complex128]

Turns = list[tuple[int, bool]]
"""Where a taut thread bends: the crossed edge, and whether at its left end."""


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
    """Unfolded strips of several meshes.

    Attributes
    ----------
    starts, stops : ndarrays of shape (B, S), points of the complex plane.
    lefts, rights : ndarrays of shape (B, S, L), the ends of the edges; of a strip with fewer than
        L, those behind its last mean nothing.
    chords : ndarray of shape (B, S), the distance from start to stop.
    straight : ndarray of shape (B, S), whether the straight line passes through all gates.
    """

    starts: Complexes
    lefts: Complexes
    rights: Complexes
    stops: Complexes
    chords: Floats
    straight: Booleans


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
        sizes = np.array([len(strip.left) for strip in self._strips])
        ends = np.cumsum(sizes)
        self._sizes, self._firsts, self._lasts = sizes.tolist(), ends - sizes, ends - 1
        self._left = np.concatenate([strip.left for strip in self._strips])
        self._right = np.concatenate([strip.right for strip in self._strips])
        self._ends = np.stack([strip.ends for strip in self._strips])
        self._weights = np.stack([strip.weights for strip in self._strips])
        # Behind each edge lies a triangle. Its third corner is the new end of the next edge,
        # or, behind a strip's last edge, the stop.
        left, right = np.append(self._left[1:], -1), np.append(self._right[1:], -1)
        self._corner = np.where(left == self._left, right, left)
        self._keeps_left = left == self._left
        # Where each edge lies in a table of strips by gates, and which places of it are none.
        self._places = np.arange(ends[-1]) + np.repeat(
            np.arange(len(sizes)) * sizes.max() - self._firsts, sizes
        )
        self._none = np.arange(sizes.max()) >= sizes[:, None]
        # The gate since which the right end is the same vertex: rounded once, it stays one point.
        gates = np.arange(ends[-1]) - np.repeat(self._firsts, sizes)
        since = np.zeros(self._none.shape, dtype=np.int64)
        new = (gates == 0) | np.roll(self._keeps_left, 1)
        since.ravel()[self._places] = np.where(new, gates, 0)
        self._right_since = np.maximum.accumulate(since, axis=1)

    def lengths(self, vertices: Floats) -> Floats:
        """The length of every leg's shortest way.

        Parameters
        ----------
        vertices : ndarray of shape (B, V, 3).

        Returns
        -------
        ndarray of shape (B, number of legs).
        """
        flat = self._unfold(vertices)
        return np.array(
            [[length for _, length, _ in self._shortest(flat, i)] for i in range(len(vertices))]
        )

    def ways(self, vertices: Floats) -> list[tuple[Strip, Way]]:
        """The shortest way of every leg on one mesh, vertices of shape (V, 3), and its strip."""
        flat = self._unfold(vertices[None])
        chosen, lengths, turns = zip(*self._shortest(flat, 0), strict=True)
        own_strips = list(chosen)
        own_gates = ~self._none[own_strips]
        sizes = [self._sizes[strip] for strip in chosen]
        fractions = _crossings(
            flat.starts[0, own_strips],
            flat.lefts[0, own_strips][own_gates],
            flat.rights[0, own_strips][own_gates],
            flat.stops[0, own_strips],
            sizes,
            turns,
        )
        left = np.concatenate([self._strips[strip].left for strip in chosen])
        right = np.concatenate([self._strips[strip].right for strip in chosen])
        points = vertices[left]
        points += fractions[:, None] * (vertices[right] - points)
        ends = self._end_points(vertices[None])[0]
        ways = []
        gate = 0
        for strip, length, size in zip(chosen, lengths, sizes, strict=True):
            own = slice(gate, gate + size)
            gate = own.stop
            path = np.concatenate([ends[strip, :1], points[own], ends[strip, 1:]])
            ways.append((self._strips[strip], Way(length, path, fractions[own])))
        return ways

    def _shortest(self, flat: _Flat, body: int) -> list[tuple[int, float, Turns]]:
        """Of each leg, the strip with the shortest way, its length and where it bends."""
        found = []
        chords, straight = flat.chords[body].tolist(), flat.straight[body].tolist()
        for first, last in self._spans:
            best: tuple[int, float, Turns] = first, np.inf, []
            for strip in sorted(range(first, last), key=chords.__getitem__):
                # No thread is shorter than the straight line between its ends.
                if chords[strip] >= best[1]:
                    break
                if straight[strip]:
                    best = strip, chords[strip], []
                    break
                gates = slice(self._sizes[strip])
                length, turns = _taut(
                    complex(flat.starts[body, strip]),
                    flat.lefts[body, strip, gates].tolist(),
                    flat.rights[body, strip, gates].tolist(),
                    complex(flat.stops[body, strip]),
                )
                if length < best[1]:
                    best = strip, length, turns
            found.append(best)
        return found

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
        table = (len(vertices), *self._none.shape)
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
        strips, gates = np.arange(len(self._sizes)), self._lasts - self._firsts
        stops = lefts[:, strips, gates] + sides[:, strips, gates] * ahead[:, self._lasts]
        starts = widths * behind
        rights = (lefts + sides)[:, strips[:, None], self._right_since]
        along = (stops - starts).conj()[..., None]
        from_start = starts[..., None]
        passed = (np.imag(along * (lefts - from_start)) >= 0) & (
            np.imag(along * (rights - from_start)) <= 0
        )
        return _Flat(
            starts, lefts, rights, stops, np.abs(stops - starts), (passed | self._none).all(axis=-1)
        )


def _crossings(
    starts: Complexes,
    left: Complexes,
    right: Complexes,
    stops: Complexes,
    sizes: Sequence[int],
    turns: Sequence[Turns],
) -> Floats:
    """Where taut threads cross their gates, as shares from the left: all gates in one row.

    Parameters
    ----------
    starts, stops : of each thread.
    left, right : of all gates, those of one thread after those of another.
    sizes : how many gates each thread has.
    turns : where each bends.
    """
    # Between two bends a thread is straight; at a bend it passes through the vertex.
    bends: list[complex] = []
    gates: list[int] = []
    at_ends: list[tuple[int, bool]] = []
    first = 0
    for start, stop, size, own in zip(starts.tolist(), stops.tolist(), sizes, turns, strict=True):
        here = [(first + gate, at_left) for gate, at_left in own]
        places = [first - 1, *(gate for gate, _ in here), first + size - 1]
        bends += [start, *((left if at_left else right)[gate] for gate, at_left in here), stop]
        gates += [*(last - before for before, last in pairwise(places)), 0]
        at_ends += here
        first += size
    corners = np.array(bends)
    origin = np.repeat(corners, gates)
    along = np.repeat(np.append(np.diff(corners), 0), gates).conj()
    to_left, to_right = ((along * (end - origin)).imag for end in (left, right))
    fractions = np.clip(to_left / np.maximum(to_left - to_right, 1e-300), 0.0, 1.0)
    for gate, at_left in at_ends:
        fractions[gate] = 0.0 if at_left else 1.0
    return fractions


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


def _taut(
    start: complex, lefts: list[complex], rights: list[complex], stop: complex
) -> tuple[float, Turns]:
    """The length of the thread from start to stop through all gates, and where it bends."""
    lefts, rights = [*lefts, stop], [*rights, stop]
    total = 0.0
    turns: Turns = []
    tip = start
    left, right, left_at, right_at = lefts[0], rights[0], 0, 0
    # The imaginary part of conj(u) * v is positive where v points to the left of u.
    to_left, to_right = (left - tip).conjugate(), (right - tip).conjugate()
    gate, gates = 1, len(lefts)
    while gate < gates:
        arm = rights[gate] - tip
        if (to_right * arm).imag >= 0:
            if right == tip or (to_left * arm).imag < 0:
                right, right_at, to_right = rights[gate], gate, arm.conjugate()
            else:
                total += abs(to_left)
                turns.append((left_at, True))
                tip = right = left
                to_left = to_right = 0j
                gate = right_at = left_at
                gate += 1
                continue
        arm = lefts[gate] - tip
        if (to_left * arm).imag <= 0:
            if left == tip or (to_right * arm).imag > 0:
                left, left_at, to_left = lefts[gate], gate, arm.conjugate()
            else:
                total += abs(to_right)
                turns.append((right_at, False))
                tip = left = right
                to_left = to_right = 0j
                gate = left_at = right_at
                gate += 1
                continue
        gate += 1
    # The last gate is the stop, where a thread ends and does not bend.
    return total + abs(stop - tip), [turn for turn in turns if turn[0] < gates - 1]
