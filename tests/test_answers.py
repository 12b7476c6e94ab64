"""What a person typed: nothing is lost, and every reading comes to what was meant."""

import pytest
from conftest import LIMITS

from model.measurements import MEASUREMENTS
from model.plausibility import TROUSERS_SHORT_OF_FLOOR
from webapp.answers import ANKLE_SHARE, HEM_NOISE, TYPED_LENGTH, Typed
from webapp.forms import Refused


def faults_of_form(**fields):
    with pytest.raises(Refused) as refused:
        Typed.of({"body": "female", "stature": "168"} | fields).read(LIMITS)
    return {fault.field: fault for fault in refused.value.faults}


def test_a_form_is_read_as_it_was_typed():
    fields = {"body": "male", "units": "imperial", "stature": "5'6", "waist_girth": "34 1/2"}
    wanted = Typed.of(fields).read(LIMITS)
    assert wanted.body == "male"
    assert wanted.units == "imperial"
    assert wanted.asked["stature"] == pytest.approx(1.6764)
    assert wanted.asked["waist_girth"] == pytest.approx(0.8763)


def test_a_form_without_a_body_or_a_height_is_refused():
    assert {field: fault.code for field, fault in faults_of_form(body="", stature=" ").items()} == {
        "body": "required",
        "stature": "required",
    }


def test_what_is_no_number_is_refused_with_a_way_to_write_one():
    assert "57.5 or 57,5" in faults_of_form(waist_girth="thin")["waist_girth"].message
    imperial = faults_of_form(units="imperial", stature="tall", waist_girth="thin", weight="light")
    assert "5 ft 6" in imperial["stature"].message
    assert "22 1/2" in imperial["waist_girth"].message
    assert "140" in imperial["weight"].message


@pytest.mark.parametrize(
    ("units", "field", "typed", "message"),
    [
        ("metric", "stature", "1.68", "That looks like metres. Did you mean 168 cm?"),
        ("metric", "stature", "66", "That looks like inches. Did you mean 167.6 cm?"),
        ("metric", "stature", "1680", "That looks like millimetres. Did you mean 168 cm?"),
        ("metric", "stature", "5.5", "That looks like feet. Did you mean 167.6 cm?"),
        ("metric", "waist_girth", "30", "That looks like inches. Did you mean 76.2 cm?"),
        ("metric", "weight", "11", "That looks like stones. Did you mean 69.9 kg?"),
        ("metric", "weight", "250", "That looks like pounds. Did you mean 113.4 kg?"),
        ("imperial", "stature", "168", "That looks like centimetres. Did you mean 66.1 in?"),
        ("imperial", "stature", "5.5", "That looks like feet. Did you mean 66 in?"),
        ("imperial", "weight", "60", "That looks like kilograms. Did you mean 132.3 lb?"),
    ],
)
def test_a_number_that_fits_another_unit_is_told(units, field, typed, message):
    stature = {"metric": "168", "imperial": "66"}[units]
    fault = faults_of_form(**{"units": units, "stature": stature, field: typed})[field]
    assert fault.code == "out_of_range"
    assert fault.message == message


def test_a_number_that_fits_no_unit_is_told_the_limits():
    message = faults_of_form(stature="100")["stature"].message
    assert message.startswith("We can work with 130 to 210 cm here.")


def test_typed_answers_keep_to_a_length_that_fits_the_cookie():
    typed = Typed.of(dict.fromkeys(MEASUREMENTS, "9" * 500))
    assert {len(answer) for answer in typed.answers.values()} == {TYPED_LENGTH}
    assert len(typed.answers) == len(MEASUREMENTS)


def test_answers_survive_the_session():
    fields = {"body": "neutral", "units": "imperial", "stature": "5'6", "hip_girth": "x"}
    again = {"hip_girth:2": "40", "hip_girth:3": "41", "kept": "hip_girth"}
    typed = Typed.of(fields | again | {"inseam_height": "30", "inseam_height:to": "trousers"})
    assert typed.texts("hip_girth") == ("x", "40", "41")
    assert typed.leg_to == "trousers"
    assert typed.kept == {"hip_girth"}
    assert Typed.of(typed.fields()) == typed


