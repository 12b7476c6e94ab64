"""From measured scans to what a site needs: outliers left out, a shape basis, estimators, files."""

import csv
import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from model.anthropometry import TAKEN, TAPES, measure_batch
from model.checksums import write_sums
from model.estimators import Estimator, LinearBodyEstimator
from model.geodesics import save_strips
from model.geometry import Booleans, Floats, edges_of
from model.measurements import BODY_KINDS, MEASUREMENTS, BodyKind
from model.shape_basis import load_shape_basis
from model.tapes import legs_of
from model.template_mesh import TemplateMesh, load_template_mesh
from model.training.law_fit import calibrated, law_of
from model.training.scans_files import ScanError
from model.training.scans_workers import each
from model.training.strips import find_strips
from model.training.survey import SEXES
from model.training.train import STRIP_BODIES, plausible_limits, reach_of, spread_of

CHUNK = 32
"""Scans that a worker measures at a time."""

OUTLYING = 3.0
"""Standard deviations from the mean beyond which a value is missing: the paper's section 4.1.1."""

FLAT = 1e-3
"""A face is flat if it is lower than this share of its longest side."""

SMOOTHED = 20
"""How many times at most a body is smoothed around its flat faces."""

MOST_COMPONENTS = 200
SMALL_ERROR = 0.00025
"""Components of the shape basis: as few as bring the root mean square error of vertices below
this, in metres, and no more than that many."""


@dataclass(frozen=True)
class Sent:
    """A template that is sent with each task; a worker keeps the first of one fingerprint.

    What is reckoned once for a template is then reckoned once in a worker.
    """

    fingerprint: str
    template: TemplateMesh = field(compare=False)


@lru_cache(maxsize=1)
def _first_of(sent: Sent) -> TemplateMesh:
    return sent.template


def measure_chunk(sent: Sent, vertices: NDArray[np.float32]) -> Floats:
    """All measurements of some scans, vertices of shape (n, V, 3): (n, M)."""
    return measure_batch(_first_of(sent), vertices.astype(np.float64))


def measure_scans(template: TemplateMesh, vertices: NDArray[np.float32]) -> Floats:
    """All measurements of all scans, by workers: ndarray of shape (n, M), SI."""
    said = [template.faces.tobytes(), template.face_parts.tobytes(), repr(template.landmarks)]
    sent = Sent(hashlib.sha256(repr(said).encode()).hexdigest(), template)
    starts = range(0, len(vertices), CHUNK)
    tasks = ((sent, vertices[start : start + CHUNK]) for start in starts)
    return np.concatenate([*each(measure_chunk, tasks, "measured {} of {} parts", len(starts))])


def with_strips(template: TemplateMesh, vertices: NDArray[np.float32], path: Path) -> TemplateMesh:
    """The template with the strips of its geodesics, found on a sample and written to a file.

    Parameters
    ----------
    vertices : ndarray of shape (n, V, 3), metres.

    Raises
    ------
    ScanError
        Where no body of the sample will do, or no way leads between two landmarks.
    """
    rows = np.unique(np.linspace(0, len(vertices) - 1, STRIP_BODIES).astype(int))
    sample = unflattened(vertices[rows].astype(np.float64), template.faces)
    if not len(sample):
        raise ScanError("every scan has faces without area, which smoothing does not open")
    try:
        save_strips(path, find_strips(template, sample, legs_of(TAPES.values())))
    except ValueError as error:  # of two landmarks that no way leads between
        raise ScanError(f"{path.parent / 'landmarks.json'}: {error}") from None
    load_template_mesh.cache_clear()
    return load_template_mesh(path.parent)


def unflattened(vertices: Floats, faces: NDArray[np.int32]) -> Floats:
    """Bodies, (n, V, 3), without faces that are flat: exact geodesics do not end on those.

    Around a flat face a body is smoothed a little; one on which that does not help is left out.
    """
    edges = edges_of(faces)
    pairs = np.concatenate([edges, edges[:, ::-1]]).T
    beside = csr_array((np.ones(pairs.shape[1]), (pairs[0], pairs[1])))
    counts = np.asarray(beside.sum(axis=1))[:, None]
    kept = []
    for body in vertices:
        for _ in range(SMOOTHED):
            corners = body[faces]
            sides = np.roll(corners, -1, axis=1) - corners
            doubled = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
            flat = doubled <= FLAT * (sides**2).sum(axis=2).max(axis=1)
            if not flat.any():
                kept.append(body)
                break
            around = np.unique(faces[flat])
            body[around] = (beside[around] @ body) / counts[around]
    return np.array(kept)


def outliers(values: Floats, sexes: NDArray[np.uint8]) -> Booleans:
    """Which values lie beyond `OUTLYING` deviations of their sex's mean, or are none: (n, M)."""
    outlying = ~(values > 0)
    for sex in range(len(SEXES)):
        mine = sexes == sex
        own = np.ma.masked_array(values[mine], outlying[mine])
        off = np.abs(own - own.mean(axis=0)) > OUTLYING * own.std(axis=0)
        outlying[mine] |= np.ma.filled(off, True)
    return outlying


def outlier_lines(outlying: Booleans, sexes: NDArray[np.uint8]) -> list[str]:
    """How many values of each measurement, (n, m), are missing as outliers, a line each."""
    counts = [outlying[sexes == sex].sum(axis=0) for sex in range(len(SEXES))]
    lines = [
        f"  {name}: {', '.join(f'{c[i]} {sex}' for c, sex in zip(counts, SEXES, strict=True))}"
        for i, name in enumerate(TAKEN)
        if sum(c[i] for c in counts)
    ]
    total, every = int(outlying.sum()), outlying.size
    head = f"values beyond mean ± {OUTLYING:.0f} sd are missing: {total} of {every}"
    return [head, *lines]


