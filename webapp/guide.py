"""The guide to self-measuring: which steps there are, their words and their pictures."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from flask_babel import gettext, lazy_gettext
from flask_babel import lazy_gettext as _l

from model.measurements import MEASUREMENTS, BodyKind
from webapp import readings
from webapp.answers import LEG, LEG_ENDS, Typed
from webapp.guide_girths import GIRTHS, Words
from webapp.guide_lengths import LENGTHS
from webapp.table_words import ALTERNATIVES, how_to, labels

WORDS: Mapping[str, Words] = {**GIRTHS, **LENGTHS}

BODY_WORDS: Mapping[BodyKind, Any] = {
    "female": _l("A woman"),
    "male": _l("A man"),
    "neutral": _l("Neither"),
}

_ROUND = (
    "stature",
    "weight",
    "bust_girth",
    "waist_girth",
    "abdomen_girth",
    "hip_girth",
    "thigh_girth",
    "mid_thigh_girth",
    "neck_girth",
    "inseam_height",
)
"""In the order in which a tape goes down the body."""

QUICK = tuple(name for name in _ROUND if MEASUREMENTS[name].in_wizard)
"""What the one form for those who know their numbers asks, of all kinds of body."""

GROUPS: Mapping[str, tuple[Any, tuple[str, ...]]] = {
    "trunk": (
        _l("Around the trunk, the neck and the head"),
        (
            "bust_girth", "underbust_girth", "waist_girth", "abdomen_girth", "hip_girth",
            "neck_girth", "head_girth",
        ),
    ),
    "limbs": (
        _l("Around arms and legs"),
        (
            "thigh_girth", "mid_thigh_girth", "knee_girth", "calf_girth", "ankle_girth",
            "armscye_girth", "upper_arm_girth", "elbow_girth", "lower_arm_girth", "wrist_girth",
        ),
    ),
    "heights": (
        _l("Heights and weight"),
        (
            "stature", "weight", "inseam_height", "foot_height", "waist_height",
            "waist_to_knee_height", "hip_to_ankle_height", "torso_height", "neck_height",
        ),
    ),
    "lengths": (_l("Over the skin"), tuple(LENGTHS)[:15]),
}  # fmt: skip
"""All measurements, as a person looks for them."""

_ROUND_ELSEWHERE = frozenset({"neck_girth", "head_girth", "armscye_girth"})
_TRUNK = frozenset(GROUPS["trunk"][1]) - _ROUND_ELSEWHERE

WEAR: Mapping[str, Any] = {
    "trunk": _l("Over thin, close-fitting underwear or bare skin; no belt, empty pockets."),
    "bust": _l("On bare skin or over a thin bra without padding."),
    "skin": _l("On bare skin."),
    "head": _l("No hat, the hair pressed flat beneath the tape."),
    "feet": _l("Without shoes and thick socks."),
    "light": _l("Without shoes, in light clothes."),
}

TAPE: Mapping[str, Any] = {
    "trunk": _l(
        "Level all the way round: a mirror shows it. Snug on the skin, not tight, and nothing "
        "added for comfort. Read it at the end of a quiet breath out."
    ),
    "limb": _l("Square to the limb, snug on the skin, not tight. Muscles are loose."),
    "round": _l("Flat all the way round, snug and not tight."),
    "length": _l("Along the skin, flat, neither pulled nor slack."),
    "height": _l("Straight and upright, beside the body and not along it."),
}

BUILDS: Sequence[tuple[str, float]] = (("slim", 23.0), ("medium", 29.0), ("broad", 1e9))
"""The builds that are drawn, each up to a body-mass index half-way to the next, in kg/m²."""

PLACES: Mapping[str, tuple[tuple[str, Any], ...]] = {
    "waist_girth": (
        ("waist_girth", _l("Narrowest part")),
        ("abdomen_girth", _l("Navel")),
    ),
    "abdomen_girth": (
        ("abdomen_girth", _l("Navel")),
        ("waist_girth", _l("Narrowest part")),
    ),
    "bust_girth": (
        ("bust_girth", _l("Fullest part")),
        ("underbust_girth", _l("Under the bust")),
    ),
    "underbust_girth": (
        ("underbust_girth", _l("Under the bust")),
        ("bust_girth", _l("Fullest part")),
    ),
}
"""Where else people lay the tape who are asked for a measurement, and what they measure then."""

LEG_WORDS: Mapping[str, Any] = {
    "floor": _l("Floor"),
    "ankle": _l("Ankle bone"),
    "trousers": _l("Trousers’ label, inches"),
}

_LEG_PICTURES: Mapping[str, Any] = {
    "floor": _l("A line beside the leg from the crotch to the floor."),
    "ankle": _l("A line beside the leg from the crotch to the ankle bone."),
    "trousers": _l("A line beside the leg from the crotch to a little above the floor."),
}


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture of the guide: its file under ``static/``, its size in pixels, and its words."""

    file: str
    width: int
    height: int
    words: str


