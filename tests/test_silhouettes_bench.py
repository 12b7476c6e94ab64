"""The trial of outlines: what it makes is what it says, and it runs."""

import numpy as np
import pytest

from bench import refining, silhouettes
from bench.__main__ import main
from bench.outlines import roughened, with_arms
from model.masks import Mask
from model.template_mesh import Body, load_template_mesh


@pytest.fixture
def body():
    template = load_template_mesh()
    return Body(template, template.vertices, "neutral")


def test_arms_are_turned_and_nothing_else(body):
    template = body.template
    still = with_arms(body, (0.0, 0.0), (0.0, 0.0))
    assert still.vertices == pytest.approx(body.vertices)
    lifted = with_arms(body, (0.2, 0.0), (0.0, 0.1))
    left, left_after, right, right_after = (
        template.landmark_points(one.vertices, name)
        for name in ("stylion_left", "stylion_right")
        for one in (body, lifted)
    )
    assert left_after[1] > left[1] + 0.02
    assert left_after[0] > left[0] + 0.02
    assert right_after[2] > right[2] + 0.02
    others = np.unique(template.faces[template.faces_of("head_neck", "upper_leg", "foot")])
    assert (lifted.vertices[others] == body.vertices[others]).all()


def test_an_outline_is_moved_by_a_share_of_its_breadth_and_by_cloth():
    bar = Mask(np.ones((600, 200), dtype=np.float32), 0, 0, 1)
    random = np.random.default_rng(0)
    calm, rough = (roughened(bar, share, 1.8, random) for share in (0.0, 0.02))
    assert calm[30:-30, 30:-30].min() > 0.49
    assert calm.sum() == pytest.approx(bar.cover.sum(), rel=0.01)
    breadths = rough[60:-60].sum(axis=1)
    # 2 % of 200 pixels, shared by two edges.
    assert breadths.std() == pytest.approx(4, rel=0.2)
    clothed = roughened(bar, 0.0, 1.8, random, cloth=0.02)
    more = (len(clothed) - len(calm)) // 2  # space around it, for the cloth
    thicker = clothed[more:-more].sum(axis=1) - calm.sum(axis=1)
    assert thicker[300] == pytest.approx(2 * 0.02 / 1.8 * 600, abs=1.1)
    assert thicker[600] == pytest.approx(0, abs=1e-6)


def test_the_trial_prints_its_tables(capsys, tmp_path, monkeypatch):
    page = tmp_path / "comparison.md"
    page.write_text(f"Words.\n\n{silhouettes.MARK}\nold figures\n")
    monkeypatch.setattr(silhouettes, "PAGE", page)
    how = {"known": 1, "bodies": 1, "others": 1, "processes": 1}
    main(["silhouettes", "--write", *(f"--{name}={value}" for name, value in how.items())])
    printed = capsys.readouterr().out
    assert "1 of 1" in printed
    assert "8 measurements entered | 1 |" in printed
    assert page.read_text() == f"Words.\n\n{silhouettes.MARK}\n{printed.rstrip()}\n"


def test_more_bodies_than_there_are_are_refused():
    with pytest.raises(ValueError, match="100000 bodies are not from 1 to"):
        silhouettes.chosen(100_000, 0)


def test_what_is_left_over_is_as_sure_as_its_bodies_agree():
    random = np.random.default_rng(5)
    before = random.uniform(5, 15, (4000, 100))
    after = before * random.normal(0.7, 0.2, before.shape)
    told = np.array([refining.left_over(*pair) for pair in zip(before, after, strict=True)])
    assert told[:, 0].mean() == pytest.approx(0.7, abs=0.002)
    assert told[:, 1].mean() == pytest.approx(told[:, 0].std(), rel=0.05)
