"""The page on which outlines are compared."""

import io
import re

import numpy as np
import pytest
from conftest import text
from test_comparisons import faults, outline, picture, pixels, skirted

TYPED = {"body": "male", "units": "metric", "stature": "178", "weight": "80"}


@pytest.fixture
def shopper(client):
    """A client whose form is filled in."""
    client.send(**TYPED)
    return client


JSON = {"Accept": "application/json"}


def files(**pictures):
    """Pictures as a form sends them."""
    return {name: (io.BytesIO(one), f"{name}.png") for name, one in pictures.items()}


def answered(shopper, front, **fields):
    """What the page's script is answered."""
    data = {"csrf_token": shopper.token()} | files(front=front) | fields
    return shopper.post("/compare", data=data, headers=JSON)


def test_the_page_needs_measurements(client):
    assert client.get("/compare").location == "/"


def test_the_pages_script_gets_all_that_it_shows(shopper):
    person = {"body": "male", "measurements": {"stature": 178, "weight": 80}}
    front = outline(shopper, "front", person)
    response = answered(shopper, front=front)
    assert response.status_code == 200
    view = response.json["front"]
    assert view["iou"] > 0.985
    sizes = {picture(view[f"{name}_png"]).size for name in ("overlay", "difference", "photo")}
    assert sizes == {(view["width"], view["height"])} == {picture(view["avatar_png"]).size}
    assert {reason["code"] for reason in response.json["reasons"]} >= {"clothes", "hair", "breath"}
    # The avatar lies where the outline does, and both lie where the photo says.
    drawn = np.asarray(picture(view["avatar_png"]).convert("RGB")).std(axis=2) > 4
    inside = np.asarray(picture(view["photo_png"]).convert("RGBA"))[:, :, 3] > 0
    assert (drawn & inside).sum() > 0.97 * (drawn | inside).sum()
    place = view["place"]
    rows = np.flatnonzero(inside.any(axis=1))
    found = np.flatnonzero(pixels(front).max(axis=1) > 127)
    assert place["top"] + place["scale"] * rows[0] == pytest.approx(found[0], abs=2)
    assert place["top"] + place["scale"] * rows[-1] == pytest.approx(found[-1], abs=2)


def test_without_a_script_the_page_shows_the_comparison(shopper):
    front = outline(shopper, "front", {"body": "male", "measurements": {"stature": 178}})
    assert shopper.send("/compare", **files(front=front)).status_code == 200
    assert "Waist" in text(shopper.page.find(".//table"))
    assert shopper.send("/compare", **files(front=b"no")).status_code == 415
    assert "PNG or JPEG" in text(shopper.page.find(".//main"))


def test_the_page_says_what_was_taken_for_clothes(shopper):
    person = {"body": "male", "measurements": {"stature": 178, "weight": 80}}
    plain = {side: outline(shopper, side, person) for side in ("front", "profile")}
    skirts = {side: skirted(content, 0.03) for side, content in plain.items()}
    said = {
        "": "say so and refine again",
        "tight": "may still count as body",
        "loose_legs": "clothes are loose",
    }
    for pictures, worn in ((plain, ""), (skirts, ""), (skirts, "tight"), (skirts, "loose_legs")):
        shopper.send("/compare", refine="1", worn=worn, **files(**pictures))
        assert "before and after" in text(shopper.page.find(".//main"))
        chosen = shopper.page.find(".//input[@name='worn'][@checked]")
        assert chosen.get("value") == worn
        notice = shopper.page.find(".//p[@class='notice clothes']")
        limited = shopper.page.find(".//p[@class='limited']")
        assert (notice is None) == (pictures is plain)
        assert (limited is None) == (pictures is plain or worn == "tight")
        if notice is not None:
            assert said[worn] in text(notice)
            assert re.search(r"Hips [23]\.\d cm", text(notice))
            assert "Calf" not in text(notice)


def test_the_camera_is_told_in_the_shoppers_units(shopper):
    camera = {"distance": 2, "height": 1.5}
    person = {"body": "male", "measurements": {"stature": 178, "weight": 80}}
    front = outline(shopper, "front", person, camera=camera)
    right, wrong = (
        answered(shopper, front=front, camera_distance=distance, camera_height="150").json
        for distance in ("2 m", "3 m")
    )
    assert right["front"]["iou"] > wrong["front"]["iou"]
    assert right["front"]["camera"] == {"distance": 2.0, "height": 1.5, "estimated": []}
    refused = answered(shopper, front=front, camera_distance="99", camera_height="high")
    assert faults(refused) == {
        ("camera_distance", "out_of_range"),
        ("camera_height", "not_a_number"),
    }


def test_the_page_shows_before_and_after(shopper):
    person = {"body": "male", "measurements": {"stature": 178, "weight": 80, "waist_girth": 94}}
    answer = answered(shopper, front=outline(shopper, "front", person), refine="1").json
    assert answer["refinement"]["front"]["iou"] > answer["front"]["iou"]
    picture(answer["refinement"]["front"]["avatar_png"])
    labels = {row["name"]: row["label"] for row in answer["refinement"]["measurements"]}
    assert labels["stature"] == "Height"


def test_the_refined_body_is_taken_along_until_a_value_changes(shopper):
    person = {"body": "male", "measurements": {"stature": 178, "weight": 80, "waist_girth": 94}}

    def taken():
        numbers = shopper.get("/avatar.json").json["measurements"]
        return {row["name"]: row["taken"] for row in numbers}

    def waist():
        return taken()["waist_girth"]

    alone = waist()
    changes = answered(shopper, front=outline(shopper, "front", person), refine="1").json
    changes = changes["refinement"]
    assert waist() == alone, "nothing is kept unless it is asked for"
    after = next(row["after"] for row in changes["measurements"] if row["name"] == "waist_girth")
    assert abs(after - alone) > 0.5
    forged = changes["take"][:-2] + "xx"
    assert shopper.send("/compare/body", refined=forged).status_code == 400
    assert shopper.send("/compare/body", refined=changes["take"]).location == "/avatar"
    # The tape fit, which ends within a tenth of a millimetre, is done once more.
    assert waist() == pytest.approx(after, abs=0.02)
    for name in ("stature", "weight"):
        assert taken()[name] == pytest.approx(float(TYPED[name]), abs=0.1), name
    shopper.get("/avatar")
    assert "The outline of your photo has a say" in text(shopper.page.find(".//main"))
    assert b"by the outline of a photo" in shopper.get("/avatar.glb").data
    again = answered(shopper, front=outline(shopper, "front", person), refine="1").json
    # The same outline has said all that it has to say: told from the body that is shown before.
    assert again["refinement"]["moved_cm"]["mean"] < 0.2 * changes["moved_cm"]["mean"]
    shopper.send("/compare/body", leave="1")
    assert waist() == alone
    shopper.send("/compare/body", refined=changes["take"])
    shopper.send(**TYPED | {"weight": "81"})
    shopper.get("/avatar")
    assert "The outline of your photo" not in text(shopper.page.find(".//main"))
    shopper.send(**TYPED)
    assert waist() == alone


def test_a_page_without_its_token_is_not_answered(site):
    guarded = site.test_client()
    guarded.send(**TYPED)
    assert guarded.post("/compare", data={}).status_code == 400
