"""A lean slice of ``make fuzz``: whatever is sent, no answer is a failure of ours."""

import pytest

import fuzz
from webapp import create_app


@pytest.mark.parametrize("way", ["forms", "pictures", "bytes"])
def test_nothing_that_is_sent_breaks_the_site(way):
    tally = fuzz.Tally()
    fuzz.WAYS[way](create_app(fuzz.SETTINGS), tally, 60, 1)
    assert tally.total(way) >= 60


def test_a_failure_is_told_with_what_was_sent(client):
    tally = fuzz.Tally()
    tally.count("forms", client.get("/nothing"), "this")
    response = client.get("/nothing")
    response.status_code = 500
    with pytest.raises(AssertionError, match="500 for forms: 'this'"):
        tally.count("forms", response, "this")
