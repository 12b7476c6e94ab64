"""Writes ``docs/measurements.md``: every measurement, its picture, and how it is spread.

Pictures and the table of the population are made by :func:`write_guide`; the words by
:func:`guide_text`, from the table of measurements, the tapes and those files alone.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from model.anthropometry import TAKEN, TAPES, measure
from model.measurements import MEASUREMENTS, Kind, Measurement
from model.shape_basis import load_shape_basis
from model.tape_pictures import tape_picture, text_alternative
from model.template_mesh import Body, load_template_mesh
from model.training.population import Population, load_population
from model.training.population_report import table
from model.training.segment_picture import SEGMENTS, segment_picture, segment_words
from model.training.spreads import Spread, load_spreads, load_survey_measurements, write_spreads
from model.training.survey import SEXES, Sex
from model.training.tape_words import how_taken, landmark_places
from model.training.train import measure_population

DOCS = Path("docs")
PAGE = "measurements.md"
PICTURES = Path("images", "measurements")
SPREADS = "measurements_population.csv"

BOTH_SEXES = ("waist_girth", "bust_girth", "hip_girth")
"""Drawn on a man too: the tape lies elsewhere on him, or looks as if it did."""

LARGEST_PICTURE = 30_000
"""Bytes."""

HEADINGS: Mapping[Kind, str] = {
    "height": "Heights",
    "mass": "Weight",
    "girth": "Girths",
    "length": "Lengths over the skin",
}

PEOPLE: Mapping[Sex, str] = {"female": "Women", "male": "Men"}


def write_guide(docs: Path = DOCS) -> None:
    """Measures the population, draws all pictures and writes the page."""
    population = load_population()
    write_spreads(population, measure_population(population), docs / SPREADS)
    draw_pictures(population, docs)
    (docs / PAGE).write_text(guide_text(docs), encoding="utf-8")
    print(f"wrote {docs / PAGE}")


def mean_body(population: Population, sex: Sex) -> Body:
    """The mean of one sex, weighted back to the survey."""
    mine = population.of(sex)
    weights = np.exp(population.log_odds[mine])
    mean = weights @ population.coefficients[mine] / weights.sum()
    vertices = load_shape_basis().vertices(mean[None])[0]
    return Body(template=load_template_mesh(), vertices=vertices, kind=sex)


def draw_pictures(population: Population, docs: Path = DOCS) -> None:
    """Draws each measurement, and the segments.

    Raises
    ------
    ValueError
        If a picture is larger than `LARGEST_PICTURE`.
    """
    (docs / PICTURES).mkdir(parents=True, exist_ok=True)
    drawn: dict[Path, bytes] = {}
    for sex in SEXES:
        body = mean_body(population, sex)
        paths = measure(body).paths
        for name in TAKEN if sex == "female" else BOTH_SEXES:
            drawn[docs / picture_of(name, sex)] = tape_picture(body, name, paths[name])
    template = load_template_mesh()
    neutral = Body(template=template, vertices=template.vertices, kind="neutral")
    drawn[docs / PICTURES / "segments.webp"] = segment_picture(neutral)
    for path, picture in drawn.items():
        if len(picture) > LARGEST_PICTURE:
            raise ValueError(f"{path} has {len(picture)} bytes, more than {LARGEST_PICTURE}")
        path.write_bytes(picture)
    print(f"drew {len(drawn)} pictures, {sum(map(len, drawn.values())) / 1e3:.0f} kB")


def picture_of(name: str, sex: Sex = "female") -> Path:
    """Where the picture of a measurement is, in the folder of documents."""
    return PICTURES / (f"{name}.webp" if sex == "female" else f"{name}_{sex}.webp")


# ---- the words ----------------------------------------------------------------------------------


def guide_text(docs: Path = DOCS) -> str:
    """The page, from the table, the tapes and the written spreads."""
    population = load_population()
    pieces = [
        "# The measurements",
        "Written by `make guide`; do not edit. Bodies are those of the open population of "
        f"{population.date}, seed {population.seed}; pictures show its mean woman, and where "
        "said its mean man.",
        _FOREWORD,
        _contents(),
        "## Segments",
        _segments(),
    ]
    for kind, heading in HEADINGS.items():
        names = [name for name in TAKEN if MEASUREMENTS[name].kind == kind]
        pieces += [f"## {heading}", *[_entry(MEASUREMENTS[name]) for name in names]]
    pieces += [
        "## The population beside the survey",
        _SURVEY_WORDS,
        *[_beside_survey(load_spreads(docs / SPREADS), sex) for sex in SEXES],
        "### Why they differ",
        _why_they_differ(),
        "## Landmarks",
        "Named points of the skin, the same on every body: a triangle of the template mesh and "
        "a place in it.",
        table(
            ["landmark", "where"],
            [[f"`{name}`", where] for name, where in landmark_places().items()],
            numbers=False,
        ),
    ]
    return "\n\n".join(pieces) + "\n"


_FOREWORD = """\
The paper says 41 measurements and tabulates 39: 17 girths, 15 lengths and 7 heights. Its text and
its Table 4 add the height of the whole body, *stature* here. The 41st is never named; ours is
*weight*, which every shopper knows, and which tells more about what a shopper leaves out than any
single girth.

