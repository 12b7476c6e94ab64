"""The words of self-measuring that the table of measurements does not hold."""

from model.measurements import BodyKind
from webapp.forms import FORM

BODY_WORDS: dict[BodyKind, tuple[str, str]] = {
    "female": ("A woman", "Estimated from women’s bodies"),
    "male": ("A man", "Estimated from men’s bodies"),
    "neutral": ("Neither", "Estimated from the mean of both"),
}

FIRST = ("stature", "weight", "bust_girth", "waist_girth", "abdomen_girth", "hip_girth")
"""What tells most about a body, and what most people know."""

REST = tuple(name for name in FORM if name not in FIRST)
"""The others, in the table's order."""

USUAL_MISTAKES = {
    "waist_girth": "Trousers and skirts often sit lower: their waist is another measurement.",
    "inseam_height": "The length printed on trousers runs further down; it is not this one.",
}
"""Where people measure something else, in one sentence."""
