"""Breaks a real server in the ways in which servers break, and prints what shoppers see of it.

    python scripts/faults.py [name ...]          all of them, or those named
    python scripts/faults.py --write             all, and their table into docs/hosting.md

The ways are those of `fault_ways`. What cannot be tried is said, and counts as not passed.
"""

import argparse
import sys
from collections.abc import Container, Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from bench.tables import printed, put
from fault_ways import FAULTS, NotTried


def rows(names: Container[str]) -> Iterator[str]:
    """Breaks, and tells of each fault in a row.

    Raises
    ------
    SystemExit
        Where something is not as it should be, and at the end where a fault could not be tried.
    """
    yield "| fault | what came of it |"
    yield "|---|---|"
    left_out = 0
    for words, fault in FAULTS.items():
        if fault.__name__ in names:
            try:
                came = fault()
            except NotTried as why:
                came, left_out = f"**not tried**: {why}", left_out + 1
            yield f"| {words} | {came} |"
    if left_out:
        raise SystemExit(f"{left_out} not tried: they count as not passed")


def main() -> None:
    """Breaks, and prints a table."""
    every = [fault.__name__ for fault in FAULTS.values()]
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*", choices=[*every, []])
    parser.add_argument("--write", action="store_true", help="the whole table into docs/hosting.md")
    options = parser.parse_args()
    if options.write and options.names:
        parser.error("what is written is the whole table")
    table = printed(rows(options.names or every))
    if options.write:
        put(table)


if __name__ == "__main__":
    main()
