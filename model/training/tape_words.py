"""How the code takes a measurement, in plain sentences made from its tape."""

import json
from collections.abc import Mapping, Sequence

from model.girths import Girth
from model.tapes import BODY_DENSITY, Geodesic, Height, Loop, Mass, Tape
from model.template_mesh import DATA

PARTS: Mapping[str, str] = {
    "head_neck": "head and neck",
    "torso": "torso",
    "upper_arm": "upper arm",
    "lower_arm": "lower arm",
    "hand": "hand",
    "upper_leg": "upper leg",
    "lower_leg": "lower leg",
    "foot": "foot",
}
NUMBERS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")


def landmark_places() -> Mapping[str, str]:
    """Where each landmark lies, by its name, in the order of the file."""
    with (DATA / "landmarks.json").open(encoding="utf-8") as file:
        rows = json.load(file)["landmarks"]
    return {name: row["where"] for name, row in rows.items()}


def how_taken(tape: Tape) -> str:
    """A tape in plain words; landmarks under their names.

    Raises
    ------
    TypeError
        For a kind of tape that there are no words for.
    """
    if isinstance(tape, Girth):
        return _girth(tape)
    if isinstance(tape, Loop):
        return f"A way over the skin through {_joined(_code(tape.through))} and back to the first."
    if isinstance(tape, Geodesic):
        start, *through, stop = tape.through
        over = f" over {_joined([f'`{name}`' for name in through])}" if through else ""
        return f"The shortest way over the skin from `{start}`{over} to `{stop}`."
    if isinstance(tape, Height):
        top = _point(tape.top) if tape.top else "the highest point of the body"
        bottom = _point(tape.bottom) if tape.bottom else "the soles"
        return f"Straight down from {top} to the level of {bottom}."
    if isinstance(tape, Mass):
        return f"The volume of the closed body times {BODY_DENSITY:,.0f} kg/m³."
    raise TypeError(f"there are no words for {tape!r}")


def _girth(tape: Girth) -> str:
    around = f"A taut tape around the {_parts(tape.parts)}"
    if tape.past:
        passed = _joined(_code([landmark for landmark, _ in tape.past]))
        around += f", passing by the skin around {passed}"
    start, stop = _point(tape.start), _point(tape.stop)
    if tape.cut == "level":
        lie = "kept level"
    elif tape.cut == "across":
        lie = f"kept square to the line from {start} to {stop}"
    else:
        back, front = ([ends[i] for ends in (tape.start, tape.stop)] for i in (0, -1))
        lie = (
            f"tilted as the line from the back ({_joined(_code(back))}) to the front "
            f"({_joined(_code(front))})"
        )
    low, high = tape.span
    if tape.planes == 1:
        return f"{around}, {lie}, {_percent(low)} of the way from {start} to {stop}."
    between = f"between {_percent(low)} and {_percent(high)} of the way"
    along = "along it" if tape.cut == "across" else f"from {start} to {stop}"
    return (
        f"{around}, {lie}. It is tried at {_count(tape.planes)} places {between} {along}; "
        f"the {tape.pick} counts."
    )


def _percent(fraction: float) -> str:
    return f"{fraction * 100:.0f} %".replace("-", "−")


def _count(number: int) -> str:
    return NUMBERS[number] if number < len(NUMBERS) else str(number)


def _point(landmarks: Sequence[str]) -> str:
    names = _code(landmarks)
    return names[0] if len(names) == 1 else f"the middle of {_joined(names)}"


def _code(landmarks: Sequence[str]) -> list[str]:
    return [f"`{name}`" for name in landmarks]


def _parts(parts: Sequence[str]) -> str:
    words = []
    for part in parts:
        for side in ("left", "right"):
            if part.endswith(f"_{side}"):
                words.append(f"{side} {PARTS[part.removesuffix(f'_{side}')]}")
                break
        else:
            words.append(PARTS[part] + ("s" if part in BOTH_SIDES else ""))
    return _joined(words)


BOTH_SIDES = frozenset({"upper_arm", "lower_arm", "hand", "upper_leg", "lower_leg"})


def _joined(words: Sequence[str]) -> str:
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last
