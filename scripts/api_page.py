"""Write docs/api.md: the interface for programs, for people to read, from its OpenAPI document.

usage: python scripts/api_page.py [--write]      without --write: say whether the file is up to date
"""

import json
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "api.md"

sys.path.insert(0, str(ROOT))

from webapp import openapi
from webapp.openapi_schemas import Schema
from written_page import write_or_compare

MOST_CHOICES = 12
"""Of a member's values: more are not written out."""

OPENING = """# The interface for programs

Written by `make api` from the site's own OpenAPI document, `GET /api/v1/openapi.json`; do not edit.
An example is in the [README](../README.md). Requests and answers are JSON in UTF-8 where nothing
else is said. There are no accounts, no keys and no cookies; no answer is to be cached, no page of
another origin may read one, and a browser that is led to one saves it. Words are English.

"""


def page() -> str:
    """The page's text."""
    description = openapi.document()
    operations = [
        _operation(f"{method.upper()} {path}", operation)
        for path, methods in description["paths"].items()
        for method, operation in methods.items()
    ]
    schemas = [
        _schema(name, schema) for name, schema in description["components"]["schemas"].items()
    ]
    return (
        f"{OPENING}Version {description['info']['version']}.\n\n"
        + "\n".join(operations)
        + "\n## What goes in and comes out\n\n"
        + "Members in bold are always there, or needed. Others than these are refused.\n\n"
        + "\n".join(schemas)
    )


def _operation(title: str, operation: Schema) -> str:
    lines = [f"## `{title}`", "", operation["summary"], ""]
    for parameter in operation.get("parameters", []):
        lines += [f"In the query: `{parameter['name']}`, {_type(parameter['schema'])}.", ""]
    for media_type, part in operation.get("requestBody", {}).get("content", {}).items():
        schema = part["schema"]
        if "$ref" in schema:
            lines += [f"Takes {_type(schema)} as `{media_type}`.", ""]
        else:
            lines += [f"Takes `{media_type}` of these parts:", "", *_members(schema), ""]
    lines += ["| status | answer |", "|---|---|"]
    for status, answer in sorted(operation["responses"].items()):
        ((media_type, part),) = answer["content"].items()
        of = f", {_type(part['schema'])}" if part["schema"] else ""
        lines.append(f"| {status} | {answer['description']} `{media_type}`{of} |")
    return "\n".join([*lines, ""])


def _schema(name: str, schema: Schema) -> str:
    lines = [f"### {name}", ""]
    if "description" in schema:
        lines += [schema["description"], ""]
    if "properties" in schema:
        lines += _members(schema)
    else:
        lines.append(f"{_type(schema)}.")
    return "\n".join([*lines, ""])


def _members(schema: Schema) -> Iterator[str]:
    yield "| member | is | what it says |"
    yield "|---|---|---|"
    for name, part in schema["properties"].items():
        shown = f"**`{name}`**" if name in schema["required"] else f"`{name}`"
        yield f"| {shown} | {_type(part)} | {part.get('description', '')} |"


def _type(schema: Schema) -> str:
    """What a value may be, in words; a part of its own as a link."""
    if "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        return f"[{name}](#{name.lower()})"
    if "const" in schema:
        return f"`{json.dumps(schema['const'])}`"
    if "enum" in schema:
        words = _choices(schema["enum"])
    elif schema["type"] == "array":
        count = schema.get("minItems")
        many = f"{count} × " if count and count == schema.get("maxItems") else ""
        words = f"a list of {many}{_type(schema['items'])}"
    elif schema["type"] == "object" and "properties" in schema:
        names = schema["properties"]
        words = "an object" if len(names) > MOST_CHOICES else "an object of " + _listed(names)
    else:
        kind = schema["type"]
        words = " or ".join(kind) if isinstance(kind, list) else kind
    for word, bound in (
        ("above", "exclusiveMinimum"),
        ("from", "minimum"),
        ("to", "maximum"),
    ):
        if bound in schema:
            words += f" {word} {schema[bound]:g}"
    if "default" in schema:
        words += f"; `{json.dumps(schema['default'])}` unless told"
    return words


def _choices(values: list[str]) -> str:
    if len(values) > MOST_CHOICES:
        return "a measurement's name"
    return " or ".join(f"`{json.dumps(value)}`" for value in values)


def _listed(names: dict[str, Schema]) -> str:
    return ", ".join(f"`{name}` ({_type(part)})" for name, part in names.items())


def main(arguments: list[str]) -> int:
    """Write the page, or say whether it is up to date."""
    return write_or_compare(PAGE, page(), arguments, "make api")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
