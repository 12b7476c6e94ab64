"""Ways of making requests that nobody would send on purpose, or only somebody with bad ones.

Schemathesis, where it is installed, makes requests of the API's own description, such as follow it
and such as do not. Hypothesis fills in every form of the site with what people, programs and
attackers may send, asks for bodies within the limits and about them, and sends pictures: sound,
damaged and invented. `fuzz` counts what is answered.
"""

import io
import json
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from flask import Flask
from flask.testing import FlaskClient
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy
from PIL import Image, ImageDraw
from werkzeug.test import TestResponse

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from model.measurements import BODY_KINDS, MEASUREMENTS


class Tally:
    """Counts answers by the way in which their requests were made; refuses those of 5xx."""

    def __init__(self) -> None:
        self.answers: Counter[tuple[str, int]] = Counter()

    def count(self, way: str, response: TestResponse, sent: object) -> None:
        """Count an answer.

        Raises
        ------
        AssertionError
            With what was sent, where the answer is a failure of ours.
        """
        status = response.status_code
        response.close()
        self.answers[way, status] += 1
        if status >= 500:
            raise AssertionError(f"{status} for {way}: {sent!r}")

    def total(self, way: str | None = None) -> int:
        """All inputs, or those of one way."""
        return sum(count for (one, _), count in self.answers.items() if way in (None, one))


def repeat(
    strategy: SearchStrategy[Any], send: Callable[[Any], None], times: int, number: int
) -> None:
    """Draw and send so often, from a seed (`number`); what fails is made as small as it gets."""

    @seed(number)
    @settings(
        max_examples=times,
        database=None,
        deadline=None,
        suppress_health_check=list(HealthCheck),
        phases=[Phase.generate, Phase.shrink],
    )
    @given(strategy)
    def one(drawn: Any) -> None:
        send(drawn)

    one()


# ---------------------------------------------------------------- forms


def answers() -> SearchStrategy[str]:
    """What may stand in a field: numbers in every dress, words, signs that nobody types."""
    numbers = st.floats(allow_nan=True).map(str) | st.decimals(0, 400, places=1).map(str)
    dressed = st.builds(
        "{}{}{}".format,
        st.integers(0, 999),
        st.sampled_from(["", " ", ",", ".", "'", " 1/", " ft ", "½", "e", "٣", "\u202e"]),
        st.sampled_from(["", "5", "cm", " in", '"', "0" * 30, "lb", "stone", "-"]),
    )
    attacks = st.sampled_from(
        [
            "<script>alert(1)</script>",
            "{{ 7 * 7 }}",
            "' OR 1=1 --",
            "../../etc/passwd",
            "%00",
            "\x00",
            "9" * 400,
            "1e309",
            "-0",
            "nan",
            "𝟷𝟽𝟶",
            "\ud7ff",
            "${jndi:ldap://x}",
        ]
    )
    return numbers | dressed | attacks | st.text(max_size=30)


FIELDS = (
    *("body", "units", "switch_to", "language", "page", "kept", "go", "skip", "back", "next"),
    *("inseam_height:to", "camera_distance", "camera_height", "stature:2", "stature:3", "", "x"),
)


def forms(site: Flask, tally: Tally, times: int, number: int) -> None:
    """Fills in and sends forms, then looks at a page that knows of it."""
    posts = [rule for rule in _rules(site, "POST") if not rule.startswith("/api/")]
    pages = [rule for rule in _rules(site, "GET") if not rule.startswith(("/api/", "/static/"))]
    names = st.sampled_from([*MEASUREMENTS, *FIELDS])
    chosen = st.sampled_from(["female", "male", "neutral", "metric", "imperial", "en", "pt"])
    values = answers() | chosen
    sent = st.tuples(
        st.sampled_from(posts),
        st.sampled_from(sorted(MEASUREMENTS)) | st.just("nothing"),
        st.dictionaries(names, values, max_size=12),
        st.sampled_from(pages),
    )
    cheap = [page for page in pages if "avatar" not in page]

    def send(drawn: tuple[str, str, dict[str, str], str]) -> None:
        path, name, fields, page = drawn
        client = site.test_client()
        path = path.replace("<name>", name)
        data = {key: value for key, value in fields.items() if key}
        tally.count("forms", client.post(path, data=data), drawn)
        if tally.total("forms") < times:
            page = page if page in cheap else "/"
            response = client.get(page.replace("<name>", name), query_string=data)
            tally.count("forms", response, drawn)

    _until(tally, "forms", sent, send, times, number, each=2)


