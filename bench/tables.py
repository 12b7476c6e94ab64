"""Tables that a command prints row by row as they come, and puts into a page of docs/."""

import re
from collections.abc import Iterable
from pathlib import Path

HOSTING = Path(__file__).resolve().parent.parent / "docs" / "hosting.md"


def printed(rows: Iterable[str]) -> str:
    """Print each row once it is there; all of them."""
    table = []
    for row in rows:
        print(row, flush=True)
        table.append(row)
    return "\n".join(table) + "\n"


def put(table: str, page: Path = HOSTING) -> None:
    """Put a table in the place of the page's table with the same head.

    Raises
    ------
    ValueError
        Where the page has no such table, or more than one.
    """
    head = table.partition("\n")[0]
    text, count = re.subn(
        rf"^{re.escape(head)}\n(?:\|.*\n)*", lambda _: table, page.read_text(), flags=re.MULTILINE
    )
    if count != 1:
        raise ValueError(f"{page.name} has {count} tables with the head {head!r}")
    page.write_text(text)
