"""The guide's words about girths, height and weight; checked against the table of measurements.

How each is taken stands in the table itself, for whoever reads nothing else. Where the wizard asks
in turn, it is said here anew, so short that it is read before the tape is laid.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

from flask_babel import lazy_gettext as _l


class Words(NamedTuple):
    """One measurement's words.

    what : what it is, for people who are no tailors
    mistake : where people usually go wrong
    alone : how to manage alone, where that is not plain; "" where it is
    how : how it is taken, beside what it is; "" where that is the table's sentence
    """

    what: Any
    mistake: Any
    alone: Any = ""
    how: Any = ""


_AROUND_A_LEG = _l("Feet apart, tape level.")

GIRTHS: Mapping[str, Words] = {
    "stature": Words(
        _l("Floor to top of head."),
        _l(
            "The height that people say is one to two centimetres, half an inch or more, above "
            "what a wall shows. Measure it once more, without shoes."
        ),
        _l("Alone: step out from under the book without moving it, then mark its lower edge."),
        _l("Barefoot against a wall, eyes ahead. Mark under a book flat on your head."),
    ),
    "weight": Words(
        _l("What a scale says."),
        _l(
            "Clothes and shoes weigh a kilogram or two, some pounds, and a scale on a carpet is "
            "wrong."
        ),
        how=_l("No shoes, light clothes."),
    ),
    "waist_girth": Words(
        _l("Around your narrowest part, above the trousers."),
        _l(
            "The waist of trousers and skirts sits lower, and the number on their label is "
            "another measurement."
        ),
        how=_l("Bend sideways: it creases there."),
    ),
    "bust_girth": Words(
        _l("Around your chest at its fullest."),
        _l("The tape slips down at the back. A mirror shows it."),
        how=_l("Straight across the back."),
    ),
    "abdomen_girth": Words(
        _l("Around your belly at the navel."),
        _l("The belly is pulled in without thinking of it. Breathe out, let go, then read."),
        how=_l("Relax your belly."),
    ),
    "hip_girth": Words(
        _l("Around your seat at its fullest."),
        _l(
            "Taken at the hip bones it is too high. The fullest place is lower, near where the "
            "legs begin."
        ),
        how=_l("Feet together, below the hip bones."),
    ),
    "underbust_girth": Words(
        _l("Around your ribs, directly under the bust, where the band of a bra lies."),
        _l("The size of a bra's band is not this number: measure, without a bra."),
    ),
    "thigh_girth": Words(
        _l("Around one thigh, just below the seat."),
        _l("The tape hangs down on the inside. Keep it square to the leg all the way round."),
        how=_AROUND_A_LEG,
    ),
    "mid_thigh_girth": Words(
        _l("Around one thigh, a hand's breadth above the knee."),
        _l(
            "Taken near the seat it is the thigh, another measurement; taken at the knee it is "
            "too small."
        ),
        how=_AROUND_A_LEG,
    ),
    "neck_girth": Words(
        _l("Around your neck, just below the larynx."),
        _l(
            "A shirt's collar has room in it: its size is one to two centimetres, about half an "
            "inch, more."
        ),
        how=_l("Look straight ahead. Tilt the tape as a collar sits."),
    ),
    "head_girth": Words(
        _l("Around your head at its widest, as a hat sits."),
        _l("The tape slides up at the back. It goes over the part that stands out most there."),
    ),
    "knee_girth": Words(
        _l("Around one knee, over the middle of the kneecap."),
        _l("A bent knee is larger. Stand with the leg straight and loose."),
    ),
    "ankle_girth": Words(
        _l("Around one leg at its thinnest, just above the ankle bones."),
        _l("Over the ankle bones themselves it is clearly more."),
    ),
    "calf_girth": Words(
        _l("Around one lower leg at its widest."),
        _l("On tiptoe or sitting the calf is another shape. Stand on both feet."),
    ),
    "lower_arm_girth": Words(
        _l("Around one forearm at its widest, a little below the elbow."),
        _l("A fist makes it larger. Let the hand hang open."),
        _l(
            "Alone: lay the tape in a loop first, slip the arm through it, and close it with the "
            "other hand."
        ),
    ),
    "upper_arm_girth": Words(
        _l("Around one upper arm at its narrowest, a hand's breadth above the elbow."),
        _l("Tensed muscles make it larger. Let the arm hang."),
        _l(
            "Alone: lay the tape in a loop first, slip the arm through it, and close it with the "
            "other hand."
        ),
    ),
    "elbow_girth": Words(
        _l("Around one elbow at its widest, with the arm almost straight."),
        _l("A bent elbow is larger."),
        _l(
            "Alone: lay the tape in a loop first, slip the arm through it, and close it with the "
            "other hand."
        ),
    ),
    "wrist_girth": Words(
        _l("Around one wrist at its narrowest, between the hand and the wrist bone."),
        _l("Over the bone it is more. The tape lies on the hand's side of it."),
    ),
    "armscye_girth": Words(
        _l("Around one shoulder, as a sleeve's seam runs: over its top and through the armpit."),
        _l("With the arm lifted it is another number. Let the arm hang while you read."),
        _l("Alone: a tight shirt whose seams lie there can be measured along its armhole instead."),
    ),
}
