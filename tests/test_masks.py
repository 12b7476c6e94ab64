"""Masks: one standing person is found within a pixel; all else is refused by name, cheaply."""

import contextlib
import io
import json
import struct
import subprocess
import sys
import zlib
from functools import lru_cache

import numpy as np
import pytest
from PIL import Image

from model.masks import LEAST_HEIGHT, MOST_BYTES, PictureRefusedError, read_mask, runs
from model.silhouette import silhouette
from model.template_mesh import Body, load_template_mesh


@lru_cache
def figure(side="front"):
    """The mean body's outline, white on black, with space around it: uint8."""
    template = load_template_mesh()
    body = Body(template, template.vertices, "neutral")
    return np.pad((silhouette(body, side).cover * 255).astype(np.uint8), 60)


def file_of(array, kind="PNG", **how):
    stream = io.BytesIO()
    Image.fromarray(array).save(stream, kind, **how)
    return stream.getvalue()


def refused(content):
    with pytest.raises(PictureRefusedError) as caught:
        read_mask(content)
    return caught.value.reason


@pytest.mark.parametrize("side", ["front", "profile"])
def test_a_person_is_cut_out_of_the_picture(side):
    mask = read_mask(file_of(figure(side)))
    wide = mask.cover.shape[1]
    own = figure(side)[60:-60, 60:-60] / 255
    # Between fingers there is a hole that a pin could have made; a last column may be faint.
    assert np.abs(mask.cover - own[:, :wide]).sum() + own[:, wide:].sum() < 30
    assert (mask.left, mask.top, mask.scale) == (60, 60, 1)


def test_the_same_person_is_found_in_every_kind_of_file():
    plain = figure()
    clear = np.dstack([np.full_like(plain, 90)] * 3 + [plain])
    deep = plain.astype(np.uint16) * 257
    palette = Image.fromarray(plain).convert("P")
    stream = io.BytesIO()
    palette.save(stream, "PNG")
    wanted = read_mask(file_of(plain)).cover
    for content in (file_of(clear), file_of(deep), stream.getvalue()):
        assert np.array_equal(read_mask(content).cover, wanted)
    # One bit a pixel knows no parts of one, and a JPEG blurs them.
    for content in (file_of(plain >= 128), file_of(plain, "JPEG", quality=90)):
        assert np.abs(read_mask(content).cover - wanted).mean() < 0.01


def test_a_telephones_turn_of_the_picture_is_honoured():
    turned = np.rot90(figure())
    exif = Image.Exif()
    exif[0x0112] = 6  # the first row is on the right
    wanted = read_mask(file_of(figure(), "JPEG")).cover
    found = read_mask(file_of(turned, "JPEG", exif=exif)).cover
    assert np.abs(found - wanted).mean() < 0.01


def test_a_large_picture_is_made_smaller_and_its_place_is_kept():
    large = np.kron(figure(), np.ones((3, 3), dtype=np.uint8))
    mask = read_mask(file_of(large))
    assert mask.scale == pytest.approx(2, abs=0.01)
    assert mask.left == pytest.approx(180, abs=2)
    assert len(mask.cover) * mask.scale == pytest.approx(2700, abs=4)


