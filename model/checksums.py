"""SHA-256 sums of an estimator's files, by which a site knows at its start that all are whole.

They lie beside the files in ``SHA256SUMS``, as ``sha256sum`` writes and checks them:
``cd model/data && sha256sum --check SHA256SUMS``.
"""

import hashlib
import re
from pathlib import Path

from model.measurements import BODY_KINDS
from model.template_mesh import DamagedFileError

SUMS_FILE = "SHA256SUMS"

FILES = (
    *(f"estimators/{kind}.npz" for kind in BODY_KINDS),
    *("landmarks.json", "rig.npz", "shape_basis.npz", "shape_directions.npy"),
    *("strips.npz", "template_mesh.npz"),
)
"""All that a site reads of a folder of estimators; one learned from scans has no rig."""

_LINE = re.compile(r"([0-9a-f]{64})  (\S+)")


def write_sums(folder: Path) -> Path:
    """Write the sums of the folder's files, as they are now: the last step of every training."""
    path = folder / SUMS_FILE
    lines = [f"{_sum(folder / name)}  {name}\n" for name in FILES if (folder / name).exists()]
    part = path.with_name(f"part-{path.name}")
    part.write_text("".join(lines), encoding="ascii")
    part.replace(path)
    return path


def check_sums(folder: Path) -> None:
    """Refuse a folder in which a file is not what it was when the sums were written.

    Raises
    ------
    FileNotFoundError
        Where a file that is named, or the file of the sums, is missing.
    DamagedFileError
        Where a file has changed, or was put there later; or the file of the sums is no such file.
        The message names it.
    """
    path = folder / SUMS_FILE
    sums: dict[str, str] = {}
    for line in path.read_text(encoding="ascii", errors="replace").splitlines():
        parts = _LINE.fullmatch(line)
        if parts is None or parts[2] not in FILES:
            raise DamagedFileError(f"{path} is damaged: a line of it names no file of estimators")
        sums[parts[2]] = parts[1]
    for name in FILES:
        file = folder / name
        if (name in sums or file.exists()) and _sum(file) != sums.get(name):
            raise DamagedFileError(
                f"{file} is damaged: it is not the file that {SUMS_FILE} tells of"
            )


def _sum(file: Path) -> str:
    with file.open("rb") as content:
        return hashlib.file_digest(content, "sha256").hexdigest()
