"""Find the site's texts, bring the translations in step with them, and compile those.

Texts stand in English in the Python files, the pages and the table of measurements. A translation
is a file of Babel's, ``webapp/translations/<language>/LC_MESSAGES/messages.po``, to be filled in by
hand; beside it lies the compiled one that the site reads.

usage: python scripts/words.py [--check]       --check: say whether anything is missing or stale
"""

from __future__ import annotations

import csv
import io
import sys
from collections.abc import Iterator
from pathlib import Path

from babel.messages.catalog import Catalog
from babel.messages.extract import DEFAULT_KEYWORDS, extract_from_file
from babel.messages.mofile import write_mo
from babel.messages.pofile import read_po, write_po

ROOT = Path(__file__).resolve().parent.parent
TRANSLATIONS = ROOT / "webapp" / "translations"
TABLE = ROOT / "model" / "data" / "measurements.csv"
TABLE_COLUMNS = ("label", "definition", "how_to")
KEYWORDS = DEFAULT_KEYWORDS | {"_l": None, "lazy_gettext": None}
PAGES = {"trim_blocks": "true", "lstrip_blocks": "true", "silent": "false"}


def texts() -> Catalog:
    """All texts of the site, each with the files that it stands in."""
    catalog = Catalog(project="Fitting Room", charset="utf-8", fuzzy=False)
    for file, message, context in _found():
        place = (file.relative_to(ROOT).as_posix(), 1)
        catalog.add(message, locations=[place], context=context)
    return catalog


def _found() -> Iterator[tuple[Path, str | tuple[str, ...], str | None]]:
    for method, files, options in (
        ("python", sorted((ROOT / "webapp").glob("*.py")), {}),
        ("jinja2.ext:babel_extract", sorted((ROOT / "templates").rglob("*.html")), PAGES),
    ):
        for file in files:
            found = extract_from_file(method, file, KEYWORDS, options=options)
            for _line, message, _comments, context in found:
                yield file, message, context
    with TABLE.open(encoding="utf-8", newline="") as table:
        for row in csv.DictReader(table):
            for column in TABLE_COLUMNS:
                yield TABLE, row[column], None


def in_step(language: str, found: Catalog) -> Catalog:
    """A language's translations with exactly the texts that there are."""
    file = po_file(language)
    if file.exists():
        with file.open("rb") as stream:
            catalog = read_po(stream, locale=language)
    else:
        catalog = Catalog(locale=language, charset="utf-8", fuzzy=False)
    catalog.update(found, no_fuzzy_matching=True, update_creation_date=False)
    catalog.obsolete.clear()
    catalog.header_comment = ""
    catalog.project, catalog.version = "The Fitting Room", "1"
    catalog.last_translator = catalog.language_team = catalog.msgid_bugs_address = ""
    return catalog


def po_file(language: str) -> Path:
    """Where a language's translations stand."""
    return TRANSLATIONS / language / "LC_MESSAGES" / "messages.po"


def as_po(catalog: Catalog) -> bytes:
    """A translation as it stands in its file."""
    stream = io.BytesIO()
    write_po(stream, catalog, width=96, omit_header=False, include_lineno=False, sort_output=True)
    return stream.getvalue()


def as_mo(catalog: Catalog) -> bytes:
    """A translation compiled."""
    stream = io.BytesIO()
    write_mo(stream, catalog)
    return stream.getvalue()


def untranslated(catalog: Catalog) -> list[str]:
    """Texts that a language has no words for."""
    missing = []
    for message in catalog:
        words = message.string if isinstance(message.string, list | tuple) else [message.string]
        if message.id and not all(words):
            missing.append(str(message.id))
    return missing


def languages() -> list[str]:
    """The languages that there are translations for."""
    return sorted(folder.name for folder in TRANSLATIONS.iterdir() if folder.is_dir())


def main() -> None:
    """Bring all languages in step, or say which are not."""
    found = texts()
    stale = []
    for language in languages():
        catalog = in_step(language, found)
        missing = untranslated(catalog)
        for text in missing:
            print(f"{language} has no words for: {text}")
        po, mo = po_file(language), po_file(language).with_suffix(".mo")
        contents = {po: as_po(catalog), mo: as_mo(catalog)}
        old = [
            file for file, new in contents.items() if not file.exists() or file.read_bytes() != new
        ]
        if "--check" in sys.argv[1:]:
            stale += [file.name for file in old] + missing
        else:
            for file in old:
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_bytes(contents[file])
    if stale:
        sys.exit("translations are not in step: run make words, then fill in what has no words")


if __name__ == "__main__":
    main()
