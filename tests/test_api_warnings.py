"""The API's warnings: what it says of entered values."""

import pytest

from webapp.forms import FITS


def test_values_that_contradict_each_other_are_warned_of(call):
    document = {
        "body": "female",
        "measurements": {"stature": 168, "bust_girth": 140, "underbust_girth": 70},
    }
    answer = call("/api/v1/avatars", document).json
    rows = {row["name"]: row for row in answer["measurements"]}
    warnings = {(one["measurement"], one["code"]): one for one in answer["warnings"]}
    both = {"bust_girth", "underbust_girth"}
    assert set(warnings) == {(name, code) for name in both for code in ("not_met", "contradicts")}
    for (name, code), warning in warnings.items():
        row = rows[name]
        low, high = warning["expected"]
        assert not low < row["asked"] < high
        if code == "not_met":
            assert f"on the body it is {row['taken']:.1f} cm" in warning["message"]
            assert [row["low"], row["high"]] == sorted([row["taken"], row["asked"]])
        else:
            assert warning["conflicts"] == list(both - {name})
            assert f"{low:.1f} cm to {high:.1f} cm would be usual" in warning["message"]


@pytest.mark.parametrize(
    ("changed", "code", "suggestion", "said"),
    [
        ({"weight": 62 / 0.45359237}, "unit_mix_up", 62, "62.0 kg would go with the others"),
        ({"neck_girth": 44}, "unusual", None, "seems unusual beside the other"),
        ({"inseam_height": 84}, "neighbouring_definition", 77, "taken to the floor"),
    ],
)
def test_what_seems_unusual_is_warned_of_with_what_was_meant(call, changed, code, suggestion, said):
    values = {"stature": 168, "weight": 62, "hip_girth": 98, "bust_girth": 92, "neck_girth": 33}
    document = {"body": "female", "measurements": values | changed}
    answers = [call("/api/v1/avatars", document | {"fit": fit}).json for fit in FITS]
    for answer in answers:
        [warning] = [one for one in answer["warnings"] if one["code"] != "not_met"]
        assert (warning["measurement"], warning["code"]) == (*changed, code)
        assert warning.get("suggestion") == pytest.approx(suggestion, abs=1)
        assert said in warning["message"]
