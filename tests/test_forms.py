"""Requests: what they may ask, and every refusal."""

import math

import pytest
from conftest import LIMITS
from hypothesis import given
from hypothesis import strategies as st

from model.cameras import Camera
from model.measurements import BODY_KINDS, MEASUREMENTS
from webapp.forms import (
    BODY_MEMBERS,
    FILE_MEMBERS,
    PICTURE_MEMBERS,
    Refused,
    read_document,
)

WOMAN = {"body": "female", "measurements": {"stature": 168, "waist_girth": 74}}


def faults_of(document, members=PICTURE_MEMBERS):
    with pytest.raises(Refused) as refused:
        read_document(document, members, LIMITS)
    return {(fault.field, fault.code) for fault in refused.value.faults}


def test_a_document_in_centimetres_is_read_as_si():
    wanted = read_document(WOMAN, BODY_MEMBERS, LIMITS)
    assert wanted.body == "female"
    assert wanted.units == "metric"
    assert dict(wanted.asked) == {"stature": 1.68, "waist_girth": 0.74}


def test_a_document_in_inches_and_pounds_is_read_as_si():
    document = {
        "body": "neutral",
        "units": "imperial",
        "measurements": {"weight": 150, "stature": 66},
    }
    wanted = read_document(document, BODY_MEMBERS, LIMITS)
    assert wanted.asked["stature"] == pytest.approx(1.6764)
    assert wanted.asked["weight"] == pytest.approx(68.0388555)


def test_a_document_may_place_the_camera():
    drawing = {"silhouette": True, "camera": {"distance": 2.5}, "facing": "left"}
    wanted = read_document(WOMAN | drawing, PICTURE_MEMBERS, LIMITS)
    assert wanted.silhouette
    assert wanted.camera == Camera(distance=2.5)
    assert wanted.facing == "left"


@pytest.mark.parametrize("document", [None, [], 1.0, "stature", True])
def test_a_document_that_is_no_object_is_refused(document):
    assert faults_of(document) == {("", "not_an_object")}


def measured(**measurements):
    return WOMAN | {"measurements": WOMAN["measurements"] | measurements}


@pytest.mark.parametrize(
    ("document", "field", "code"),
    [
        ({"measurements": {"stature": 168}}, "body", "required"),
        (WOMAN | {"body": "child"}, "body", "invalid_choice"),
        (WOMAN | {"body": None}, "body", "invalid_choice"),
        (WOMAN | {"body": ["female"]}, "body", "invalid_choice"),
        (WOMAN | {"units": "cm"}, "units", "invalid_choice"),
        (WOMAN | {"units": None}, "units", "invalid_choice"),
        (WOMAN | {"fit": "loose"}, "fit", "invalid_choice"),
        (WOMAN | {"facing": "up"}, "facing", "invalid_choice"),
        (WOMAN | {"silhouette": 1}, "silhouette", "invalid_choice"),
        (WOMAN | {"colour": "red"}, "colour", "unknown_member"),
        ({"body": "female"}, "measurements", "required"),
        (WOMAN | {"measurements": [168]}, "measurements", "not_an_object"),
        (WOMAN | {"measurements": {}}, "measurements.stature", "required"),
        (measured(shoe_size=40), "measurements.shoe_size", "unknown_measurement"),
        (measured(waist_girth="74"), "measurements.waist_girth", "not_a_number"),
        (measured(waist_girth=None), "measurements.waist_girth", "not_a_number"),
        (measured(waist_girth=True), "measurements.waist_girth", "not_a_number"),
        (measured(waist_girth=[74]), "measurements.waist_girth", "not_a_number"),
        (measured(waist_girth=math.nan), "measurements.waist_girth", "not_a_number"),
        (measured(waist_girth=math.inf), "measurements.waist_girth", "not_a_number"),
        (measured(waist_girth=10**400), "measurements.waist_girth", "not_a_number"),
        (measured(waist_girth=1e300), "measurements.waist_girth", "out_of_range"),
        (measured(waist_girth=0), "measurements.waist_girth", "out_of_range"),
        (measured(waist_girth=-74), "measurements.waist_girth", "out_of_range"),
        (measured(stature=1.68), "measurements.stature", "out_of_range"),
        (WOMAN | {"camera": None}, "camera", "not_an_object"),
        (WOMAN | {"camera": 3}, "camera", "not_an_object"),
        (WOMAN | {"camera": {"zoom": 2}}, "camera.zoom", "unknown_member"),
        (WOMAN | {"camera": {"distance": "3"}}, "camera.distance", "not_a_number"),
        (WOMAN | {"camera": {"distance": 0}}, "camera.distance", "out_of_range"),
        (WOMAN | {"camera": {"height": -1}}, "camera.height", "out_of_range"),
        (WOMAN | {"camera": {"height": math.nan}}, "camera.height", "not_a_number"),
    ],
)
def test_a_value_that_cannot_be_is_refused_at_its_field(document, field, code):
    assert faults_of(document) == {(field, code)}


def test_morph_targets_are_for_files():
    for wanted in (False, True):
        document = WOMAN | {"morph_targets": wanted}
        assert read_document(document, FILE_MEMBERS, LIMITS).morph_targets is wanted
    assert not read_document(WOMAN, FILE_MEMBERS, LIMITS).morph_targets
    assert faults_of(WOMAN | {"morph_targets": True}) == {("morph_targets", "unknown_member")}


def test_members_of_a_picture_are_unknown_to_the_others():
    assert faults_of(WOMAN | {"camera": {}}, BODY_MEMBERS) == {("camera", "unknown_member")}


def test_all_faults_are_told_at_once():
    document = {"units": "cm", "colour": "red", "measurements": {"waist_girth": "74"}}
    assert {field for field, _ in faults_of(document)} == {
        "body",
        "units",
        "colour",
        "measurements.stature",
        "measurements.waist_girth",
    }


json_values = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=8,
)
documents = st.fixed_dictionaries(
    {},
    optional={
        "body": st.sampled_from(BODY_KINDS) | json_values,
        "units": st.sampled_from(["metric", "imperial"]) | json_values,
        "fit": json_values,
        "silhouette": json_values,
        "facing": json_values,
        "camera": st.dictionaries(st.sampled_from(["distance", "height", "x"]), json_values),
        "measurements": st.dictionaries(
            st.sampled_from([*MEASUREMENTS, "x"]), st.floats(0, 250) | json_values
        ),
        "x": json_values,
    },
)


@given(documents | json_values)
def test_any_document_is_read_or_refused(document):
    try:
        wanted = read_document(document, PICTURE_MEMBERS, LIMITS)
    except Refused:
        return
    assert "stature" in wanted.asked
