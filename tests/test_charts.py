"""Charts against the numbers that they show."""

from xml.etree import ElementTree

import numpy as np
import pytest

from model.training.charts import Bar, bars, boxes, lines, round_ticks, shades

SVG = "{http://www.w3.org/2000/svg}"


def words(svg):
    return [text.text or "" for text in svg.iter(f"{SVG}text")]


def test_bars_are_as_long_as_their_values() -> None:
    panels = {
        "women": [Bar("waist & hip", 2.0, "two", marked=True), Bar("neck", 1.0, "one")],
        "men": [Bar("calf", 0.5, "half")],
    }
    svg = ElementTree.fromstring(bars(panels, note="strong: marked"))
    drawn = list(svg.iter(f"{SVG}rect"))[1:]
    longest, *rest = (float(bar.get("width")) for bar in drawn)
    assert rest == pytest.approx([longest / 2, longest / 4], abs=0.1)
    assert drawn[0].get("fill") != drawn[1].get("fill") == drawn[2].get("fill")
    assert set(words(svg)) >= {"women", "men", "waist & hip", "half", "strong: marked"}


def test_bars_of_nothing_are_drawn() -> None:
    svg = ElementTree.fromstring(bars({"none missing": [Bar("neck", 0.0, "0")]}))
    assert list(svg.iter(f"{SVG}rect"))[1].get("width") == "0.0"


def test_boxes_lie_where_their_values_do() -> None:
    even = np.append(np.linspace(0, 1, 201), np.nan)
    svg = ElementTree.fromstring(boxes({"women": {"even": even, "low": even / 4}}, note="n"))
    drawn = list(svg.iter(f"{SVG}rect"))[1:]
    (left, width), (low_left, low_width) = (
        (float(box.get("x")), float(box.get("width"))) for box in drawn
    )
    assert low_width == pytest.approx(width / 4, abs=0.1)
    zero = left - width / 2
    assert low_left - zero == pytest.approx((left - zero) / 4, abs=0.1)
    strokes = [line for line in svg.iter(f"{SVG}line") if line.get("stroke-width")]
    assert float(strokes[0].get("x1")) == pytest.approx(left + width / 2, abs=0.1)
    assert {"women", "even", "low", "0.25", "n"} <= set(words(svg))


@pytest.mark.parametrize("logarithmic", [False, True])
def test_lines_go_through_their_points(logarithmic) -> None:
    across = [1, 10, 100]
    picture = lines(
        across,
        {"ours": [4.0, 2.0, 0.0], "theirs": [4.0, 4.0, 4.0]},
        title="t",
        across_label="a",
        up_label="u",
        logarithmic=logarithmic,
    )
    svg = ElementTree.fromstring(picture)
    ours, theirs = (
        np.array([point.split(",") for point in line.get("points").split()], dtype=float)
        for line in svg.iter(f"{SVG}polyline")
    )
    share = (ours[1, 0] - ours[0, 0]) / (ours[2, 0] - ours[0, 0])
    assert share == pytest.approx(0.5 if logarithmic else 9 / 99, abs=1e-3)
    assert ours[1, 1] == pytest.approx((ours[0, 1] + ours[2, 1]) / 2, abs=0.1)
    assert theirs[:, 1] == pytest.approx(np.repeat(ours[0, 1], 3))
    assert {"ours", "theirs", "0", "4"} <= set(words(svg))


def test_lines_that_end_together_are_named_apart() -> None:
    picture = lines(
        [1, 2], {"a": [1.0, 1.0], "b": [1.0, 1.0]}, title="", across_label="", up_label=""
    )
    svg = ElementTree.fromstring(picture)
    heights = [float(t.get("y")) for t in svg.iter(f"{SVG}text") if t.text in ("a", "b")]
    assert abs(heights[0] - heights[1]) >= 14


def test_shades_say_each_pair_once() -> None:
    values = np.array([[1.0, 0.25, -0.5], [0.25, 1.0, -0.001], [-0.5, -0.001, 1.0]])
    svg = ElementTree.fromstring(shades(["one", "two", "three"], values, title="alike"))
    assert sorted(w for w in words(svg) if "." in w) == ["-0.50", "0.00", "0.25", *["1.00"] * 3]
    fills = [cell.get("fill") for cell in svg.iter(f"{SVG}rect")][1:]
    assert fills[0] == fills[2] == fills[5] != fills[1]


@pytest.mark.parametrize("largest", [0.0, 0.031, 1.0, 7.3, 19.0, 41.0, 50.0, 5300.0])
def test_ticks_are_few_round_and_reach(largest) -> None:
    ticks = round_ticks(largest)
    assert ticks[0] == 0
    assert ticks[-1] >= largest
    assert 2 <= len(ticks) <= 7
    assert np.diff(ticks) == pytest.approx(ticks[1])
    assert len(ticks) == 2 or ticks[-2] < largest
