"""How heavy the avatar's file is, stored and as it travels: the table of docs/avatar_file.md.

    python scripts/avatar_sizes.py [--write]      --write: put it into the page too

Of the neutral body, whose files are the heaviest of the three kinds. What is entered is what the
body of a stature of 168 cm measures, in the order of the table of measurements.
"""

import json
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from bench.tables import printed, put
from webapp import create_app

PAGE = ROOT / "docs" / "avatar_file.md"

TARGETS = (4, 11, 41)
"""Morph targets, one for each entered value."""

ENCODINGS = ("zstd", "br", "gzip")


def rows() -> Iterator[str]:
    """The table, row by row."""
    settings = {"FITTING_ROOM_LOCAL": True, "SECRET_KEY": "of these sizes, and no secret"}
    client = create_app(settings | {"RATELIMIT_ENABLED": False}).test_client()
    asked = {"body": "neutral", "measurements": {"stature": 168}}
    taken = json.loads(client.post("/api/v1/avatars", json=asked).data)["measurements"]
    values = {row["name"]: round(row["taken"], 1) for row in taken}

    def row(words: str, count: int, *, morph_targets: bool) -> str:
        entered = dict(list(values.items())[:count])
        wanted = asked | {"measurements": entered, "morph_targets": morph_targets}
        sizes = [
            len(client.post("/api/v1/avatars.glb", json=wanted, headers=headers).data)
            for headers in ({}, *({"Accept-Encoding": encoding} for encoding in ENCODINGS))
        ]
        stored, *sent = (f"{size / 1000:,.0f}" for size in sizes)
        return f"| {words} | {stored} kB | {', '.join(sent)} kB |"

    yield "| file | bytes | as transferred (Zstandard, Brotli, gzip) |"
    yield "|---|---|---|"
    yield row("with a rig", TARGETS[0], morph_targets=False)
    for count in TARGETS:
        all_there_can_be = ", all there can be" if count == len(values) else ""
        yield row(f"with {count} morph targets{all_there_can_be}", count, morph_targets=True)


if __name__ == "__main__":
    table = printed(rows())
    if "--write" in sys.argv[1:]:
        put(table, PAGE)
