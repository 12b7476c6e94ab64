"""The API: true to its own description, and every refusal a problem that says what to mend."""

import io
import json

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from openapi_spec_validator import OpenAPIV31SpecValidator
from PIL import Image

from model.anthropometry import TAKEN, ImpossibleBodyError
from model.measurements import BODY_KINDS, MEASUREMENTS
from model.studio import RenderingUnavailable
from webapp import avatars
from webapp.forms import FITS

WOMAN = {
    "body": "female",
    "units": "metric",
    "measurements": {
        "stature": 168,
        "bust_girth": 92,
        "waist_girth": 74,
        "hip_girth": 100,
        "thigh_girth": 58,
    },
}
MAN = {
    "body": "male",
    "measurements": {
        "stature": 180,
        "bust_girth": 104,
        "waist_girth": 90,
        "hip_girth": 102,
        "neck_girth": 39,
    },
}
POSTS = (
    "/api/v1/avatars",
    "/api/v1/avatars.glb",
    "/api/v1/avatars/front.png",
    "/api/v1/avatars/profile.png",
)


def faults(response):
    return {(fault["field"], fault["code"]) for fault in response.json["errors"]}


def test_the_description_is_valid_openapi(description):
    OpenAPIV31SpecValidator(description).validate()


def test_the_description_names_every_route(site, description):
    routes = {
        rule.rule
        for rule in site.url_map.iter_rules()
        if rule.rule.startswith("/api/") and "<" not in rule.rule
    }
    pictures = {"/api/v1/avatars/front.png", "/api/v1/avatars/profile.png"}
    assert set(description["paths"]) == routes | pictures | {"/healthz"}


def test_health(call):
    assert call("/healthz").json == {"status": "ok"}


def test_the_table_of_measurements(call):
    table = call("/api/v1/measurements").json
    assert [row["name"] for row in table] == list(MEASUREMENTS)
    stature = table[0]
    assert stature["unit"] == "cm"
    assert stature["label"] == "Height"
    assert set(stature["range"]) == set(stature["in_wizard"]) == set(BODY_KINDS)
    low, high = stature["range"]["female"]
    assert 100 < low < 150 < 190 < high < 260


def test_the_table_in_inches(call):
    low, high = call("/api/v1/measurements?units=imperial").json[0]["range"]["male"]
    assert 40 < low < high < 100
    refused = call("/api/v1/measurements?units=ells")
    assert refused.status_code == 422
    assert faults(refused) == {("units", "invalid_choice")}


@pytest.mark.parametrize("person", [WOMAN, MAN])
def test_a_body_is_measured(call, person):
    answer = call("/api/v1/avatars", person).json
    assert answer["body"] == person["body"]
    assert answer["units"] == "metric"
    assert answer["estimator"]["version"]
    rows = {row["name"]: row for row in answer["measurements"]}
    assert tuple(rows) == TAKEN
    for name, row in rows.items():
        assert row["asked"] == person["measurements"].get(name)
        assert row["low"] <= row["taken"] <= row["high"]
    assert rows["stature"]["taken"] == pytest.approx(person["measurements"]["stature"], abs=1)
    assert rows["weight"]["unit"] == "kg"
    assert rows["weight"]["path"] == []


def test_a_girths_path_is_where_the_tape_ran(call):
    rows = call("/api/v1/avatars", WOMAN).json["measurements"]
    for row in rows:
        if row["kind"] == "girth":
            path = np.array(row["path"])
            loop = np.linalg.norm(path - np.roll(path, 1, axis=0), axis=1).sum()
            assert 100 * loop == pytest.approx(row["taken"], abs=0.05), row["name"]


def test_inches_and_pounds_make_the_same_body(call):
    metric = call("/api/v1/avatars", WOMAN).json["measurements"]
    inches = {name: value / 2.54 for name, value in WOMAN["measurements"].items()}
    document = WOMAN | {"units": "imperial", "measurements": inches}
    imperial = call("/api/v1/avatars", document).json
    assert imperial["units"] == "imperial"
    for one, other in zip(metric, imperial["measurements"], strict=True):
        factor = {"in": 2.54, "lb": 0.45359237}[other["unit"]]
        assert other["taken"] * factor == pytest.approx(one["taken"], abs=0.01)
        assert other["path"] == one["path"]


@pytest.mark.parametrize("person", [WOMAN, MAN])
def test_the_body_has_what_was_entered(call, person):
    answer = call("/api/v1/avatars", person).json
    assert answer["warnings"] == []
    for row in answer["measurements"]:
        if row["asked"] is not None:
            assert row["taken"] == pytest.approx(row["asked"], abs=0.1), row["name"]
            assert row["low"] == row["high"] == row["taken"]
        else:
            assert row["low"] < row["taken"] < row["high"]


