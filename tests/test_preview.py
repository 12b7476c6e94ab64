"""The wizard's view in 3D: the body that would be, and nothing of it kept."""

import json

import pytest


@pytest.fixture
def woman(client):
    client.send("/", body="female", units="metric")
    client.send("/measure/stature", units="metric", stature="168")
    return client


def extras(response):
    length = int.from_bytes(response.data[12:16], "little")
    return json.loads(response.data[20 : 20 + length])["asset"]["extras"]


def test_the_body_and_the_tape_are_those_of_what_is_being_typed(woman):
    fields = {"units": "metric", "waist_girth": "84"}
    body = woman.send("/preview/waist_girth.glb", **fields)
    assert body.mimetype == "model/gltf-binary"
    asked = extras(body)["measurements"]
    assert asked["waist_girth"]["asked"] == pytest.approx(0.84)
    assert asked["stature"]["asked"] == pytest.approx(1.68)
    row = woman.send("/preview/waist_girth.json", **fields).json
    assert row["taken"] == pytest.approx(84, abs=0.1)
    assert len(row["path"]) > 10
    with woman.session_transaction() as session:
        assert "waist_girth" not in session["typed"]


def test_what_cannot_be_is_left_aside(woman):
    row = woman.send("/preview/waist_girth.json", units="metric", waist_girth="wide").json
    assert row["asked"] is None


def test_there_is_no_body_without_a_height_or_for_no_measurement(client, woman):
    assert woman.send("/preview/shoe_size.json").status_code == 404
    woman.send("/forget")
    assert woman.send("/preview/waist_girth.json", waist_girth="84").status_code == 404


def test_it_needs_the_token(woman):
    assert woman.post("/preview/waist_girth.json", data={"waist_girth": "84"}).status_code == 400


def test_the_tape_has_its_name_in_the_pages_language(woman):
    woman.send("/language", language="pt")
    assert woman.send("/preview/waist_girth.json", units="metric").json["label"] == "Cintura"
