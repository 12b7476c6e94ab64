"""Trains on a set of registered scans, such as SPRING: one command from a folder to estimators.

Read and check, mend, recognise unit and axes, find parts and landmarks on the mean shape, measure,
leave out outliers, train, and write a folder on which the site can be started. Reference: the
paper's sections 3.1 and 4.1.1. How it is used: docs/scans.md.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from model.estimators import load_estimators
from model.studio import RenderingUnavailable
from model.template_mesh import TemplateMesh
from model.training.mesh_repair import UnrepairableMeshError, repair
from model.training.scans_anatomy import (
    LANDMARKS_FILE,
    Corrections,
    find_anatomy,
    read_landmarks,
    read_template,
    write_landmarks,
)
from model.training.scans_files import ScanError
from model.training.scans_picture import landmark_picture
from model.training.scans_placing import place, recognise_axes, recognise_unit
from model.training.scans_set import ScanSet, find_files, find_folders, read_set
from model.training.scans_training import (
    measure_scans,
    outlier_lines,
    outliers,
    with_strips,
    write_basis,
    write_estimators,
    write_template,
    write_values,
)
from model.training.scans_workers import workers
from model.training.survey import SEXES, Sex

OUTPUT = Path("build/scans")


@dataclass(frozen=True)
class Known:
    """What the user says of the scans, and need not be recognised.

    Attributes
    ----------
    unit : m, cm or mm.
    up, front : the axes of the scans along which people stand and look, such as +z.
    """

    unit: str | None = None
    up: str | None = None
    front: str | None = None


class Record:
    """What the command says, on the screen and in a file."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def say(self, *lines: str) -> None:
        """Print lines and keep them."""
        self.lines += lines
        print("\n".join(lines), flush=True)


def train_on_scans(
    folder: Path | None = None,
    given: Mapping[Sex, Path | None] | None = None,
    *,
    output: Path = OUTPUT,
    known: Known | None = None,
    jobs: int = -1,
    dask: str | None = None,
) -> None:
    """Runs the command.

    Parameters
    ----------
    folder : holds a folder of each sex, told by its name.
    given : the folder of a sex, where its name does not say it.
    output : where everything is written; landmarks corrected there are read again.
    known : what need not be recognised.
    jobs, dask : where work is done, see `workers`.

    Raises
    ------
    ScanError
        For whatever is wrong with the scans; the message names the file.
    OSError, ModuleNotFoundError
        As `workers`.
    """
    record = Record()
    files = find_files(find_folders(folder, given or {}))
    output.mkdir(parents=True, exist_ok=True)
    with workers(jobs, dask) as where:
        counts = [sum(own == sex for own, _ in files) for sex in SEXES]
        record.say(f"{counts[0]} female and {counts[1]} male scans; work on {where}")
        scans = read_set(files, output / "read")
        scans = prepared(scans, known or Known(), record)
        template = anatomy(scans, output, record)
        template = with_strips(template, scans.vertices, output / "strips.npz")
        values = measure_scans(template, scans.vertices)
    outlying = outliers(values, scans.sexes)
    values[outlying] = np.nan
    record.say(*outlier_lines(outlying, scans.sexes))
    write_values(output / "measurements.csv", scans.names, scans.sexes, values)
    coefficients, said = write_basis(scans.vertices, output)
    record.say(said)
    write_estimators(
        output,
        coefficients=coefficients,
        values=values,
        sexes=scans.sexes,
        population=f"registered scans: {counts[0]} female, {counts[1]} male",
    )
    (output / "report.txt").write_text("\n".join(record.lines) + "\n", encoding="utf-8")
    print(f"start the site on them: FITTING_ROOM_DATA={output} make run")


def prepared(scans: ScanSet, known: Known, record: Record) -> ScanSet:
    """The scans mended, in metres, +Y up, facing +Z, on the ground and on one another.

    Raises
    ------
    ScanError
        Where unit or axes are not recognised, or the mesh cannot be mended; it names the scan.
    """
    unit, axis = recognise_unit(scans.names, scans.vertices, known.unit, known.up)
    mean = np.zeros(scans.vertices.shape[1:])
    for scan in scans.vertices:
        mean += (scan - scan.mean(axis=0)) / len(scans.vertices)
    try:
        mended = repair(scans.faces, mean)
    except UnrepairableMeshError as error:
        raise ScanError(f"{scans.names[0]}, and all of its mesh: {error}") from None
    record.say(
        f"mesh: {len(mean)} vertices and {len(scans.faces)} faces, after repair "
        f"{len(mended.vertex_sources)} and {len(mended.faces)}",
        *(f"  {line}" for line in mended.report),
    )
    faces = mended.faces.astype(np.int32)
    frame = recognise_axes(
        load_estimators()["neutral"], mended.apply(mean), faces, unit, axis, (known.up, known.front)
    )
    vertices: NDArray[np.float32] = mended.apply(scans.vertices)
    turned = place(scans.names, vertices, frame)
    statures = np.ptp(vertices[:, :, 1], axis=1)
    record.say(
        f"unit {frame.unit}: statures {statures.min():.3f} to {statures.max():.3f} m; "
        f"up is {frame.up}, people face {frame.front}; turned onto one another by up to "
        f"{turned:.1f} degrees"
    )
    return replace(scans, vertices=vertices, faces=faces)


def anatomy(scans: ScanSet, output: Path, record: Record) -> TemplateMesh:
    """The template of the set: its mean shape, with parts and landmarks found or read again.

    Raises
    ------
    ScanError
        Where our template does not come to lie on the shape, or the landmarks' file is wrong.
    """
    mean = scans.vertices.mean(axis=0, dtype=np.float64)
    estimator = load_estimators()["neutral"]
    names = estimator.template.landmarks
    path = output / LANDMARKS_FILE
    before = read_template(output, scans.faces)
    read = Corrections({}, {})
    if path.exists():
        shape = mean if before is None else before.vertices
        read = read_landmarks(path, shape, scans.faces, names)
        record.say(f"{len(read.landmarks)} landmarks from {path}")
        for name, distance in read.moved.items():
            record.say(f"  {name} was moved by {distance * 1e3:.1f} mm")
    if before is None or len(read.landmarks) < len(names):
        record.say("laying our template on the mean shape, to find landmarks and parts")
        template, distance = find_anatomy(estimator, mean, scans.faces)
        record.say(f"  it lies {distance * 1e3:.2f} mm from it on average")
    else:
        template = before
    landmarks = {**template.landmarks, **read.landmarks}
    template = replace(template, vertices=mean, landmarks={n: landmarks[n] for n in names})
    write_template(template, output)
    write_landmarks(template, path)
    try:
        (output / "landmarks.png").write_bytes(landmark_picture(template))
        record.say(f"check {output / 'landmarks.png'}, and correct {path} where it is wrong")
    except RenderingUnavailable as problem:
        record.say(f"no picture of the landmarks: {problem}")
    return template
