"""How answers travel: what is compressed, what is kept, and how heavy the pages are."""

import gzip
import io
import re

import brotli
import pytest
from backports import zstd
from glb_reader import read
from PIL import Image
from werkzeug.test import Client

UNPACKED = {"br": brotli.decompress, "gzip": gzip.decompress, "zstd": zstd.decompress}
BROWSER = {"Accept-Encoding": "gzip, deflate, br, zstd"}
WOMAN = {"body": "female", "measurements": {"stature": 168, "weight": 66, "hip_girth": 101}}


@pytest.fixture
def shopper(client):
    client.send(body="female", stature="168", weight="66", hip_girth="101")
    return client


@pytest.mark.parametrize("encoding", UNPACKED)
@pytest.mark.parametrize("path", ["/api/v1/avatars", "/api/v1/avatars.glb"])
def test_answers_are_compressed_as_the_client_can(client, path, encoding):
    plain = client.post(path, json=WOMAN)
    assert "Content-Encoding" not in plain.headers
    packed = client.post(path, json=WOMAN, headers={"Accept-Encoding": encoding})
    assert packed.headers["Content-Encoding"] == encoding
    assert UNPACKED[encoding](packed.data) == plain.data
    assert len(packed.data) < 0.62 * len(plain.data)
    assert "Accept-Encoding" in packed.vary


def test_pages_are_compressed(site):
    page = Client(site).get("/", headers=BROWSER)
    assert b"</html>" in UNPACKED[page.headers["Content-Encoding"]](page.data)


def test_pictures_are_small_as_they_are(shopper):
    for kind in ("png", "webp"):
        picture = shopper.get(f"/avatar/front.{kind}", headers=BROWSER)
        assert picture.mimetype == f"image/{kind}"
        assert "Content-Encoding" not in picture.headers
        with Image.open(io.BytesIO(picture.data)) as image:
            assert image.size == (600, 1200)
            assert image.format == kind.upper()


@pytest.mark.parametrize("encoding", ["br", "gzip"])
def test_static_files_are_compressed_once(client, encoding):
    plain = client.get("/static/css/site.css")
    assert "Content-Encoding" not in plain.headers
    packed = client.get("/static/css/site.css", headers={"Accept-Encoding": encoding})
    assert packed.headers["Content-Encoding"] == encoding
    assert UNPACKED[encoding](packed.data) == plain.data
    assert packed.content_length == len(packed.data) < 0.4 * len(plain.data)
    assert "Accept-Encoding" in plain.vary and "Accept-Encoding" in packed.vary
    again = {"Accept-Encoding": encoding, "If-None-Match": packed.headers["ETag"]}
    assert client.get("/static/css/site.css", headers=again).status_code == 304


def test_a_part_of_a_static_file_is_a_part_of_the_file(client):
    headers = {"Accept-Encoding": "br", "Range": "bytes=0-99"}
    part = client.get("/static/css/site.css", headers=headers)
    assert part.status_code == 206
    assert part.data == client.get("/static/css/site.css").data[:100]
    assert client.get("/static/../pyproject.toml", headers=BROWSER).status_code == 404


@pytest.mark.parametrize("path", ["/avatar", "/compare"])
def test_a_script_and_what_it_imports_are_asked_for_together(shopper, path):
    page = shopper.get(path).text
    scripts = re.findall(r'<script type="module" src="(/static/build/[^"?]+)', page)
    preloaded = re.findall(r'<link rel="modulepreload" href="([^"]+)"', page)
    imported = [
        "/static/build/" + piece
        for script in scripts
        for piece in re.findall(r'from"(?:\.\./|\./)+([^"]+)"', shopper.get(script).text)
    ]
    assert preloaded == imported != []
    for piece in preloaded:
        assert "immutable" in shopper.get(piece).headers["Cache-Control"]


def test_the_file_travels_light(client):
    sizes = {
        live: len(
            client.post(
                "/api/v1/avatars.glb",
                json=WOMAN | {"morph_targets": live},
                headers={"Accept-Encoding": "gzip"},
            ).data
        )
        for live in (False, True)
    }
    assert sizes[False] < 400_000
    assert sizes[True] < 1_500_000


@pytest.mark.parametrize("kind", ["female", "male", "neutral"])
def test_with_a_target_for_every_value_it_travels_light_too(client, kind):
    rows = client.post("/api/v1/avatars", json=WOMAN | {"body": kind}).json["measurements"]
    every = {
        "body": kind,
        "measurements": {row["name"]: round(row["taken"], 1) for row in rows},
        "morph_targets": True,
    }
    content = client.post("/api/v1/avatars.glb", json=every).data
    mesh = read(content)[0]["meshes"][0]
    assert len(mesh["extras"]["targetNames"]) == 41
    for encoding in UNPACKED:
        packed = client.post(
            "/api/v1/avatars.glb", json=every, headers={"Accept-Encoding": encoding}
        )
        assert packed.headers["Content-Encoding"] == encoding
        assert len(packed.data) < 1_500_000, encoding


PAGES = (
    "/",
    "/nothing",
    "/numbers",
    "/measure",
    "/measure/waist_girth",
    "/review",
    "/avatar",
    "/avatar/sheet",
    "/compare",
)


@pytest.mark.parametrize("path", PAGES)
def test_a_page_waits_for_few_style_sheets(shopper, path):
    shopper.get(path)
    first, later = (
        [link.get("href") for link in shopper.page.findall(f"./{part}//link[@rel='stylesheet']")]
        for part in ("head", "body")
    )
    assert first[0].startswith("/static/css/site.css")
    assert len(first) <= 3
    for address in first + later:
        assert shopper.get(address).cache_control.immutable


def pieces(shopper, script):
    """The other files that a built script fetches, and those that they fetch: their addresses."""
    found, unread = set(), {script}
    while unread:
        text = shopper.get(unread.pop()).text
        names = re.findall(r"""["']\./([\w-]+\.js)["']""", text)
        fetched = {f"/static/build/{name}" for name in names}
        unread |= fetched - found
        found |= fetched
    return found


def test_the_avatars_page_weighs_little(shopper):
    """Everything that it fetches, its pictures and its numbers too, but the avatar's file."""
    page = shopper.get("/avatar")
    addresses = set(re.findall(r'(?:src|data-renderer)="([^"]+)"', page.text))
    addresses |= set(re.findall(r'<link [^>]*href="([^"]+)"', page.text))
    assert {"/avatar/front.webp", "/avatar/profile.webp"} < addresses
    weight = len(brotli.compress(page.data, quality=4))
    script = next(address for address in addresses if "avatar.js" in address)
    built = pieces(shopper, script)
    for address in addresses | built | {"/avatar.json"}:
        file = shopper.get(address, headers=BROWSER)
        if file.status_code == 404:
            pytest.skip("the front end is not built: make run or make test does it")
        if address.startswith("/static/"):
            assert "v=" in address or address in built
            assert file.cache_control.immutable
        weight += len(file.data)
    assert weight < 350_000
