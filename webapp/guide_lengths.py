"""The guide's words about lengths over the skin and about heights; as in `guide_girths`."""

from collections.abc import Mapping

from flask_babel import lazy_gettext as _l

from webapp.guide_girths import Words

_RIBBON = _l("Alone: tie a ribbon around your waist where it is narrowest, and measure from it.")
_STICK = _l("Alone: fix the end of the tape to the skin with a plaster, and read in a mirror.")
_WALL = _l(
    "Alone: stand against a wall, mark both places on it with a pencil, step away and measure "
    "between the marks."
)

LENGTHS: Mapping[str, Words] = {
    "shoulder_length": Words(
        _l("From the tip of one shoulder to the tip of the other, along the collarbones in front."),
        _l("Over the back it is another number."),
        _STICK,
    ),
    "rise_length": Words(
        _l("From the front of your waist, between the legs, to the back of your waist."),
        _l("Taken from the waistband of trousers it is shorter. Begin where you are narrowest."),
        _RIBBON,
    ),
    "glute_length": Words(
        _l(
            "From the middle of your back at the height of the navel, over one seat cheek, to the "
            "fold under it."
        ),
        _l("The tape ends at the fold, where the leg begins, and not further down."),
        _STICK,
    ),
    "neck_to_waist_length": Words(
        _l("Down your back, from the bone at the bottom of the neck to the waist."),
        _l("It begins at the bone that stands out when you bend your head, not at the hair."),
        _RIBBON,
    ),
    "collarbone_to_waist_length": Words(
        _l("Down your front, from the collarbone over the fullest part of the chest to the waist."),
        _l("The tape hangs free under the bust. It follows the skin down to the waist."),
        _RIBBON,
    ),
    "upper_arm_length": Words(
        _l("From the tip of the shoulder to the elbow, along the outside of the arm."),
        _l("It begins at the bone at the shoulder's end, not at the neck."),
        _STICK,
    ),
    "lower_arm_length": Words(
        _l("From the elbow to the wrist bone, along the outside of the arm."),
        _l("It ends at the bone on the wrist's outside, not at the hand."),
        _STICK,
    ),
    "breast_length": Words(
        _l("From where the breast begins, above, over its fullest part to just under it."),
        _l("It does not begin at the collarbone: that is another measurement."),
        _STICK,
    ),
    "front_lower_trunk_length": Words(
        _l("From the middle of the front of your waist down to the lowest point between the legs."),
        _l("It ends in front, at the lowest point, and does not go round to the back."),
        _RIBBON,
    ),
    "armpit_to_waist_length": Words(
        _l("Down your side, from the armpit to the waist."),
        _l("The tape goes straight down, with the arm hanging."),
        _RIBBON,
    ),
    "collarbone_to_underbust_length": Words(
        _l("From the collarbone over the fullest part of the chest to just under the bust."),
        _l("The tape follows the skin under the bust and does not hang free."),
        _STICK,
    ),
    "underbust_to_belly_button_length": Words(
        _l("Down the middle of your front, from just under the bust to the navel."),
        _l("It begins at the level of the band of a bra."),
    ),
    "arm_length": Words(
        _l("From the tip of the shoulder over the elbow to the wrist bone."),
        _l("A sleeve's length is measured from the neck on many labels: that is more."),
        _STICK,
    ),
    "groin_length": Words(
        _l(
            "From where the belly ends, above the pubic bone, to the lowest point between the legs."
        ),
        _l("It begins low, where the belly ends, and not at the navel."),
    ),
    "belly_length": Words(
        _l("Down the middle of your front, from just under the bust to where the belly ends."),
        _l("It goes past the navel, down to just above the pubic bone."),
    ),
    "waist_to_knee_height": Words(
        _l("Straight down from your waist to the middle of the kneecap."),
        _l("Over the curve of the hips it is longer: measure straight down, beside the body."),
        _WALL,
    ),
    "waist_height": Words(
        _l("From the floor to the narrowest part of your trunk."),
        _l("The waistband of trousers is lower."),
        _WALL,
    ),
    "inseam_height": Words(
        _l("From the crotch straight down."),
        _l("Everyone measures it differently. So we ask where your number ends."),
        _l(
            "Alone: the book is level when its spine lies flat on the wall. Mark its upper edge "
            "there, step away, and measure."
        ),
        _l("Barefoot against a wall, pull a thin book up between your legs. Measure from its top."),
    ),
    "foot_height": Words(
        _l("From the floor to the bone that stands out on the outside of the ankle."),
        _l("To the middle of the bone, not to where the foot begins."),
    ),
    "torso_height": Words(
        _l(
            "From the bone at the bottom of the neck, behind, to the lowest point between the legs."
        ),
        _l("Measured over the back it is longer: take two heights from the floor instead."),
        _WALL,
    ),
    "neck_height": Words(
        _l("From under your chin straight down to the collarbone."),
        _l("With the chin up it is longer. Look straight ahead."),
        _l("Alone: hold a ruler upright before your neck, and read in a mirror."),
    ),
    "hip_to_ankle_height": Words(
        _l("From the height of the fullest part of your seat to the outer ankle bone."),
        _l("Measure straight down, beside the leg, and not along its curve."),
        _WALL,
    ),
}
