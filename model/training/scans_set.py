"""A set of scans in correspondence, read from a folder for each sex and checked file by file."""

import hashlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from model.training.scans_files import SUFFIXES, ScanError, read_scan
from model.training.scans_workers import each
from model.training.survey import SEXES, Sex

CHUNK = 32
"""Scans in one task of a worker, and in one file of the work that is kept."""

LEAST = 5
"""Scans of each sex, at least: fewer have no deviation to speak of."""


@dataclass(frozen=True, eq=False)
class ScanSet:
    """Scans as they are in their files.

    Attributes
    ----------
    names : the files, in order, those of women first.
    sexes : ndarray of shape (n,), 0 female and 1 male, as in `SEXES`.
    vertices : ndarray of shape (n, V, 3), float32, in the files' unit and axes.
    faces : ndarray of shape (F, 3).
    """

    names: tuple[str, ...]
    sexes: NDArray[np.uint8]
    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]


def find_folders(folder: Path | None, given: Mapping[Sex, Path | None]) -> dict[Sex, Path]:
    """The folder of each sex: as given, or the one within `folder` whose name says it.

    Raises
    ------
    ScanError
        Where a folder is missing, or its name leaves it open.
    """
    found = {sex: path for sex, path in given.items() if path is not None}
    for path in [*([] if folder is None else [folder]), *found.values()]:
        if not path.is_dir():
            raise ScanError(f"{path}: no such folder")
    for sex in SEXES:
        if sex in found:
            continue
        if folder is None:
            raise ScanError(f"the folder of {sex} scans is missing: give --{sex} FOLDER")
        within = [
            path for path in sorted(folder.iterdir()) if path.is_dir() and _sex_in(path.name) == sex
        ]
        if len(within) != 1:
            said = "several folders are" if within else "no folder is"
            raise ScanError(f"{folder}: {said} named {sex} there: give --{sex} FOLDER")
        found[sex] = within[0]
    return {sex: found[sex] for sex in SEXES}


def _sex_in(name: str) -> Sex | None:
    """The sex that a folder's name says, as in SPRING_FEMALE."""
    low = name.lower()
    return "female" if "female" in low else "male" if "male" in low else None


def find_files(folders: Mapping[Sex, Path]) -> list[tuple[Sex, Path]]:
    """All OBJ and PLY files, those in folders within too, in order.

    Raises
    ------
    ScanError
        For a folder with fewer than `LEAST` of them.
    """
    files: list[tuple[Sex, Path]] = []
    for sex, folder in folders.items():
        own = sorted(
            path
            for path in folder.rglob("*")
            if path.suffix.lower() in SUFFIXES and path.is_file() and path.name[0] != "."
        )
        if len(own) < LEAST:
            many = f"only {len(own)}" if own else "no"
            raise ScanError(f"{folder}: {many} OBJ or PLY files, at least {LEAST} are needed")
        files += [(sex, path) for path in own]
    return files


def read_set(files: Sequence[tuple[Sex, Path]], work: Path) -> ScanSet:
    """Reads and checks all files; what was read stays in `work`, and is not read again.

    Raises
    ------
    ScanError
        For a file that cannot be read, or has another mesh than most; it is named.
    """
    work.mkdir(parents=True, exist_ok=True)
    chunks = [files[i : i + CHUNK] for i in range(0, len(files), CHUNK)]
    kept = [work / f"{_fingerprint(chunk)}.npz" for chunk in chunks]
    missing = [i for i, path in enumerate(kept) if not path.exists()]
    if len(missing) < len(chunks):
        print(f"{len(chunks) - len(missing)} of {len(chunks)} parts were read before")
    tasks = (([(str(path), path.read_bytes()) for _, path in chunks[i]],) for i in missing)
    results = each(read_chunk, tasks, "read {} of {} parts", len(missing)) if missing else ()
    for i, (vertices, meshes, which) in zip(missing, results, strict=True):
        arrays = {f"faces{j}": faces for j, faces in enumerate(meshes)}
        arrays |= {f"vertices{j}": points for j, points in enumerate(vertices)}
        part = kept[i].with_name(f"part-{kept[i].name}")
        np.savez(part, which=np.array(which), **arrays)
        part.replace(kept[i])
    names = tuple(str(path) for _, path in files)
    vertices, faces = _one_mesh(names, kept)
    sexes = np.array([SEXES.index(sex) for sex, _ in files], dtype=np.uint8)
    return ScanSet(names, sexes, vertices, faces)


def _fingerprint(chunk: Sequence[tuple[Sex, Path]]) -> str:
    """A name for the content of some files, as far as it shows from outside."""
    said = [
        (str(path.resolve()), path.stat().st_size, path.stat().st_mtime_ns) for _, path in chunk
    ]
    return hashlib.sha256(repr(said).encode()).hexdigest()[:16]


def read_chunk(
    files: Sequence[tuple[str, bytes]],
) -> tuple[list[NDArray[np.float32]], list[NDArray[np.int32]], list[int]]:
    """Reads files of which a worker was sent the content.

    Returns
    -------
    vertices : of each file, ndarray of shape (V, 3).
    meshes : the different faces there are, each of shape (F, 3).
    which : of each file, its place in meshes.
    """
    vertices, meshes, which = [], list[NDArray[np.int32]](), []
    for name, content in files:
        mesh = read_scan(name, content)
        same = (i for i, faces in enumerate(meshes) if np.array_equal(faces, mesh.faces))
        place = next(same, len(meshes))
        meshes += [mesh.faces] * (place == len(meshes))
        vertices.append(mesh.vertices.astype(np.float32))
        which.append(place)
    return vertices, meshes, which


def _kept_scans(kept: Sequence[Path]) -> Iterator[tuple[NDArray[np.float32], NDArray[np.int32]]]:
    """Vertices and faces of every scan, from the files of `read_set`."""
    for path in kept:
        with np.load(path, allow_pickle=False) as arrays:
            meshes = {place: arrays[f"faces{place}"] for place in set(arrays["which"].tolist())}
            for i, place in enumerate(arrays["which"].tolist()):
                yield arrays[f"vertices{i}"], meshes[place]


def _one_mesh(
    names: Sequence[str], kept: Sequence[Path]
) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """All vertices, and the one mesh that all share; the first file that has another is named."""
    of_each = [
        (len(vertices), len(faces), hashlib.sha256(faces.tobytes()).digest())
        for vertices, faces in _kept_scans(kept)
    ]
    usual, _ = Counter(of_each).most_common(1)[0]
    like = names[of_each.index(usual)]
    for name, own in zip(names, of_each, strict=True):
        if own != usual:
            counts = f"{own[0]} vertices and {own[1]} faces"
            if own[:2] != usual[:2]:
                said = f"{counts}, where {like} has {usual[0]} and {usual[1]}"
            else:
                said = f"{counts} as {like}, but other faces"
            raise ScanError(f"{name}: {said}; the scans of a set must correspond")
    vertices = np.empty((len(names), usual[0], 3), dtype=np.float32)
    for row, (points, mesh) in enumerate(_kept_scans(kept)):
        vertices[row], faces = points, mesh
    return vertices, faces
