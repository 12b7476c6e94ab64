"""The paper's page says what was found, and its figures are there."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from model.anthropometry import TAKEN, measure_batch
from model.shape_basis import load_shape_basis
from model.template_mesh import load_template_mesh
from model.training import error_maps, measurement_report, selection_report, shape_report
from model.training.feature_selection import (
    SELECTED,
    Stability,
    candidates,
    scaled_variances,
    select,
)
from model.training.paper_models import LINEAR, PaperSpace
from model.training.paper_report import write_paper_report
from model.training.paper_validation import held_out, learned_from
from model.training.population import load_population
from model.training.shape_report import BEST, NOTHING, root_mean_square, try_models
from model.training.survey import SEXES, SURVEY_TAPES, is_test_person
from model.training.validation import FROM_SURVEY


@pytest.fixture(scope="module")
def population():
    """Every 25th body of the shipped one."""
    whole = load_population()
    some = np.arange(0, len(whole.sexes), 25)
    fields = ("sexes", "coefficients", "drawn", "taken", "log_odds", "held_out")
    return type(whole)(
        **{name: getattr(whole, name)[some] for name in fields}, seed=whole.seed, date=whole.date
    )


@pytest.fixture(scope="module")
def values(population):
    vertices = load_shape_basis().vertices(population.coefficients)
    return measure_batch(load_template_mesh(), vertices)


@pytest.fixture(scope="module")
def space():
    return PaperSpace.of(load_shape_basis(), load_template_mesh())


@pytest.fixture(scope="module")
def page(space, population, values, tmp_path_factory):
    """The page of a small population, with few rounds and people."""
    docs = tmp_path_factory.mktemp("docs")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(measurement_report, "MEASURED", 1)
        patch.setattr(measurement_report, "EVALUATED", 5)
        patch.setattr(shape_report, "MAPPED", {1: LINEAR})
        patch.setattr(shape_report, "MAPPED_SUBSETS", 2)
        patch.setattr(measurement_report, "MAPPED_SUBSETS", 1)
        patch.setattr(error_maps, "CELL", (84, 130))
        patch.setattr(error_maps, "SHOWN", {"front": 84, "profile": 42})
        patch.setattr(PaperSpace, "of", lambda *_: space)
        few = Stability(*[dict.fromkeys(candidates(TAKEN), 0.5)] * 2)
        patch.setattr(selection_report, "stability", lambda *_, **__: few)
        write_paper_report(population, values, docs, None)
    return docs


def test_the_page_holds_every_chapter(page) -> None:
    text = (page / "paper.md").read_text()
    chapters = re.findall(r"^## (.*)", text, re.MULTILINE)
    assert chapters == [
        "What the paper found, and what we find",
        "Feature selection",
        "Validation: body shape",
        "Validation: body measurements",
        "Evaluation: the sum of errors per person",
    ]
    assert "nan" not in text
    assert "Real people: not computed" in text


def test_its_tables_are_whole(page) -> None:
    text = (page / "paper.md").read_text()
    for block in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE):
        widths = {line.count("|") for line in block.splitlines()}
        assert len(widths) == 1, block


def test_its_figures_are_there(page) -> None:
    named = re.findall(r"\]\((images/[^)]*)\)", (page / "paper.md").read_text())
    assert len(named) == 7
    assert {f"images/{path.name}" for path in (page / "images").iterdir()} == set(named)
    for name in named:
        if name.endswith(".svg"):
            ElementTree.parse(page / name)
        else:
            with Image.open(page / name) as figure:
                assert figure.width > 200


def test_each_sex_has_its_seven(page) -> None:
    text = (page / "paper.md").read_text()
    for sex in SEXES:
        block = re.search(rf"^\| {sex} \| paper .*\n(?:\|.*\n)+", text, re.MULTILINE)[0]
        assert len(block.splitlines()) == SELECTED + 2


def surveyed(person, name):
    """What a made person measures, in the survey's units."""
    if name == "weightkg":
        return 700 + person
    return 500 + (31 + 7 * list(SURVEY_TAPES).index(name)) * person % 997


@pytest.fixture
def survey_rows(tmp_path):
    """Files in the survey's form, of 60 made people of each sex."""
    for sex in SEXES:
        rows = [["subjectid", *SURVEY_TAPES]]
        rows += [[p, *(surveyed(p, name) for name in SURVEY_TAPES)] for p in range(60)]
        text = "\n".join(",".join(map(str, row)) for row in rows)
        (tmp_path / f"{sex}_half_a.csv").write_text(text)
    return tmp_path


def test_real_people_are_told_only_what_the_survey_has(survey_rows) -> None:
    values = measurement_report.real_values(survey_rows, "female", 1)
    tested = [person for person in range(60) if is_test_person(str(person))]
    assert values.shape == (len(tested), len(TAKEN))
    weights = values[:, TAKEN.index("weight")]
    assert weights == pytest.approx([70 + person / 10 for person in tested])
    hips = [surveyed(person, "buttockcircumference") / 1e3 for person in tested]
    assert values[:, TAKEN.index("hip_girth")] == pytest.approx(hips)
    known = {name for name, column in zip(TAKEN, values.T, strict=True) if column[0] == column[0]}
    assert known == set(FROM_SURVEY)


def test_the_surveys_people_are_ranked_without_those_kept_for_tests(survey_rows) -> None:
    seen = [person for person in range(60) if not is_test_person(str(person))]
    values = np.array([[surveyed(p, name) for name in SURVEY_TAPES] for p in seen])
    first = list(SURVEY_TAPES)[int(scaled_variances(values / 1e3).argmax())]
    words = selection_report.survey_words(survey_rows)
    assert f"- female ({len(seen)}): `{first}`, " in words
    assert "of 34 with" in words


def test_a_trial_is_of_held_out_bodies(space, population, values) -> None:
    names = candidates(TAKEN)
    taken = values[:, [TAKEN.index(name) for name in names]]
    selections = {sex: select(names, taken[learned_from(population, sex)]) for sex in SEXES}
    trial = try_models(space, population, values, selections, "female")
    unseen = held_out(population, "female")
    assert (trial.values == values[unseen]).all()
    weights = trial.values[:, TAKEN.index("weight")]
    assert weights[trial.ends[0]] < np.median(weights) < weights[trial.ends[1]]
    mean = trial.errors[LINEAR, NOTHING]
    best = trial.errors[LINEAR, BEST]
    assert best.mean.mean() < mean.mean.mean()
    apart = trial.estimate(LINEAR, BEST, np.arange(len(unseen))) - trial.coordinates
    assert root_mean_square(space, apart) == pytest.approx(
        np.sqrt(3 * best.squared.mean()) * 1e3, rel=1e-3
    )
