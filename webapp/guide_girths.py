"""The guide's words about girths, height and weight; checked against the table of measurements.

How each is taken stands in the table itself; here is what it is, where people go wrong, and how to
manage without a helper.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

from flask_babel import lazy_gettext as _l


class Words(NamedTuple):
    """One measurement's words.

    what : what it is, for people who are no tailors
    mistake : where people usually go wrong
    alone : how to manage alone, where that is not plain; "" where it is
    """

    what: Any
    mistake: Any
    alone: Any = ""


GIRTHS: Mapping[str, Words] = {
    "stature": Words(
        _l("From the floor to the top of your head."),
        _l(
            "The height that people say is one to two centimetres, half an inch or more, above "
            "what a wall shows. Measure it once more, without shoes."
        ),
        _l("Alone: step out from under the book without moving it, then mark its lower edge."),
    ),
    "weight": Words(
        _l("What a scale says."),
        _l(
            "Clothes and shoes weigh a kilogram or two, some pounds, and a scale on a carpet is "
            "wrong."
        ),
    ),
    "waist_girth": Words(
        _l(
            "Around the narrowest part of your trunk. Bend to one side: it creases there. "
            "Trousers mostly sit lower."
        ),
        _l(
            "The waist of trousers and skirts sits lower, and the number on their label is "
            "another measurement."
        ),
    ),
    "bust_girth": Words(
        _l("Around your chest, over its fullest part."),
        _l("The tape slips down at the back. A mirror shows it."),
    ),
    "abdomen_girth": Words(
        _l("Around your belly, at the navel, where it is fullest."),
        _l("The belly is pulled in without thinking of it. Breathe out, let go, then read."),
    ),
    "hip_girth": Words(
        _l("Around your seat, where it stands out most seen from the side."),
        _l(
            "Taken at the hip bones it is too high. The fullest place is lower, near where the "
            "legs begin."
        ),
    ),
    "underbust_girth": Words(
        _l("Around your ribs, directly under the bust, where the band of a bra lies."),
        _l("The size of a bra's band is not this number: measure, without a bra."),
    ),
    "thigh_girth": Words(
        _l("Around one thigh at its widest, just below the seat."),
        _l("The tape hangs down on the inside. Keep it square to the leg all the way round."),
    ),
    "mid_thigh_girth": Words(
        _l("Around one thigh below its middle, about a hand's breadth above the kneecap."),
        _l(
            "Taken near the seat it is the thigh, another measurement; taken at the knee it is "
            "too small."
        ),
    ),
    "neck_girth": Words(
        _l("Around your neck at its narrowest, just below the larynx, where a collar lies."),
        _l(
            "A shirt's collar has room in it: its size is one to two centimetres, about half an "
            "inch, more."
        ),
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
