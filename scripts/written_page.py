"""A page of docs/ that a command writes, and that a test holds to what the command would write."""

import sys
from collections.abc import Sequence
from pathlib import Path


def write_or_compare(page: Path, text: str, arguments: Sequence[str], command: str) -> int:
    """Write the page if ``--write`` was said, else say whether it is up to date: an exit code."""
    name = page.relative_to(page.parent.parent)
    if "--write" in arguments:
        page.write_text(text)
        print(f"wrote {name}")
        return 0
    if page.read_text() != text:
        print(f"{name} is out of date; run: {command}", file=sys.stderr)
        return 1
    return 0
