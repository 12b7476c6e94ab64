import pytest

from model.anthropometry import TAKEN, TAPES
from model.girths import Girth
from model.tapes import Geodesic, Height, Loop, Mass, Span
from model.template_mesh import load_template_mesh
from model.training.tape_words import how_taken, landmark_places


@pytest.mark.parametrize("name", TAKEN)
def test_every_tape_has_words_that_name_all_its_landmarks(name):
    words = how_taken(TAPES[name])
    assert words.endswith(".")
    tape = TAPES[name]
    for field in ("start", "stop", "top", "bottom", "through"):
        for landmark in getattr(tape, field, ()):
            assert f"`{landmark}`" in words


@pytest.mark.parametrize(
    ("tape", "words"),
    [
        (Height(), "Straight down from the highest point of the body to the level of the soles."),
        (
            Height(("crotch",), ("a", "b")),
            "Straight down from `crotch` to the level of the middle of `a` and `b`.",
        ),
        (Mass(), "The volume of the closed body times 1,000 kg/m³."),
        (
            Geodesic(("cervicale", "crotch", "omphalion")),
            "The shortest way over the skin from `cervicale` over `crotch` to `omphalion`.",
        ),
        (
            Girth(("torso", "upper_leg"), ("a",), ("b",), (-0.1, 0.25), "widest", planes=3),
            "A taut tape around the torso and upper legs, kept level. It is tried at three places "
            "between −10 % and 25 % of the way from `a` to `b`; the widest counts.",
        ),
        (
            Girth(("hand_left",), ("a",), ("b",), (0, 1), "narrowest", cut="across", planes=12),
            "A taut tape around the left hand, kept square to the line from `a` to `b`. It is "
            "tried at 12 places between 0 % and 100 % of the way along it; the narrowest counts.",
        ),
        (
            Girth(("head_neck",), ("a", "b"), ("c", "d"), (0, 1), cut="slanted", planes=2),
            "A taut tape around the head and neck, tilted as the line from the back (`a` and `c`) "
            "to the front (`b` and `d`). It is tried at two places between 0 % and 100 % of the "
            "way from the middle of `a` and `b` to the middle of `c` and `d`; the widest counts.",
        ),
        (
            Loop(("a", "b", "c")),
            "A way over the skin through `a`, `b` and `c` and back to the first.",
        ),
        (
            Girth(("torso",), ("a",), ("b",), past=(("c", 0.05), ("d", 0.05))),
            "A taut tape around the torso, passing by the skin around `c` and `d`, kept level, "
            "0 % of the way from `a` to `b`.",
        ),
        (
            Girth(("torso",), ("a",), ("b",)),
            "A taut tape around the torso, kept level, 0 % of the way from `a` to `b`.",
        ),
    ],
    ids=lambda value: type(value).__name__,
)
def test_tapes_in_words(tape, words):
    assert how_taken(tape) == words


def test_a_tape_without_words_is_refused():
    with pytest.raises(TypeError, match="there are no words for Span"):
        how_taken(Span("a", "b"))


def test_every_landmark_of_the_template_has_its_place():
    assert list(landmark_places()) == list(load_template_mesh().landmarks)