def test_the_tape_fit_is_the_default_and_the_linear_estimate_is_to_be_had(call):
    linear, tape = (call("/api/v1/avatars", WOMAN | {"fit": fit}).json for fit in FITS[::-1])
    assert tape == call("/api/v1/avatars", WOMAN).json
    misses = [
        abs(row["taken"] - row["asked"])
        for row in linear["measurements"]
        if row["asked"] is not None
    ]
    assert max(misses) > 0.2
    assert linear["warnings"] == []
    files = [call("/api/v1/avatars.glb", WOMAN | {"fit": fit}).data for fit in FITS]
    assert files[0] != files[1]


@pytest.mark.parametrize("body", BODY_KINDS)
def test_stature_alone_is_enough(call, body):
    document = {"body": body, "measurements": {"stature": 170}}
    assert call("/api/v1/avatars", document).status_code == 200


def test_the_file_has_the_stature_that_the_answer_states(call):
    rows = call("/api/v1/avatars", MAN).json["measurements"]
    response = call("/api/v1/avatars.glb", MAN)
    scene = trimesh.load_scene(io.BytesIO(response.data), file_type="glb")
    taken = next(row["taken"] for row in rows if row["name"] == "stature")
    assert 100 * scene.extents[1] == pytest.approx(taken, abs=0.01)


def test_the_file_names_its_estimator_and_measurements(call):
    version = call("/api/v1/avatars", MAN).json["estimator"]["version"]
    content = call("/api/v1/avatars.glb", MAN).data
    length = int.from_bytes(content[12:16], "little")
    extras = json.loads(content[20 : 20 + length])["asset"]["extras"]
    assert extras["estimator"]["version"] == version
    assert set(extras["measurements"]) == set(TAKEN)
    assert extras["measurements"]["stature"]["asked"] == 1.8
    assert extras["measurements"]["weight"]["asked"] is None


@pytest.mark.parametrize("side", ["front", "profile"])
def test_pictures(call, side):
    with Image.open(io.BytesIO(call(f"/api/v1/avatars/{side}.png", WOMAN).data)) as picture:
        assert picture.size == (600, 1200)


def test_a_silhouette_is_white_on_black_and_turns(call):
    def outline(**drawing):
        document = WOMAN | {"silhouette": True} | drawing
        content = call("/api/v1/avatars/profile.png", document).data
        return np.asarray(Image.open(io.BytesIO(content)).convert("L"))

    right, left = outline(), outline(facing="left", camera={"distance": 3.0, "height": 0.9})
    assert right[0, 0] == 0
    assert right.max() == 255
    assert np.abs(right.astype(int) - left[:, ::-1]).mean() < 2


@pytest.mark.parametrize("path", POSTS)
def test_values_that_cannot_be_are_refused(call, path):
    document = {"body": "female", "measurements": {"stature": 168, "waist_girth": 7, "x": 1}}
    response = call(path, document)
    assert response.status_code == 422
    assert response.json["title"] == "Unprocessable Entity"
    assert response.json["status"] == 422
    assert faults(response) == {
        ("measurements.waist_girth", "out_of_range"),
        ("measurements.x", "unknown_measurement"),
    }


@pytest.mark.parametrize("value", ["NaN", "Infinity", "-Infinity", "1e999", "9" * 5000, "true"])
def test_what_is_no_finite_number_is_refused(call, value):
    content = f'{{"body": "female", "measurements": {{"stature": {value}}}}}'
    response = call("/api/v1/avatars", data=content, content_type="application/json")
    assert response.status_code == 422
    assert faults(response) == {("measurements.stature", "not_a_number")}


@pytest.mark.parametrize("path", POSTS)
@pytest.mark.parametrize("content", [b"", b"{", b"stature=168", b"\xff\xfe", b"[" * 60_000])
def test_what_is_not_json_is_refused(call, path, content):
    response = call(path, data=content, content_type="application/json")
    assert response.status_code == 400


@pytest.mark.parametrize("path", POSTS)
@pytest.mark.parametrize("content_type", [None, "text/plain", "multipart/form-data"])
def test_another_content_type_is_refused(call, path, content_type):
    content = json.dumps(WOMAN)
    assert call(path, data=content, content_type=content_type).status_code == 415


@pytest.mark.parametrize("path", POSTS)
def test_too_large_a_body_is_refused(call, path):
    content = b" " * (64 * 1024 + 1)
    response = call(path, data=content, content_type="application/json")
    assert response.status_code == 413


def test_too_large_a_body_is_refused_when_it_comes_in_chunks(client):
    content = json.dumps(WOMAN).encode() + b" " * 100_000
    response = client.post(
        "/api/v1/avatars",
        input_stream=io.BytesIO(content),
        content_type="application/json",
        environ_overrides={"wsgi.input_terminated": True},
    )
    assert response.status_code == 413


