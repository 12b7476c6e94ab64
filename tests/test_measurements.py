import math

import pytest

from model.measurements import BODY_KINDS, MEASUREMENTS, MeasurementSet


def test_the_table_has_41_rows_of_four_kinds() -> None:
    kinds = [row.kind for row in MEASUREMENTS.values()]
    assert {kind: kinds.count(kind) for kind in set(kinds)} == {
        "height": 8,
        "girth": 17,
        "length": 15,
        "mass": 1,
    }


@pytest.mark.parametrize("row", MEASUREMENTS.values(), ids=lambda row: row.name)
def test_every_row_is_complete(row) -> None:
    assert row.label and row.definition and row.source
    assert row.how_to.endswith(".")
    assert row.in_wizard <= set(BODY_KINDS)
    assert row.unit == ("kg" if row.name == "weight" else "m")
    assert row.iso8559_note.endswith(".") and row.ansur2_definition.endswith(".")
    assert (row.ansur2_definition == "Not measured.") <= (not row.survey_columns)


def test_a_row_names_one_column_of_the_survey_or_two_or_none() -> None:
    assert MEASUREMENTS["stature"].survey_columns == ("stature",)
    assert MEASUREMENTS["inseam_height"].survey_columns == (
        "crotchheight",
        "lateralmalleolusheight",
    )
    assert MEASUREMENTS["waist_girth"].survey_columns == ()
    assert sum(len(row.survey_columns) > 0 for row in MEASUREMENTS.values()) == 27


def test_a_measurement_set_keeps_the_tables_order() -> None:
    values = MeasurementSet({"weight": 60, "stature": 1.7})
    assert list(values) == ["stature", "weight"]
    assert values == {"stature": 1.7, "weight": 60.0}


def test_a_measurement_set_is_frozen_and_hashable() -> None:
    values = MeasurementSet({"stature": 1.7})
    with pytest.raises(TypeError):
        values["stature"] = 1.8  # type: ignore[index]
    assert hash(values) == hash(MeasurementSet({"stature": 1.7}))


@pytest.mark.parametrize("value", [0, -1.7, math.nan, math.inf])
def test_a_value_that_cannot_be_is_refused(value: float) -> None:
    with pytest.raises(ValueError, match="stature must be positive and finite"):
        MeasurementSet({"stature": value})


def test_an_unknown_name_is_refused() -> None:
    with pytest.raises(ValueError, match="no measurement is called 'height'"):
        MeasurementSet({"height": 1.7})


@pytest.mark.parametrize("row", MEASUREMENTS.values(), ids=lambda row: row.name)
def test_whoever_measures_at_the_waist_is_told_which_waist(row) -> None:
    if "waist" in row.definition or row.name == "waist_girth":
        assert "narrowest" in row.how_to