def _rules(site: Flask, method: str) -> list[str]:
    """The addresses that take a method, their parts filled in where they have a few choices."""
    found = []
    for rule in site.url_map.iter_rules():
        if rule.methods and method in rule.methods:
            address = rule.rule.replace("<any(front, profile):side>", "front")
            found.append(address.replace("<path:filename>", "css/site.css"))
    return sorted(found)


def _until(
    tally: Tally,
    way: str,
    strategy: SearchStrategy[Any],
    send: Callable[[Any], None],
    times: int,
    number: int,
    each: int = 1,
) -> None:
    """Repeat until so many were sent, `each` with a draw; a run may end early."""
    while (left := times - tally.total(way)) > 0:
        before = tally.total(way)
        repeat(strategy, send, -(-left // each), number)
        number += 1
        if tally.total(way) == before:
            raise AssertionError(f"nothing was sent in the way of {way}")


# ---------------------------------------------------------------- pictures


def person() -> Image.Image:
    """An outline that is one."""
    picture = Image.new("L", (90, 180))
    draw = ImageDraw.Draw(picture)
    draw.ellipse((35, 10, 55, 35), fill=255)
    draw.rectangle((25, 35, 65, 100), fill=255)
    draw.rectangle((30, 100, 42, 170), fill=255)
    draw.rectangle((48, 100, 60, 170), fill=255)
    return picture


def encoded(kind: str) -> bytes:
    """That outline as a file of some kind."""
    stream = io.BytesIO()
    mode = "L" if kind in ("PNG", "JPEG", "TIFF") else "P"
    person().convert(mode).save(stream, kind)
    return stream.getvalue()


def damaged(files: list[bytes]) -> SearchStrategy[bytes]:
    """Files with some bytes others than they were, cut off, doubled, or wholly invented."""

    def harm(file: bytes, places: list[tuple[int, int]], end: int, tail: bytes) -> bytes:
        changed = bytearray(file)
        for place, value in places:
            changed[place % len(changed)] = value
        return bytes(changed[: len(changed) - end % len(changed)]) + tail

    places = st.lists(st.tuples(st.integers(0, 4000), st.integers(0, 255)), max_size=4)
    ends = st.sampled_from([0, 0, 0, 1, 12, 100, 400])
    harmed = st.builds(harm, st.sampled_from(files), places, ends, st.binary(max_size=8))
    return harmed | st.binary(max_size=200)


def pictures(site: Flask, tally: Tally, times: int, number: int) -> None:
    """Sends pictures to be compared with a body that cannot be, so that few bodies are made."""
    files = [encoded(kind) for kind in ("PNG", "JPEG", "GIF", "WEBP", "BMP", "TIFF")]
    documents = st.sampled_from(
        [
            {"body": "female", "fit": "linear", "measurements": {"stature": 168}},
            {"body": "female", "measurements": {"stature": 1}},
            {"body": "male", "camera": {"distance": -1}},
            [],
        ]
    )
    sent = st.tuples(
        documents,
        st.dictionaries(
            st.sampled_from(["front", "profile", "front", "back"]), damaged(files), max_size=2
        ),
        st.sampled_from(["a.png", "a.jpg", "", "../a", "\u202e.png"]),
    )
    client = site.test_client()

    def send(drawn: tuple[object, dict[str, bytes], str]) -> None:
        document, given_files, name = drawn
        data: dict[str, Any] = {"avatar": json.dumps(document)}
        data |= {side: (io.BytesIO(content), name) for side, content in given_files.items()}
        tally.count("pictures", client.post("/api/v1/comparisons", data=data), drawn)

    _until(tally, "pictures", sent, send, times, number)


# ---------------------------------------------------------------- bytes


def raw(site: Flask, tally: Tally, times: int, number: int) -> None:
    """Sends bytes of any kind to any address, with headers and cookies that nobody has."""
    ours = {*_rules(site, "GET"), *_rules(site, "POST")}
    paths = [*sorted(ours), "/nothing", "/%00", "/api/v1/"]
    kinds = st.sampled_from(
        [
            "application/json",
            "application/json; charset=utf-16",
            "application/x-www-form-urlencoded",
            "multipart/form-data",
            "multipart/form-data; boundary=a",
            "text/plain",
            "",
        ]
    )
    fragments = st.sampled_from(
        [
            b"{",
            b'{"body": "female"}',
            b"[" * 2000,
            b'{"measurements": {"stature": 1e999}}',
            b"--a\r\nContent-Disposition: form-data; name=front\r\n\r\n",
            b"--a--",
            b"\xff\xfe",
            b"a=1&a=2&%ff=%",
        ]
    )
    content = st.lists(fragments | st.binary(max_size=60), max_size=4).map(b"".join)
    headers = st.dictionaries(
        st.sampled_from(
            [
                *("Accept", "Accept-Encoding", "Accept-Language", "Cookie", "If-None-Match"),
                *("Range", "Host", "X-Forwarded-For", "If-Modified-Since", "Origin", "Referer"),
            ]
        ),
        st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=40)
        | st.sampled_from(["fitting_room=eyJ0eXBlZCI6e319.x.y", "bytes=5-1", "en;q=9,*;q=x", "br"]),
        max_size=3,
    )
    methods = st.sampled_from(["GET", "POST", "POST", "PUT", "HEAD", "OPTIONS", "DELETE", "ODD"])
    sent = st.tuples(methods, st.sampled_from(paths), kinds, content, headers, st.text(max_size=20))

    def send(drawn: tuple[str, str, str, bytes, dict[str, str], str]) -> None:
        method, path, kind, body, extra, query = drawn
        response = site.test_client().open(
            path.replace("<name>", "stature"),
            method=method,
            data=body,
            content_type=kind,
            headers=extra,
            query_string={"v": query, "units": query, "live": query},
        )
        tally.count("bytes", response, drawn)

    _until(tally, "bytes", sent, send, times, number)


# ---------------------------------------------------------------- the API


def api(site: Flask, tally: Tally, times: int, number: int) -> None:
    """Sends what the API's description allows, and what it does not, operation by operation."""
    # Imported here: it takes longer than a whole lean run of the other ways.
    import schemathesis
    from schemathesis import GenerationMode

    schema = schemathesis.openapi.from_wsgi("/api/v1/openapi.json", site)
    posts = [
        operation
        for operation in (found.ok() for found in schema.get_all_operations())
        if operation.method.upper() == "POST"
    ]
    modes = (GenerationMode.POSITIVE, GenerationMode.NEGATIVE)
    turns = [(operation, mode) for operation in posts for mode in modes]
    client = site.test_client()
    for turn, (operation, mode) in enumerate(turns):

        def send(case: Any) -> None:
            tally.count("api", _call(client, case), case.as_curl_command())

        left = times * (turn + 1) // len(turns) - tally.total("api")
        if left > 0:
            repeat(operation.as_strategy(generation_mode=mode), send, left, number)


def _call(client: FlaskClient, case: Any) -> TestResponse:
    """A case of Schemathesis, sent by our own client, so that exceptions are seen."""
    sent = case.as_transport_kwargs(base_url="http://localhost")
    response: TestResponse = client.open(
        case.formatted_path,
        method=case.method,
        **{key: sent[key] for key in ("json", "data", "headers", "query_string") if sent.get(key)},
    )
    return response


def bodies(site: Flask, tally: Tally, times: int, number: int) -> None:
    """Asks for bodies within the limits, however strangely put together."""
    table = site.test_client().get("/api/v1/measurements").json or []

    @st.composite
    def documents(draw: Any) -> dict[str, Any]:
        kind = draw(st.sampled_from(BODY_KINDS))
        chosen = draw(st.lists(st.sampled_from(table), max_size=8, unique_by=lambda r: r["name"]))
        rows = {row["name"]: row for row in [table[0], *chosen]}
        return {
            "body": kind,
            "fit": draw(st.sampled_from(["tape", "linear"])),
            "measurements": {
                name: draw(st.floats(*row["range"][kind])) for name, row in rows.items()
            },
        }

    paths = st.sampled_from(["/api/v1/avatars", "/api/v1/avatars.glb", "/api/v1/avatars/front.png"])
    client = site.test_client()

    def send(drawn: tuple[str, dict[str, Any]]) -> None:
        tally.count("bodies", client.post(drawn[0], json=drawn[1]), drawn)

    _until(tally, "bodies", st.tuples(paths, documents()), send, times, number)


WAYS: dict[str, Callable[[Flask, Tally, int, int], None]] = {
    "forms": forms,
    "pictures": pictures,
    "bytes": raw,
    "api": api,
    "bodies": bodies,
}
"""Each is told the site, where to count, how many inputs to send, and a seed to draw them from."""
