"""The bench runs, and compares like with like; how fast anything is, no test says."""

import numpy as np
import pytest

from bench.__main__ import main
from bench.measuring import GIRTHS, measure_rows, time_population
from bench.peer import PeerGirth
from bench.timing import Timings, take_turns
from model.anthropometry import TAPES, measure_batch
from model.template_mesh import load_template_mesh


def test_the_bench_prints_its_table(capsys):
    main(
        ["--rounds", "1", "--warm-up", "0", "--bodies", "2", "--processes", "1", "--requests", "0"]
    )
    printed = capsys.readouterr().out
    assert "cores" in printed
    assert f"{len(GIRTHS)} of them girths" in printed
    assert "2 bodies of the population" in printed


def test_the_peer_takes_the_girths_that_we_take():
    template = load_template_mesh()
    ours = measure_batch(template, template.vertices[None], GIRTHS)[0]
    for name, girth in zip(GIRTHS, ours, strict=True):
        peer = PeerGirth.of(name, TAPES[name], template)
        planes = peer.planes(template, template.vertices)
        theirs, number = peer.take(template.vertices, planes)
        assert theirs == pytest.approx(girth, abs=1e-6)
        assert peer.take(template.vertices, planes, only=number) == (theirs, number)


def test_a_plane_that_misses_the_part_is_named():
    template = load_template_mesh()
    peer = PeerGirth.of("bust_girth", TAPES["bust_girth"], template)
    planes = peer.planes(template, template.vertices)
    planes.origins[:, 1] += 5
    with pytest.raises(ValueError, match="misses the part of bust_girth"):
        peer.take(template.vertices, planes)


def test_ways_take_turns_after_their_warm_up():
    calls = []
    ways = {name: lambda name=name: calls.append(name) for name in ("ours", "theirs")}
    timings = take_turns(ways, rounds=3, warm_up=2)
    assert calls == ["ours", "theirs"] * 2 + ["ours", "ours", "theirs", "theirs"] * 3
    assert {name: len(seconds) for name, seconds in timings.seconds.items()} == {
        "ours": 3,
        "theirs": 3,
    }


def test_ratios_are_taken_round_by_round():
    reckoned = {"ours": np.array([1.0, 2.0, 4.0]), "theirs": np.array([3.0, 6.0, 40.0])}
    timings = Timings({name: 2 * seconds for name, seconds in reckoned.items()}, reckoned)
    assert timings.median("ours") == 4.0
    assert timings.median_reckoned("ours") == 2.0
    assert timings.spread("ours") == (3.0, 6.0)
    assert timings.ratio("theirs", "ours") == 3.0


def test_no_round_is_refused():
    with pytest.raises(ValueError, match="0 rounds are not at least 1"):
        take_turns({}, rounds=0, warm_up=0)


def test_more_bodies_than_there_are_are_refused():
    with pytest.raises(ValueError, match="1000000 bodies are not from 1 to"):
        time_population(1_000_000, [1])


def test_a_part_of_the_population_is_measured():
    reckoned, making = measure_rows(np.arange(2))
    assert reckoned >= making >= 0
