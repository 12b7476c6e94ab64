"""Where the time of a request goes: every part is told once, and all together are the whole."""

import cProfile
import time
from collections import Counter

from bench import stages


def test_parts_and_the_rest_are_the_whole():
    took = Counter({"tape_fit.fit_to_tape": 0.5, "packing": 0.25, "JSON": 0.001})
    assert list(stages.table("avatar", 10, 1.0, took)) == [
        "| avatar | 100.0 ms | |",
        "| | tape_fit.fit_to_tape | 50% |",
        "| | packing | 25% |",
        "| | the rest | 25% |",
    ]


def test_the_models_time_is_told_by_what_the_site_calls(site):
    profile = cProfile.Profile(time.perf_counter)
    client = site.test_client()
    profile.enable()
    answer = stages.send(client, "avatar", b"")
    profile.disable()
    assert answer.status_code == 200
    total, took = stages.stages(profile)
    assert set(took) >= {"tape_fit.fit_to_tape", "anthropometry.measure", "packing", "JSON"}
    # What the fit calls itself is no row beside it.
    assert not [name for name in took if name.startswith(("girths.", "geodesics."))]
    assert took.total() <= total * (1 + 1e-9)
