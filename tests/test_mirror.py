"""The numbers that the avatar's page asks for, and the values that it changes."""

import pytest
from conftest import SHOWN_LABELS, WOMAN, text

from model.anthropometry import ImpossibleBodyError
from model.measurements import MEASUREMENTS
from webapp import avatars

ENTERED = {name: float(value) for name, value in WOMAN.items() if name not in ("body", "units")}


def send(client, **options):
    """Ask for a change as the page does, with its token."""
    return client.post("/avatar.json", headers={"X-CSRFToken": client.token()}, **options)


def change(client, **answers):
    return send(client, json=answers)


def asked(client):
    """What was entered, as the numbers tell it."""
    rows = client.get("/avatar.json").json["measurements"]
    return {row["name"]: row["asked"] for row in rows if row["asked"] is not None}


def test_the_numbers_are_those_of_the_api(shopper):
    answer = shopper.get("/avatar.json")
    document = {"body": "female", "measurements": ENTERED}
    expected = shopper.post("/api/v1/avatars", json=document).json
    for row in expected["measurements"]:
        row["label"] = SHOWN_LABELS.get(row["name"], row["label"])
    assert answer.json == expected
    assert answer.headers["Cache-Control"] == "no-store"


def test_the_numbers_speak_the_shoppers_units(client):
    client.send(body="male", units="imperial", stature="5'11")
    stature = client.get("/avatar.json").json["measurements"][0]
    assert (stature["asked"], stature["unit"]) == (71, "in")


def test_without_measurements_there_are_no_numbers(client):
    assert client.get("/avatar.json").status_code == 404
    assert change(client, waist_girth="80").status_code == 404


def test_another_value_makes_another_body_and_is_kept_as_it_was_typed(shopper):
    answer = change(shopper, waist_girth="80,5")
    rows = {row["name"]: row for row in answer.json["measurements"]}
    assert len(rows) == len(MEASUREMENTS)
    assert rows["waist_girth"]["asked"] == 80.5
    assert rows["waist_girth"]["taken"] == pytest.approx(80.5, abs=0.1)
    assert asked(shopper) == ENTERED | {"waist_girth": 80.5}
    shopper.get("/numbers")
    assert shopper.page.find(".//input[@name='waist_girth']").get("value") == "80,5"


def test_feet_and_inches_are_taken_as_the_wizard_takes_them(client):
    client.send(body="male", units="imperial", stature="5'11", weight="170")
    client.get("/avatar")
    field = client.page.find(".//input[@id='edit-stature']")
    assert field.get("value") == "5 ft 11 in"
    assert (field.get("data-feet"), field.get("aria-valuenow")) == ("1", "71")
    change(client, stature="6 ft 1/2")
    assert asked(client)["stature"] == 72.5
    client.get("/numbers")
    assert client.page.find(".//input[@name='stature']").get("value") == "6 ft 1/2"


def test_what_seems_unusual_is_asked_in_the_words_of_the_wizard(shopper):
    answer = change(shopper, neck_girth="45")
    (said,) = [it for it in answer.json["warnings"] if it["measurement"] == "neck_girth"]
    assert said["message"].startswith("Beside your other numbers this one seems unusual")


def test_an_inside_leg_is_judged_as_the_page_shows_it(client):
    client.send(**WOMAN, inseam_height="95", **{"inseam_height:to": "floor"})
    client.get("/measure/inseam_height")
    answer = client.get("/avatar.json").json
    (said,) = [it for it in answer["warnings"] if it["measurement"] == "inseam_height"]
    (row,) = [row for row in answer["measurements"] if row["name"] == "inseam_height"]
    assert row["label"] == "Inside leg to the ankle" and row["asked"] < 92
    assert "95" not in said["message"]


def test_an_inside_leg_that_is_changed_here_ends_at_the_ankle(client):
    client.send(**WOMAN, inseam_height="78", **{"inseam_height:to": "floor"})
    assert asked(client)["inseam_height"] < 75
    change(client, inseam_height="70")
    assert asked(client)["inseam_height"] == 70


@pytest.mark.parametrize(
    ("answers", "code"),
    [
        ({"waist_girth": "400"}, "out_of_range"),
        ({"waist_girth": "wide"}, "not_a_number"),
        ({"stature": ""}, "required"),
        ({"body": "male"}, "unknown_member"),
        ({"waist_girth": 80}, "unknown_member"),
        (["waist_girth"], "not_an_object"),
    ],
)
def test_values_that_cannot_be_are_told_and_not_kept(shopper, answers, code):
    answer = send(shopper, json=answers)
    assert answer.status_code == 422
    assert [fault["code"] for fault in answer.json["errors"]] == [code]
    assert asked(shopper)["waist_girth"] == 74


def impossible(body):
    raise ImpossibleBodyError("the body has no weight")


def test_values_that_no_body_has_together_are_not_kept(shopper, monkeypatch):
    with monkeypatch.context() as contradictory:
        contradictory.setattr(avatars, "measure", impossible)
        assert change(shopper, waist_girth="60").json["errors"][0]["code"] == "contradictory"
        assert shopper.get("/avatar.json").status_code == 404
    assert asked(shopper)["waist_girth"] == 74


@pytest.mark.parametrize(
    ("content", "kind", "status"),
    [
        ("{", "application/json", 400),
        ("{}", "text/plain", 415),
        ("[" * 9999, "application/json", 400),
    ],
)
def test_what_is_no_json_is_refused(shopper, content, kind, status):
    assert send(shopper, data=content, content_type=kind).status_code == status


def test_a_change_needs_the_pages_token(shopper):
    assert shopper.post("/avatar.json", json={"waist_girth": "80"}).status_code == 400
    assert asked(shopper)["waist_girth"] == 74


def test_the_page_has_a_field_for_each_entered_value(shopper):
    shopper.get("/avatar")
    form = shopper.page.find(".//form[@id='editor']")
    inputs = {
        field.get("name"): field
        for field in form.iter("input")
        if field.get("role") == "spinbutton"
    }
    assert set(inputs) == set(ENTERED)
    assert inputs["waist_girth"].get("value") == "74"
    assert float(inputs["waist_girth"].get("data-low")) < 74
    assert float(inputs["waist_girth"].get("data-high")) > 74
    # Without scripts it stays hidden, and the way back leads to the form.
    assert "hidden" in form.attrib
    assert any(text(link) == "Edit measurements" for link in shopper.page.iter("a"))


def test_of_numbers_that_no_body_has_together_the_page_names_the_furthest_three(client):
    numbers = {"stature": 168, "weight": 62.5, "bust_girth": 92, "waist_girth": 95}
    numbers |= {"abdomen_girth": 82, "hip_girth": 99, "thigh_girth": 58, "mid_thigh_girth": 47}
    with client.session_transaction() as session:
        typed = {name: str(value) for name, value in numbers.items()}
        session["typed"] = {"body": "female", "units": "metric"} | typed
    rows = client.get("/avatar.json").json["measurements"]
    apart = {row["label"]: abs(row["asked"] / row["taken"] - 1) for row in rows if row["asked"]}
    client.get("/avatar")
    furthest = sorted(apart, key=apart.get, reverse=True)[:3]
    verdict = text(client.page.find(".//span[@id='verdict']"))
    assert verdict.endswith(f"does not seem to go together: {', '.join(furthest)}.")