- A **girth** is what a taut tape reads: the perimeter of the convex hull of the plane section of
  that body part. Limbs and the neck are cut across: a level cut through the neck reads 5 to 6 %
  too much. Where a definition says narrowest or widest, planes are tried at fixed shares of the
  way between landmarks, so that the value moves continuously with the body even where two places
  compete. Where a part only tapers, as the thigh does towards the knee, the narrowest place is the
  end of the stretch that is tried.
- A **length** is the shortest way over the skin through the named points, in their order.
- A **height** is a vertical distance.
- **Which waist?** The paper takes the narrowest part of the torso, and so do we. ISO 8559-1 and
  ISO 7250-1 take the level midway between the lowest rib and the top of the hip bone, ANSUR II
  takes the navel. These differ by centimetres. Lengths and heights that end at the waist end at its
  landmark, which lies midway as the standard's does: a landmark stays with the skin, where the
  narrowest place may lie some centimetres above it or below.
- **Which inseam?** The paper measures from the groin to the *ankle*. From the groin to the *floor*,
  the inside leg height of ISO 8559-1, it is `inseam_height` and `foot_height` together.
- **How well can it be taken?** Measurers of the ANSUR surveys were allowed to differ from one
  another by 15 mm at the chest, 12 at hips and waist, 10 at stature and crotch height, 5 at the
  head and 4 at the ankle. ISO 20685 asks of a body scanner 9 mm on large girths, 4 mm on small
  girths and heights and 5 mm on segment lengths. Untrained people do worse: 622 adults measured
  their own waists 60 ± 48 mm too large, while 750 others, who had a sheet with pictures, were right
  on average: guidance decides more than any model.

