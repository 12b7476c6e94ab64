"""What drives the real server reckons rightly; how fast that is, no test says."""

import io
from collections import Counter

import pytest
from werkzeug.formparser import parse_form_data

from bench.load import MIX, Load, comparison


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
