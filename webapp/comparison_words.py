"""Words of comparisons: why a picture is refused, and why a photo and a body may differ."""

from collections.abc import Container, Mapping
from typing import Any, Literal

from flask_babel import lazy_gettext as _l

from model.comparison import Level
from model.masks import MOST_ACROSS, MOST_BYTES, MOST_PIXELS
from model.refinement import Worn

WORDS: Mapping[str, Any] = {
    "wrong_type": _l("A PNG or JPEG picture is needed here."),
    "animated": _l("A picture that stands still is needed here."),
    "unreadable": _l("This picture is broken or has not arrived whole. Please send it again."),
    "too_large": _l(
        "Pictures up to %(size)s MB, %(across)s pixels along a side and %(millions)s million "
        "pixels in all can be read.",
        size=MOST_BYTES // 2**20,
        across=MOST_ACROSS,
        millions=MOST_PIXELS // 10**6,
    ),
    "no_person": _l("We found no outline of a standing person here: light on dark, or cut out."),
    "cut_off": _l("The person is not all in the picture. Leave some space around head and feet."),
    "several_people": _l("There seems to be more than one person or thing in the picture."),
    "too_small": _l("The person is too small in the picture. Come nearer, or send it larger."),
}

CLOTHES: Mapping[Worn | Literal[""], Any] = {
    "": _l("I am not sure, or would rather not say"),
    "tight": _l("Underwear, or clothes that fit close everywhere"),
    "loose_top": _l("A loose top, close-fitting or bare below"),
    "loose_legs": _l("Loose trousers or a skirt, close-fitting or bare above"),
    "loose": _l("Loose above and below, or a dress"),
}
"""What may be worn in a photo, as the page asks; "" is the same as not saying."""

REASONS: tuple[tuple[str, Any, Any], ...] = (
    (
        "estimate",
        _l("An estimate"),
        _l("You did not enter this girth: the body there is an estimate."),
    ),
    ("clothes", _l("Clothes"), _l("Loose or thick cloth is wider than the body in it.")),
    (
        "hair",
        _l("Hair"),
        _l("Hair makes you taller and broader about the head than your body is."),
    ),
    (
        "stance",
        _l("How you stand"),
        _l(
            "Feet, hips and back rarely stand as the avatar's do; a turn of the body changes "
            "widths."
        ),
    ),
    (
        "breath",
        _l("Breath"),
        _l("Breathing in moves chest and belly by one to three centimetres, up to an inch."),
    ),
    (
        "camera",
        _l("The camera"),
        _l("Nearer, higher, lower or tilted: it sees another outline than the one we drew."),
    ),
    (
        "legs",
        _l("Legs"),
        _l("Apart or touching, tensed or at ease, they are of another width and depth."),
    ),
    (
        "tape",
        _l("The tape"),
        _l("A little higher or lower, tighter or looser, it tells the body another girth."),
    ),
    ("arms", _l("Arms"), _l("They are left out, and so is every level that they hide.")),
)
"""Why a photo and an avatar may differ though nothing is wrong: code, title, words."""

TITLES: Mapping[str, Any] = {code: title for code, title, _ in REASONS}

AT_LEVELS: Mapping[str, tuple[str, ...]] = {
    "neck_girth": ("hair", "clothes", "stance"),
    "bust_girth": ("clothes", "breath"),
    "underbust_girth": ("clothes", "breath"),
    "waist_girth": ("clothes", "breath"),
    "abdomen_girth": ("clothes", "breath"),
    "hip_girth": ("clothes", "stance"),
    "thigh_girth": ("clothes", "legs"),
    "mid_thigh_girth": ("clothes", "legs"),
    "knee_girth": ("clothes", "legs"),
    "calf_girth": ("clothes", "legs"),
    "ankle_girth": ("clothes", "legs", "camera"),
}
"""The usual reasons at each level, the likeliest first, whether or not its girth was entered."""

ADDING = ("clothes", "hair")
"""These make an outline broader and never narrower."""

NEARLY = 0.01
"""Metres: a difference up to this needs no reason."""


def reasons_at(level: Level, entered: Container[str]) -> list[str]:
    """Codes of what usually makes such a difference at such a level; none where it is small.

    Where its girth was not entered, that comes first: no tape was there.
    """
    apart = level.photo - level.avatar
    if abs(apart) < NEARLY:
        return []
    name = level.measurement
    usual = [code for code in AT_LEVELS[name] if apart > 0 or code not in ADDING]
    return [*usual, "tape"] if name in entered else ["estimate", *usual]