def test_specks_and_pinholes_are_mended():
    spoilt = figure().copy()
    spoilt[10:14, 10:14] = 255
    spoilt[500:503, spoilt.shape[1] // 2 : spoilt.shape[1] // 2 + 3] = 0
    assert np.array_equal(read_mask(file_of(spoilt)).cover, read_mask(file_of(figure())).cover)


def two_heads():
    """Two people who hold hands, their feet a shoulder's breadth apart."""
    slim = figure("profile")
    both = np.concatenate([slim, slim], axis=1)
    both[500:540, 120:-120] = 255
    return both


REFUSED = {
    "black": (lambda: np.zeros((800, 400), np.uint8), "no_person"),
    "white": (lambda: np.full((800, 400), 255, np.uint8), "no_person"),
    "dark on light": (lambda: 255 - np.pad(figure(), 300), "no_person"),
    "a photo": (
        lambda: np.random.default_rng(0).integers(60, 190, (800, 400)).astype(np.uint8),
        "no_person",
    ),
    "a broad bar": (lambda: np.pad(np.full((300, 700), 255, np.uint8), 50), "no_person"),
    "a lamp post": (lambda: np.pad(np.full((900, 30), 255, np.uint8), 50), "no_person"),
    "no feet": (lambda: figure()[:-150], "cut_off"),
    "no head": (lambda: figure()[150:], "cut_off"),
    "no head, and space around": (lambda: np.pad(figure()[150:], 40), "cut_off"),
    "no hand": (lambda: figure()[:, 100:], "cut_off"),
    "two people": (lambda: np.concatenate([figure(), figure()], axis=1), "several_people"),
    "two people hand in hand": (two_heads, "several_people"),
    "a small one": (lambda: figure()[::4, ::4], "too_small"),
}


@pytest.mark.parametrize(("picture", "reason"), REFUSED.values(), ids=REFUSED)
def test_what_is_no_outline_of_one_standing_person_is_refused(picture, reason):
    assert refused(file_of(picture())) == reason


def test_the_least_height_is_enough():
    for height in (LEAST_HEIGHT, LEAST_HEIGHT - 1):
        rows = np.linspace(0, 899, height).round().astype(int)
        small = np.pad(figure()[60:-60][rows][:, ::4], 5)
        if height == LEAST_HEIGHT:
            assert len(read_mask(file_of(small)).cover) == height
        else:
            assert refused(file_of(small)) == "too_small"


def chunk(kind, content):
    whole = kind + content
    return struct.pack(">I", len(content)) + whole + struct.pack(">I", zlib.crc32(whole))


def bomb(width, height):
    """A PNG that says it is so large, with next to nothing in it."""
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
    rows = chunk(b"IDAT", zlib.compress(bytes(100_000)))
    return b"\x89PNG\r\n\x1a\n" + header + rows + chunk(b"IEND", b"")


def moving():
    stream = io.BytesIO()
    frames = [Image.fromarray(figure()), Image.fromarray(figure()[:, ::-1])]
    frames[0].save(stream, "PNG", save_all=True, append_images=frames[1:])
    return stream.getvalue()


def kind(name):
    stream = io.BytesIO()
    Image.fromarray(figure()).save(stream, name)
    return stream.getvalue()


def many_scans(across=1000):
    """A JPEG whose last scan comes again and again: each a few bytes and a whole picture's work."""
    stream = io.BytesIO()
    Image.new("L", (across, across)).save(stream, "JPEG", progressive=True)
    whole = stream.getvalue()
    last = whole[whole.rindex(b"\xff\xda") : -2]
    return whole[:-2] + 1000 * last + whole[-2:]


HOSTILE = {
    "an SVG": (lambda: b"<svg xmlns='http://www.w3.org/2000/svg'/>", "wrong_type"),
    "a GIF": (lambda: kind("GIF"), "wrong_type"),
    "a WebP": (lambda: kind("WEBP"), "wrong_type"),
    "a PDF": (lambda: b"%PDF-1.7", "wrong_type"),
    "text": (lambda: b"a person", "wrong_type"),
    "a picture that moves": (moving, "animated"),
    "a bomb": (lambda: bomb(60_000, 60_000), "too_large"),
    "20,000 pixels": (lambda: bomb(20_000, 100), "too_large"),
    "many bytes": (lambda: file_of(figure()) + bytes(MOST_BYTES), "too_large"),
    "half a PNG": (lambda: file_of(figure())[:3000], "unreadable"),
    "half a JPEG": (lambda: file_of(figure(), "JPEG")[:3000], "unreadable"),
    "the start of a PNG": (lambda: file_of(figure())[:20], "unreadable"),
    "the start of a JPEG": (lambda: file_of(figure(), "JPEG")[:9], "unreadable"),
    "a JPEG of a thousand scans": (many_scans, "unreadable"),
    "a PNG with too few rows": (lambda: bomb(1000, 1000), "unreadable"),
}


@pytest.mark.parametrize(("content", "reason"), HOSTILE.values(), ids=HOSTILE)
def test_what_is_no_picture_to_be_read_is_refused(content, reason):
    assert refused(content()) == reason


ROOM = 128 * 2**20
SECONDS = 2
"""Bytes of memory, beside what the program itself takes, and seconds of a processor, for one
file: the largest picture that is read at all takes half of that, and a fraction of a second."""

BOUNDED = {
    "a bomb": (lambda: bomb(60_000, 60_000), "too_large"),
    "a whole bomb": (lambda: file_of(np.zeros((14_000, 14_000), np.uint8)), "too_large"),
    "many bytes": HOSTILE["many bytes"],
    "a picture that moves": HOSTILE["a picture that moves"],
    "large and of many scans": (lambda: many_scans(3600), "unreadable"),
    "the largest that is read": (lambda: file_of(np.zeros((3600, 3600), np.uint8)), "no_person"),
}

WITHIN_BOUNDS = """
import json, resource, sys
from model.masks import PictureRefusedError, read_mask

room, seconds = map(int, sys.argv[1:])
taken = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (taken + room, taken + room))
spent = resource.getrusage(resource.RUSAGE_SELF)
limit = int(spent.ru_utime + spent.ru_stime) + 1 + seconds
resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
try:
    read_mask(sys.stdin.buffer.read())
except PictureRefusedError as refused:
    print(json.dumps(refused.reason))
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="limits as Linux has them")
@pytest.mark.parametrize(("content", "reason"), BOUNDED.values(), ids=BOUNDED)
def test_no_file_costs_much_memory_or_much_of_a_processor(content, reason):
    """The kernel gives a process no more, and ends it."""
    ended = subprocess.run(
        [sys.executable, "-c", WITHIN_BOUNDS, str(ROOM), str(SECONDS)],
        input=content(),
        capture_output=True,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr.decode()
    assert json.loads(ended.stdout) == reason


@pytest.mark.parametrize("kind", ["PNG", "JPEG"])
def test_spoilt_files_are_read_or_refused_and_nothing_else(kind):
    random = np.random.default_rng(0)
    whole = np.frombuffer(file_of(figure()[::2, ::2], kind), dtype=np.uint8)
    for _ in range(60):
        spoilt = whole.copy()
        places = random.integers(0, min(len(whole), 400), 4)
        spoilt[places] = random.integers(0, 256, 4)
        with contextlib.suppress(PictureRefusedError):
            read_mask(spoilt.tobytes())


def test_runs_of_a_row():
    rows, starts, ends = runs(np.array([[1, 1, 0, 1], [0, 0, 0, 0], [0, 1, 1, 1]], dtype=bool))
    assert rows.tolist() == [0, 0, 2]
    assert starts.tolist() == [0, 3, 1]
    assert ends.tolist() == [2, 4, 4]