def write_values(
    path: Path, names: Sequence[str], sexes: NDArray[np.uint8], values: Floats
) -> None:
    """Writes all measurements, (n, m), as a table, SI; empty where one is missing."""
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(["file", "sex", *(f"{n}_{MEASUREMENTS[n].unit}" for n in TAKEN)])
        for name, sex, row in zip(names, sexes.tolist(), values, strict=True):
            told = ["" if np.isnan(value) else f"{value:.5f}" for value in row.tolist()]
            table.writerow([name, SEXES[sex], *told])


# ---------------------------------------------------------------- the shape basis


def write_basis(vertices: NDArray[np.float32], folder: Path) -> tuple[Floats, str]:
    """Writes the space that the scans live in: the mean and principal components of all vertices.

    Scans are not symmetric: every vertex is kept, and is its own mirror image.

    Parameters
    ----------
    vertices : ndarray of shape (n, V, 3), metres.

    Returns
    -------
    coefficients : ndarray of shape (n, K), of unit deviation.
    said : how many components there are, and how near they come.
    """
    count, points, _ = vertices.shape
    mean = vertices.mean(axis=0, dtype=np.float64).astype(np.float32)
    centred = (vertices - mean).reshape(count, -1)
    gram = np.zeros((count, count))
    for start in range(0, centred.shape[1], 4096):
        columns = centred[:, start : start + 4096].astype(np.float64)
        gram += columns @ columns.T
    variances, vectors = np.linalg.eigh(gram)
    variances, vectors = np.maximum(variances[::-1], 0), vectors[:, ::-1]
    left = np.sqrt(np.append(np.cumsum(variances[::-1])[::-1], 0) / (count * points))
    few = int(np.argmax(left <= SMALL_ERROR))
    few = max(1, min(few, MOST_COMPONENTS, count - 1))
    coefficients = vectors[:, :few] * np.sqrt(count)
    directions = coefficients.T.astype(np.float32) @ centred / count
    scales = np.abs(directions).max(axis=1) / np.iinfo(np.int16).max
    stored = np.round(directions / scales[:, None]).astype(np.int16)
    np.save(folder / "shape_directions.npy", stored)
    everything = np.arange(points, dtype=np.int32)
    np.savez_compressed(
        folder / "shape_basis.npz",
        fingerprint=hashlib.sha256(stored.tobytes() + mean.tobytes()).hexdigest()[:16],
        mean=mean,
        scales=scales.astype(np.float32),
        half=everything,
        mirror=everything,
    )
    load_shape_basis.cache_clear()
    said = f"{few} shape components, {left[few] * 1e3:.2f} mm root mean square error"
    return coefficients, said


# ---------------------------------------------------------------- the estimators


def train_kind(
    kind: BodyKind,
    coefficients: Floats,
    values: Floats,
    sexes: NDArray[np.uint8],
    population: str,
    folder: Path,
) -> Estimator:
    """Fits the law of one kind of body; neutral is both sexes together.

    Parameters
    ----------
    coefficients : ndarray of shape (n, K).
    values : ndarray of shape (n, M), SI; NaN where one is missing.
    population : the scans, for people to read.
    folder : holds the shape basis and the template.
    """
    mine = np.ones(len(values), dtype=bool) if kind == "neutral" else sexes == SEXES.index(kind)
    own = values[mine]
    linear = LinearBodyEstimator().fit(own, coefficients[mine])
    whole = ~np.isnan(own).any(axis=1)
    # Women and men count alike in the neutral body.
    weights = 1 / np.bincount(sexes[mine], minlength=len(SEXES))[sexes[mine]]
    return Estimator(
        kind=kind,
        names=TAKEN,
        linear=linear,
        law=calibrated(law_of(TAKEN, own[whole], weights[whole]), own[whole], weights[whole]),
        spread=spread_of(coefficients[mine]),
        reach=reach_of(own[whole]),
        limits=plausible_limits(own),
        population=population,
        seed=0,
        date=datetime.now(UTC).date().isoformat(),
        basis=load_shape_basis(folder),
        template=load_template_mesh(folder),
    )


def write_estimators(folder: Path, **learned: Any) -> None:
    """Trains and writes one estimator for each kind of body, and the checksums of all that a site
    loads; arguments as of `train_kind`.
    """
    (folder / "estimators").mkdir(exist_ok=True)
    for kind in BODY_KINDS:
        estimator = train_kind(kind, folder=folder, **learned)
        path = folder / "estimators" / f"{kind}.npz"
        estimator.save(path)
        print(f"{path}: {estimator.linear.count_} scans")
    write_sums(folder)


def write_template(template: TemplateMesh, folder: Path) -> None:
    """Writes the mesh with its parts, and the mean shape as a PLY file to look at."""
    np.savez_compressed(
        folder / "template_mesh.npz",
        vertices=template.vertices.astype(np.float32),
        faces=template.faces.astype(np.int32),
        face_parts=template.face_parts,
        part_names=np.array(template.part_names),
        mirror=template.mirror,
    )
    points = [f"{x:.5f} {y:.5f} {z:.5f}" for x, y, z in template.vertices.tolist()]
    faces = [f"3 {a} {b} {c}" for a, b, c in template.faces.tolist()]
    head = [
        "ply", "format ascii 1.0", f"element vertex {len(points)}", "property float x",
        "property float y", "property float z", f"element face {len(faces)}",
        "property list uchar int vertex_indices", "end_header",
    ]  # fmt: skip
    (folder / "mean.ply").write_text("\n".join([*head, *points, *faces]) + "\n", encoding="ascii")