Limbs are measured on the left; the standard and the survey take the right. Tapes are drawn solid
where the skin is seen and faint where the body hides it. Terms of ISO 8559-1:2017 are followed by
their clause where it is known for certain; columns of ANSUR II are defined in Hotzman et al. 2011
(NATICK/TR-11/017)."""

_SURVEY_WORDS = """\
Mean ± deviation, and the smallest and the largest; in mm, weight in kg. The population is wide by
design, so that thin and heavy people are served as well as the crowd: *weighted* gives each body
the weight that its stature and weight have in the survey, and that is what compares; the range is
that of the bodies as they are. The survey: ANSUR II, soldiers of 17 to 58 years, few of them heavy,
without the people kept for tests; computed by `python -m model.training survey FOLDER` from its
rows. Where it measures something else, the reason stands below. Exact figures of the population:
[measurements_population.csv](measurements_population.csv)."""


def _contents() -> str:
    lines = []
    for kind, heading in HEADINGS.items():
        rows = [row for row in MEASUREMENTS.values() if row.kind == kind and row.name in TAKEN]
        lines.append(f"- {heading}: " + ", ".join(f"[{row.label}](#{row.name})" for row in rows))
    lines.append(
        "- [The population beside the survey](#the-population-beside-the-survey), "
        "[Landmarks](#landmarks)"
    )
    return "\n".join(lines)


def _segments() -> str:
    names = load_template_mesh().part_names
    rows = []
    for part, (words, _) in SEGMENTS.items():
        own = [f"`{name}`" for name in names if name in (part, f"{part}_left", f"{part}_right")]
        rows.append([words, ", ".join(own)])
    return "\n\n".join(
        [
            "Each triangle of the template belongs to one part; borders run along the "
            "mesh's edges.",
            f"![{segment_words()}]({(PICTURES / 'segments.webp').as_posix()})",
            table(["segment", "parts of the template"], rows, numbers=False),
        ]
    )


def _entry(row: Measurement) -> str:
    pictures = [_picture(row.name, "female")]
    if row.name in BOTH_SEXES:
        pictures += ["On a man:", _picture(row.name, "male")]
    how = row.how_to + (" It takes a second pair of hands." if row.helper_needed else "")
    facts = [
        ["name", f"`{row.name}`"],
        ["definition", row.definition],
        ["source", row.source],
        ["how to take it", how],
        ["how the code takes it", how_taken(TAPES[row.name])],
        ["ISO 8559-1", _term(f"*{row.iso8559}*" if row.iso8559 else "", row.iso8559_note)],
        ["ANSUR II", _term(_columns(row), row.ansur2_definition)],
    ]
    return "\n\n".join(
        [
            f'### <a id="{row.name}"></a>{row.label}',
            *pictures,
            table(["", ""], facts, numbers=False),
        ]
    )


def _picture(name: str, sex: Sex) -> str:
    return f"![{text_alternative(name, sex)}]({picture_of(name, sex).as_posix()})"


def _columns(row: Measurement) -> str:
    return " less ".join(f"`{column}`" for column in row.survey_columns)


def _term(term: str, note: str) -> str:
    return f"{term}. {note}" if term else note


def _beside_survey(spreads: Mapping[tuple[Sex, str], Spread], sex: Sex) -> str:
    survey = load_survey_measurements()
    rows = []
    for name in TAKEN:
        ours, theirs = spreads[sex, name], survey.get((sex, name))
        heavy = MEASUREMENTS[name].kind == "mass"
        mine, seen = _cells(ours, heavy), _cells(theirs, heavy)
        apart = _number(ours.mean - theirs.mean, heavy, "+") if theirs else ""
        rows.append([f"[{name}](#{name})", mine[0], seen[0], apart, mine[1], seen[1]])
    people = max(spread.count for (who, _), spread in survey.items() if who == sex)
    head = [
        "",
        f"weighted ({spreads[sex, TAKEN[0]].count} bodies)",
        f"survey ({people} people)",
        "apart",
        "range",
        "survey's range",
    ]
    return f"### {PEOPLE[sex]}\n\n{table(head, rows)}"


def _cells(spread: Spread | None, heavy: bool) -> tuple[str, str]:
    if spread is None:
        return "", ""
    mean, deviation, low, high = (
        _number(value, heavy) for value in (spread.mean, spread.deviation, spread.low, spread.high)
    )
    return f"{mean} ± {deviation}", f"{low} to {high}"


def _number(value: float, heavy: bool, sign: str = "") -> str:
    """Millimetres, or kilograms."""
    text = f"{value:{sign}.1f}" if heavy else f"{value * 1e3:{sign}.0f}"
    return text.replace("-", "−")


def _why_they_differ() -> str:
    lines = []
    for name in TAKEN:
        row = MEASUREMENTS[name]
        if row.survey_columns and "the same" not in row.ansur2_definition.lower():
            lines.append(f"- [{name}](#{name}), {_columns(row)}: {row.ansur2_definition}")
    return "\n".join(lines)
