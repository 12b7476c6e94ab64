"""Units: what people type, and that it survives a change of units."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from webapp.units import (
    SYMBOLS,
    UNITS,
    convert,
    from_si,
    parse,
    range_in,
    show,
    show_signed,
    to_si,
    write,
)


@pytest.mark.parametrize(
    ("typed", "units", "metres"),
    [
        ("168", "metric", 1.68),
        (" 168.0 ", "metric", 1.68),
        ("92,5", "metric", 0.925),
        ("92.", "metric", 0.92),
        ("168 cm", "metric", 1.68),
        ("168cms.", "metric", 1.68),
        ("1.68 m", "metric", 1.68),
        ("1,68 metres", "imperial", 1.68),
        ("1 m 68", "metric", 1.68),
        ("1680 mm", "metric", 1.68),
        ("１６８", "metric", 1.68),
        ("66", "imperial", 1.6764),
        ("66 in", "metric", 1.6764),
        ("66 inches", "metric", 1.6764),
        ("5'6", "imperial", 1.6764),
        ("5'6\"", "imperial", 1.6764),
        ("5’6”", "imperial", 1.6764),
        ("5′ 6″", "imperial", 1.6764),
        ("5' 6''", "imperial", 1.6764),
        ("5 ft 6", "imperial", 1.6764),
        ("5ft, 6in", "imperial", 1.6764),
        ("5 feet and 6 inches", "metric", 1.6764),
        ("5.5 ft", "imperial", 1.6764),
        ("5 ft 6 1/2 in", "imperial", 1.6891),
        ("36 1/4", "imperial", 0.92075),
        ("36-1/4", "imperial", 0.92075),
        ("36¼", "imperial", 0.92075),
        ("1/2", "imperial", 0.0127),
        ("15/16", "imperial", 0.0238125),
    ],
)
def test_lengths_as_people_type_them(typed, units, metres):
    assert parse(typed, "m", units) == pytest.approx(metres, abs=1e-12)


@pytest.mark.parametrize(
    ("typed", "units", "kilograms"),
    [
        ("65,5", "metric", 65.5),
        ("65.5 kg", "imperial", 65.5),
        ("65 kilos", "metric", 65),
        ("150", "imperial", 68.0388555),
        ("150 lbs", "metric", 68.0388555),
        ("11 st 4", "imperial", 71.66759446),
        ("11 stone 4 pounds", "metric", 71.66759446),
    ],
)
def test_weights_as_people_type_them(typed, units, kilograms):
    assert parse(typed, "kg", units) == pytest.approx(kilograms, abs=1e-9)


@pytest.mark.parametrize(
    "typed",
    [
        "", " ", "about 170", "-5", "1e3", "nan", "inf", "1.2.3", "1,680,5", "5 6", "5-6", "1/0",
        "'", "5'6'", "12 kg", "5 ft 6 cm", "6 in 5", "168 x", "cm", "½½", "0x10", "--",
    ],
)  # fmt: skip
def test_what_is_no_length_is_refused(typed):
    with pytest.raises(ValueError, match=r"not a number|not a unit|zero parts"):
        parse(typed, "m", "metric")


@given(st.text(max_size=24), st.sampled_from(UNITS))
def test_any_text_is_a_value_or_refused(typed, units):
    try:
        value = parse(typed, "m", units)
    except ValueError:
        return
    assert value >= 0


@given(st.floats(1e-3, 1e3), st.sampled_from(tuple(SYMBOLS)), st.sampled_from(UNITS))
def test_si_and_back(value, quantity, units):
    assert from_si(to_si(value, quantity, units), quantity, units) == pytest.approx(
        value, rel=1e-14
    )


def test_an_inch_and_a_pound_are_exact():
    assert to_si(1, "m", "imperial") == 0.0254
    assert to_si(1, "kg", "imperial") == 0.45359237


@pytest.mark.parametrize("quantity", ["m", "kg"])
@pytest.mark.parametrize(("old", "new"), [UNITS, UNITS[::-1]])
def test_tenths_survive_a_change_of_units_and_back(quantity, old, new):
    for tenths in range(30, 2500):
        typed = write(tenths / 10, 1)
        there = convert(typed, quantity, old, new)
        assert convert(there, quantity, new, old) == typed


def test_eighths_of_an_inch_survive_a_change_of_units_and_back():
    for eighths in range(8, 8 * 90):
        typed = write(eighths / 8, 3)
        there = convert(typed, "m", "imperial", "metric")
        assert convert(there, "m", "metric", "imperial") == typed


@given(st.decimals(3, 250, places=2).map(str), st.sampled_from([UNITS, UNITS[::-1]]))
def test_a_change_of_units_moves_no_value_by_more_than_half_a_tenth(typed, units):
    old, new = units
    moved = parse(convert(typed, "m", old, new), "m", new) - parse(typed, "m", old)
    assert abs(moved) <= to_si(0.05, "m", old) + 1e-9


def test_stature_becomes_feet_and_inches():
    assert convert("168", "m", "metric", "imperial", feet=True) == "5 ft 6.14 in"
    assert convert("5 ft 6.14 in", "m", "imperial", "metric", feet=True) == "168"
    assert convert("182.88", "m", "metric", "imperial", feet=True) == "6 ft 0 in"


def test_what_is_no_number_stays_as_it_was_typed():
    assert convert("about 170", "m", "metric", "imperial") == "about 170"
    assert convert("170", "m", "metric", "metric") == "170"


def test_numbers_as_they_stand_in_a_table():
    assert show(0.9204, "m", "metric") == "92.0"
    assert show(68.0388555, "kg", "imperial") == "150.0"
    assert show(1.68, "m", "imperial", feet=True) == "5′ 6.1″"
    assert show(1.8287, "m", "imperial", feet=True) == "6′ 0.0″"
    assert show(1.68, "m", "metric", feet=True) == "168.0"
    assert show(15.25 * 0.0254, "m", "imperial") == "15.3"
    assert show(15.25 * 0.0254, "m", "imperial", entered=True) == "15.25"
    assert show(66.25 * 0.0254, "m", "imperial", feet=True, entered=True) == "5′ 6.25″"
    assert show(0.92, "m", "metric", entered=True) == "92.0"
    assert show_signed(0.004, "m", "metric") == "+0.4"
    assert show_signed(-0.012, "m", "metric") == "−1.2"
    assert show_signed(-0.0001, "m", "metric") == "0.0"


@given(st.floats(0.05, 2), st.floats(0.05, 2), st.sampled_from(UNITS))
def test_a_limit_as_it_is_told_lies_within_the_limits(one, other, units):
    low, high = sorted((one, other))
    for places in (1, 3):
        told_low, told_high = range_in(low, high, "m", units, places)
        assert to_si(told_low, "m", units) >= low - 1e-8
        assert to_si(told_high, "m", units) <= high + 1e-8