@pytest.mark.parametrize(
    ("method", "path", "status"),
    [
        ("get", "/api/v1/avatars", 405),
        ("delete", "/api/v1/avatars.glb", 405),
        ("post", "/api/v1/measurements", 405),
        ("get", "/api/v1/nothing", 404),
        ("post", "/api/v1/avatars/back.png", 404),
        ("get", "/api/", 404),
    ],
)
def test_wrong_addresses_and_methods_are_problems_too(client, method, path, status):
    response = getattr(client, method)(path)
    assert response.status_code == response.json["status"] == status
    assert response.mimetype == "application/problem+json"
    assert response.json["errors"] == []
    assert ("Allow" in response.headers) == (status == 405)


def test_too_many_requests_are_refused_with_when_to_come_again(make_site):
    limited = make_site(RATELIMIT_ENABLED=True, RATELIMIT_DEFAULT="1 per minute").test_client()
    assert limited.get("/api/v1/measurements").status_code == 200
    response = limited.get("/api/v1/measurements")
    assert response.status_code == 429
    assert response.mimetype == "application/problem+json"
    assert 0 < int(response.headers["Retry-After"]) <= 61
    assert limited.get("/healthz").status_code == limited.get("/healthz").status_code == 200


def test_a_server_that_cannot_draw_says_so(call, monkeypatch):
    def unavailable(*args, **kwargs):
        raise RenderingUnavailable("no OSMesa")

    monkeypatch.setattr(avatars, "render_png", unavailable)
    response = call("/api/v1/avatars/front.png", WOMAN)
    assert response.status_code == 503
    assert "no OSMesa" in response.json["detail"]
    assert call("/api/v1/avatars", WOMAN).status_code == 200


@pytest.mark.parametrize("path", POSTS)
def test_values_that_no_body_has_together_are_refused(call, monkeypatch, caplog, path):
    def impossible(body):
        raise ImpossibleBodyError("the body has no weight")

    monkeypatch.setattr(avatars, "measure", impossible)
    response = call(path, WOMAN)
    assert response.status_code == 422
    assert faults(response) == {("measurements", "contradictory")}
    assert caplog.text == ""


numbers = st.floats(0, 250) | st.floats()
json_values = st.recursive(
    st.none() | st.booleans() | numbers | st.integers() | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=6,
)
documents = st.fixed_dictionaries(
    {"measurements": st.dictionaries(st.sampled_from(TAKEN), numbers | json_values)},
    optional={
        "body": st.sampled_from(BODY_KINDS) | json_values,
        "units": st.sampled_from(["metric", "imperial"]) | json_values,
        "fit": st.sampled_from(["tape", "linear"]) | json_values,
    },
)


@given(document=documents | json_values)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_any_json_is_answered_as_described(call, document):
    content = json.dumps(document)
    response = call("/api/v1/avatars", data=content, content_type="application/json")
    assert response.status_code in (200, 422)


# One fit of what no body has together takes seconds; in inches only the reading differs.
@pytest.mark.parametrize(("units", "fit"), [("metric", "tape"), ("imperial", "linear")])
@pytest.mark.parametrize("body", BODY_KINDS)
def test_the_ends_of_every_range_are_accepted(call, body, units, fit):
    table = call(f"/api/v1/measurements?units={units}").json
    ranges = {row["name"]: row["range"][body] for row in table}
    for end in (0, 1):
        values = {name: limits[end] for name, limits in ranges.items()}
        document = {"body": body, "units": units, "fit": fit, "measurements": values}
        assert call("/api/v1/avatars", document).status_code == 200


# The ends often: contradictions are worst in the corners.
shares = st.sampled_from([0.0, 1.0]) | st.floats(0, 1)


@given(
    person=st.fixed_dictionaries(
        {},
        optional={name: shares for name in TAKEN if name != "stature"},
    ),
    stature=shares,
    body=st.sampled_from(BODY_KINDS),
)
# A small, light man with a large belly, thin thighs and long legs: less than nothing remains.
@example(
    person={
        "weight": 0.0,
        "bust_girth": 0.0,
        "hip_girth": 0.0,
        "neck_girth": 1.0,
        "thigh_girth": 0.0,
        "abdomen_girth": 1.0,
        "mid_thigh_girth": 0.0,
        "inseam_height": 1.0,
        "foot_height": 1.0,
    },
    stature=0.0,
    body="male",
)
@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=15
)
def test_any_values_within_the_ranges_make_a_body_or_contradict_each_other(
    call, site, person, stature, body
):
    ranges = {
        row["name"]: row["range"][body]
        for row in site.test_client().get("/api/v1/measurements").json
    }
    values = {
        name: np.interp(share, (0, 1), ranges[name])
        for name, share in ({"stature": stature} | person).items()
    }
    response = call("/api/v1/avatars", {"body": body, "measurements": values})
    if response.status_code != 200:
        assert faults(response) == {("measurements", "contradictory")}
