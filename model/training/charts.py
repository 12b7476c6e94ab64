"""Small charts as SVG, for the documents: bars, boxes, lines, and a table of shades.

Plain XML through the standard library: what is drawn is a few rectangles and words. Colours
are dark enough on white and differ in lightness too, so that they are told apart without hue.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

import numpy as np

from model.geometry import Floats

INK, FAINT, GRID = "#222222", "#666666", "#dddddd"
PLAIN, MARKED = "#b7c0cc", "#1f5f99"
LINES = ("#1f5f99", "#c4572e", "#3f7f4c", "#7a4b94")
DASHES = ("", "7 4", "2 3", "9 3 2 3")
FONT = "Helvetica, Arial, sans-serif"
ROW = 17


@dataclass(frozen=True)
class Bar:
    """A named bar.

    Attributes
    ----------
    name : what stands beside it.
    value : its length, from zero.
    words : what stands at its end.
    marked : whether it is drawn in the strong colour.
    """

    name: str
    value: float
    words: str
    marked: bool = False


def bars(panels: Mapping[str, Sequence[Bar]], *, note: str = "") -> str:
    """Horizontal bars, a panel beside the other, all on one scale; as the text of an SVG."""
    longest = max((bar.value for panel in panels.values() for bar in panel), default=0.0) or 1.0
    count = max(map(len, panels.values()), default=0)
    names, wide, words = 190, 170, 60
    panel_width = names + wide + words
    svg, pen = _canvas(panel_width * len(panels), ROW * count + 50)
    for column, (title, panel) in enumerate(panels.items()):
        left = column * panel_width
        pen.text(left + names, 18, title, weight="bold")
        for row, bar in enumerate(panel):
            top = 30 + row * ROW
            length = wide * bar.value / longest
            pen.text(left + names - 6, top + 11, bar.name, anchor="end", size=11)
            colour = MARKED if bar.marked else PLAIN
            pen.draw("rect", x=left + names, y=top, width=length, height=ROW - 5, fill=colour)
            pen.text(left + names + length + 4, top + 11, bar.words, size=10, colour=FAINT)
    pen.text(8, 30 + count * ROW + 14, note, size=11, colour=FAINT)
    return _written(svg)


def boxes(panels: Mapping[str, Mapping[str, Floats]], *, note: str = "") -> str:
    """Where values between 0 and 1 lie, a panel beside the other; as the text of an SVG.

    Parameters
    ----------
    panels : by title and name, ndarrays of shape (n,), NaN left out. A box holds the middle
        half of the values, with a stroke at the median; its line nine tenths of them.
    """
    count = max(map(len, panels.values()), default=0)
    names, wide, margin = 190, 200, 30
    panel_width = names + wide + margin
    svg, pen = _canvas(panel_width * len(panels), ROW * count + 64)
    for column, (title, panel) in enumerate(panels.items()):
        left = column * panel_width + names
        pen.text(left, 18, title, weight="bold")
        for tick in (0.0, 0.25, 0.5, 0.75, 1.0):
            x = left + wide * tick
            pen.draw("line", x1=x, x2=x, y1=28.0, y2=30.0 + ROW * count, stroke=GRID)
            pen.text(x, 44 + ROW * count, f"{tick:g}", anchor="middle", size=10, colour=FAINT)
        for row, (name, values) in enumerate(panel.items()):
            middle = 36.0 + row * ROW
            ends = left + wide * np.nanquantile(values, [0.05, 0.25, 0.5, 0.75, 0.95])
            low, first, median, third, high = ends.tolist()
            pen.text(left - 6, middle + 5, name, anchor="end", size=11)
            pen.draw("line", x1=low, x2=high, y1=middle, y2=middle, stroke=FAINT)
            box = {"x": first, "y": middle - 5, "width": third - first, "height": 10}
            pen.draw("rect", **box, fill=PLAIN)
            at_median = {"x1": median, "x2": median, "y1": middle - 5, "y2": middle + 5}
            pen.draw("line", **at_median, stroke=MARKED, **{"stroke-width": 2})
    pen.text(8, 60 + count * ROW, note, size=11, colour=FAINT)
    return _written(svg)


def lines(
    across: Sequence[float],
    series: Mapping[str, Sequence[float]],
    *,
    title: str,
    across_label: str,
    up_label: str,
    logarithmic: bool = False,
) -> str:
    """Lines over a common axis that starts at zero upwards; as the text of an SVG.

    Parameters
    ----------
    across : the n places of the points.
    series : by name, n values each.
    logarithmic : whether places lie by their logarithm; all must then be positive.
    """
    width, height, left, top = 640, 310, 62, 54
    inner_width, inner_height = width - left - 170, height - top - 52
    places = np.log(across) if logarithmic else np.asarray(across, dtype=float)
    reach = max((places[-1] - places[0]), 1e-12)
    ticks = round_ticks(max(max(values) for values in series.values()))
    svg, pen = _canvas(width, height)
    pen.text(left, 20, title, weight="bold")

    def x(place: float) -> float:
        return left + inner_width * (place - places[0]) / reach

    def y(value: float) -> float:
        return top + inner_height * (1 - value / ticks[-1])

    for tick in ticks:
        pen.draw("line", x1=left, x2=left + inner_width, y1=y(tick), y2=y(tick), stroke=GRID)
        pen.text(left - 6, y(tick) + 4, f"{tick:g}", anchor="end", size=11)
    last = -np.inf
    for place, value in zip(places, across, strict=True):
        if x(place) - last >= 22:
            last = x(place)
            pen.text(last, top + inner_height + 16, f"{value:g}", anchor="middle", size=11)
    pen.text(left + inner_width / 2, height - 14, across_label, anchor="middle", size=12)
    pen.text(left, 38, up_label, size=12, colour=FAINT)
    heights = _apart([y(values[-1]) for values in series.values()], 14)
    for i, ((name, values), label_height) in enumerate(zip(series.items(), heights, strict=True)):
        points = " ".join(f"{x(p):.1f},{y(v):.1f}" for p, v in zip(places, values, strict=True))
        colour, dashes = LINES[i % len(LINES)], DASHES[i % len(DASHES)]
        style = {"stroke": colour, "stroke-width": 2, "stroke-dasharray": dashes}
        pen.draw("polyline", points=points, fill="none", **style)
        pen.text(x(places[-1]) + 6, label_height + 4, name, size=11, colour=colour)
    return _written(svg)


def shades(names: Sequence[str], values: Floats, *, title: str) -> str:
    """A square of values from -1 to 1, each in its cell, shaded by size; as an SVG's text.

    Parameters
    ----------
    values : ndarray of shape (n, n), one row and column a name.
    """
    cell, left, top = 44, 200, 40
    svg, pen = _canvas(left + cell * len(names) + 150, top + 26 * len(names) + 20)
    pen.text(8, 20, title, weight="bold")
    for i, name in enumerate(names):
        pen.text(left - 6, top + 26 * i + 17, name, anchor="end", size=11)
        pen.text(left + cell * (i + 1) + 4, top + 26 * i + 17, name if i else "", size=10)
        for j in range(i + 1):
            value = float(values[i, j])
            corner = {"x": left + cell * j, "y": top + 26 * i}
            pen.draw("rect", **corner, width=cell - 2, height=24, fill=_shade(value))
            ink = "white" if abs(value) > 0.6 else INK
            where = (corner["x"] + cell / 2 - 1, corner["y"] + 16)
            words = f"{value:.2f}".replace("-0.00", "0.00")
            pen.text(*where, words, anchor="middle", size=11, colour=ink)
    return _written(svg)


def round_ticks(largest: float) -> list[float]:
    """From zero to at least the largest value in three to six round steps."""
    if not largest > 0:
        return [0.0, 1.0]
    power = 10 ** np.floor(np.log10(largest))
    step = next(s * power for s in (0.2, 0.5, 1.0, 2.0) if largest / (s * power) <= 5.0)
    count = int(np.ceil(largest / step - 1e-9))
    return [float(round(i * step, 12)) for i in range(count + 1)]


def _apart(heights: Sequence[float], distance: float) -> list[float]:
    """Heights moved downwards so that none is nearer to another than a distance."""
    moved = list(heights)
    lowest = -np.inf
    for i in np.argsort(heights, kind="stable"):
        moved[i] = lowest = max(heights[i], lowest + distance)
    return moved


def _shade(value: float) -> str:
    """From white at zero to blue at one, to brown at minus one."""
    end = np.array([31, 95, 153] if value >= 0 else [170, 88, 30])
    mixed = np.array([255, 255, 255]) + min(abs(value), 1) * (end - 255)
    return "#" + "".join(f"{round(channel):02x}" for channel in mixed)


@dataclass(frozen=True)
class _Pen:
    svg: ElementTree.Element

    def draw(self, shape: str, **attributes: Any) -> None:
        written = {
            name: f"{value:.1f}" if isinstance(value, float) else str(value)
            for name, value in attributes.items()
            if value != ""
        }
        ElementTree.SubElement(self.svg, shape, written)

    def text(
        self,
        x: float,
        y: float,
        words: str,
        *,
        size: int = 13,
        anchor: str = "start",
        colour: str = INK,
        weight: str = "normal",
    ) -> None:
        style = {"font-size": str(size), "text-anchor": anchor, "font-weight": weight}
        place = {"x": f"{x:.1f}", "y": f"{y:.1f}", "fill": colour}
        ElementTree.SubElement(self.svg, "text", place | style).text = words


def _canvas(width: float, height: float) -> tuple[ElementTree.Element, _Pen]:
    size = {"width": f"{width:g}", "height": f"{height:g}", "viewBox": f"0 0 {width:g} {height:g}"}
    space = {"xmlns": "http://www.w3.org/2000/svg", "font-family": FONT}
    svg = ElementTree.Element("svg", space | size)
    pen = _Pen(svg)
    pen.draw("rect", width=width, height=height, fill="white")
    return svg, pen


def _written(svg: ElementTree.Element) -> str:
    ElementTree.indent(svg)
    return ElementTree.tostring(svg, encoding="unicode") + "\n"