def steps(body: str) -> tuple[str, ...]:
    """The measurements that the wizard asks one kind of body, in order.

    They are the paper's final seven of each sex (its Table 4), which share six; with weight and the
    inside leg. Our own repetition of its selection chooses less telling ones (docs/paper.md).
    """
    return tuple(name for name in _ROUND if (body or "neutral") in MEASUREMENTS[name].in_wizard)


def build(typed: Typed) -> str:
    """The drawn build that comes nearest to a person's; the medium one until it is known."""
    stature, weight = typed.values("stature"), typed.values("weight")
    if not (stature and weight) or typed.body in ("", "neutral"):
        return "medium"
    index = readings.middle(weight) / readings.middle(stature) ** 2
    return next(name for name, most in BUILDS if index < most)


def how(name: str) -> Any:
    """How a measurement is taken, beside what it is."""
    return WORDS[name].how or how_to(name)


def says_tape(name: str, body: str) -> bool:
    """Whether a step is the first of the way with a tape around the body: how that lies on all of
    them is said there, above the number, and below it ever after.
    """
    return name == next(step for step in steps(body) if MEASUREMENTS[step].kind == "girth")


def picture(name: str, typed: Typed) -> Picture:
    """A measurement's tape on a body like theirs."""
    body = typed.body or "neutral"
    views = ALTERNATIVES[name].views
    return Picture(
        f"guide/{name}_{body}_{build(typed)}.webp",
        328 * views - 8,
        400,
        gettext("%(label)s: %(what)s", label=labels()[name], what=WORDS[name].what)
        + " "
        + str(ALTERNATIVES[name].words),
    )


def leg_pictures(typed: Typed) -> dict[str, Picture]:
    """The inside leg down to each place that people measure it to."""
    body, drawn = typed.body or "neutral", build(typed)
    return {
        end: Picture(
            f"guide/inside_leg_{end}_{body}_{drawn}.webp", 320, 400, str(_LEG_PICTURES[end])
        )
        for end in LEG_ENDS
    }


def wear(name: str, body: str = "") -> Any:
    """What to wear for a measurement."""
    if name in ("bust_girth", "underbust_girth"):
        return WEAR["skin" if body == "male" else "bust"]
    if name == "weight":
        return WEAR["light"]
    if name == "head_girth":
        return WEAR["head"]
    if MEASUREMENTS[name].kind == "height":
        return WEAR["feet"]
    if name in _TRUNK or name in ("rise_length", "glute_length", "front_lower_trunk_length"):
        return WEAR["trunk"]
    return WEAR["skin"]


def tape(name: str) -> Any:
    """How the tape is held; "" for a scale."""
    kind = MEASUREMENTS[name].kind
    if kind == "mass":
        return ""
    if kind == "girth":
        if name in _TRUNK:
            return TAPE["trunk"]
        return TAPE["round" if name in _ROUND_ELSEWHERE else "limb"]
    return TAPE["height" if kind == "height" else "length"]


def helper(name: str) -> Any:
    """Whether it takes two, and what to do alone."""
    if MEASUREMENTS[name].helper_needed and name != LEG:
        return lazy_gettext("Best done by someone else.") + " " + WORDS[name].alone
    return WORDS[name].alone