def test_strange_fields_are_left_out():
    assert Typed.of({"body": "child", "units": "ells", "shoe_size": "40"}) == Typed()


def test_a_change_of_units_keeps_what_is_no_number():
    typed = Typed.of({"stature": "168", "weight": "68", "hip_girth": "wide"}).in_units("imperial")
    assert typed.units == "imperial"
    assert typed.answers == {"stature": "5 ft 6.14 in", "weight": "149.9", "hip_girth": "wide"}


def man(**fields):
    return Typed.of({"body": "male", "stature": "180"} | fields)


def test_the_median_of_several_readings_counts():
    fields = {"waist_girth": "84", "waist_girth:2": "90", "waist_girth:3": "85"}
    wanted = man(**fields).read(LIMITS)
    assert wanted.asked["waist_girth"] == pytest.approx(0.85)
    assert man(waist_girth="84", **{"waist_girth:2": "86"}).read(LIMITS).asked[
        "waist_girth"
    ] == pytest.approx(0.85)
    assert set(wanted.noise) == {"stature", "waist_girth"}


def test_a_later_reading_is_refused_at_its_own_field():
    with pytest.raises(Refused) as refused:
        man(waist_girth="84", **{"waist_girth:2": "wide", "waist_girth:3": "8"}).read(LIMITS)
    assert [fault.field for fault in refused.value.faults] == ["waist_girth:2", "waist_girth:3"]


@pytest.mark.parametrize(
    ("to", "typed", "inseam"),
    [
        ("ankle", "76", 0.76),
        ("floor", "83", 0.83 - ANKLE_SHARE["male"] * 1.8),
        ("trousers", "32", 32 * 0.0254 + TROUSERS_SHORT_OF_FLOOR - ANKLE_SHARE["male"] * 1.8),
        ("trousers", "L32", 32 * 0.0254 + TROUSERS_SHORT_OF_FLOOR - ANKLE_SHARE["male"] * 1.8),
        ("trousers", "W34 L32", 32 * 0.0254 + TROUSERS_SHORT_OF_FLOOR - ANKLE_SHARE["male"] * 1.8),
        ("trousers", "34/32", 32 * 0.0254 + TROUSERS_SHORT_OF_FLOOR - ANKLE_SHARE["male"] * 1.8),
        ("trousers", "81", 0.81 + TROUSERS_SHORT_OF_FLOOR - ANKLE_SHARE["male"] * 1.8),
    ],
)
def test_an_inside_leg_is_converted_from_where_it_ends(to, typed, inseam):
    wanted = man(inseam_height=typed, **{"inseam_height:to": to}).read(LIMITS)
    assert wanted.asked["inseam_height"] == pytest.approx(inseam)
    assert wanted.noise == ({"inseam_height": HEM_NOISE} if to == "trousers" else {})


def test_a_measured_ankle_goes_before_the_usual_one():
    typed = man(inseam_height="83", foot_height="8", **{"inseam_height:to": "floor"})
    assert typed.read(LIMITS).asked["inseam_height"] == pytest.approx(0.75)


def test_an_inside_leg_must_say_where_it_ends():
    with pytest.raises(Refused) as refused:
        man(inseam_height="80").read(LIMITS)
    assert [fault.field for fault in refused.value.faults] == ["inseam_height:to"]


def test_a_number_of_trousers_stays_in_inches_whatever_the_units():
    typed = man(inseam_height="32", **{"inseam_height:to": "trousers"}).in_units("imperial")
    assert typed.answers["inseam_height"] == "32"
    assert typed.read(LIMITS).asked["inseam_height"] == pytest.approx(
        man(inseam_height="32", **{"inseam_height:to": "trousers"})
        .read(LIMITS)
        .asked["inseam_height"],
        abs=1e-4,
    )


def test_a_change_of_a_reading_is_no_longer_kept():
    typed = man(hip_girth="150", kept="hip_girth")
    assert typed.with_texts("hip_girth", ["150"]).kept == {"hip_girth"}
    assert typed.with_texts("hip_girth", ["105"]).kept == frozenset()
