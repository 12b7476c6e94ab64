"""What drives the real server reckons rightly; how fast that is, no test says."""

import io
import mmap
import os
import re
from collections import Counter
from pathlib import Path

import pytest
from werkzeug.formparser import parse_form_data

from bench.load import MIX, Load, comparison
from bench.serving import memory_of
from bench.tables import HOSTING, printed, put

MEGABYTE = 2**20


def test_only_what_was_answered_counts():
    load = Load(2, 4.0, {"page": [0.1, 0.2], "GLB": [0.3, 0.4]}, Counter({200: 4, 503: 3}))
    assert load.rate == 1.0
    assert load.quantile(0.5) == pytest.approx(0.25)
    assert load.quantile(1) == 0.4


def test_the_comparison_is_sent_in_parts_that_a_server_reads():
    content = comparison(b"a picture\r\n--")
    environ = {
        "wsgi.input": io.BytesIO(content),
        "CONTENT_LENGTH": str(len(content)),
        "CONTENT_TYPE": "multipart/form-data; boundary=part",
        "REQUEST_METHOD": "POST",
    }
    _, form, files = parse_form_data(environ)
    assert form["avatar"].startswith('{"body"')
    with files["front"].stream as sent:
        assert sent.read() == b"a picture\r\n--"


def test_the_mix_asks_for_everything():
    assert Counter(MIX) == {"page": 3, "avatar": 3, "GLB": 2, "picture": 1, "comparison": 1}


@pytest.mark.skipif(not Path("/proc/self/smaps_rollup").exists(), reason="Linux tells it")
def test_what_a_forked_process_has_of_its_parent_is_shared():
    held = mmap.mmap(-1, 64 * MEGABYTE, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    held[::4096] = bytes(len(held) // 4096)
    heard, said = os.pipe()
    child = os.fork()
    if child == 0:
        os.read(heard, 1)
        os._exit(0)
    try:
        before = memory_of(child)
        assert before.shared >= 64 * MEGABYTE
        assert 32 * MEGABYTE <= before.proportional < before.resident
        held[::4096] = bytes(len(held) // 4096)  # Written to, pages are each process's own.
        assert before.shared - memory_of(child).shared >= 64 * MEGABYTE
    finally:
        os.write(said, b".")
        os.waitpid(child, 0)


def test_a_table_takes_the_place_of_the_one_with_its_head(tmp_path, capsys):
    page = tmp_path / "page.md"
    page.write_text("Words.\n\n| a | b |\n|---|---|\n| old | 1 |\n\n| a |\n|---|\n| kept |\n")
    table = printed(["| a | b |", "|---|---|", r"| new \1 | 2 |", "| more | 3 |"])
    assert capsys.readouterr().out == table
    put(table, page)
    assert page.read_text() == f"Words.\n\n{table}\n| a |\n|---|\n| kept |\n"
    with pytest.raises(ValueError, match="0 tables with the head"):
        put("| c |\n|---|\n", page)


@pytest.mark.parametrize(
    "head", ["| clients | answers a second |", "| | alone, median |", "| fault |"]
)
def test_the_page_has_the_tables_that_are_put_there(head):
    assert len(re.findall(rf"^{re.escape(head)}", HOSTING.read_text(), re.MULTILINE)) == 1
