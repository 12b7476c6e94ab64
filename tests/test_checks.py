"""What the wizard says about numbers: kindly, with a proposal, and never as a wall."""

import pytest
from conftest import text

from model.measurements import MEASUREMENTS
from webapp.answers import Typed

ENTERED = {"stature": "168", "weight": "62", "bust_girth": "92"}


@pytest.fixture
def woman(client):
    client.send("/", body="female", units="metric")
    for name, value in ENTERED.items():
        answer(client, name, **{name: value})
    return client


def answer(client, name, **fields):
    return client.send(f"/measure/{name}", units="metric", **fields)


def said(client):
    return text(client.page.find(".//div[@id='check']"))


def proposal(client, name):
    (button,) = client.page.findall(f".//div[@id='check']//button[@name='{name}']")
    return button.get("value")


def kept(client):
    with client.session_transaction() as session:
        return Typed.of(session["typed"])


def test_a_number_in_another_unit_beyond_the_limits_is_accepted_by_one_press(woman):
    assert answer(woman, "waist_girth", waist_girth="29").status_code == 422
    use = proposal(woman, "use")
    assert use == "73.7"
    response = answer(woman, "waist_girth", waist_girth="29", use=use)
    assert response.location == "/measure/abdomen_girth"
    assert kept(woman).answers["waist_girth"] == "73.7"


def test_an_unusual_number_is_asked_about_once_and_may_be_kept(woman):
    response = answer(woman, "neck_girth", neck_girth="45")
    assert response.location == "/measure/neck_girth#check"
    woman.get(response.location)
    assert "seems unusual" in said(woman)
    assert woman.page.find(".//input[@name='seen']").get("value") == "45"
    assert answer(woman, "neck_girth", neck_girth="45", seen="45").location == "/measure"
    assert "neck_girth" in kept(woman).kept
    woman.get("/measure/neck_girth")
    assert "unusual" not in said(woman)
    woman.get("/review")
    assert "You looked at it again and kept it." in text(woman.page)


def test_a_number_that_is_changed_is_asked_about_anew(woman):
    answer(woman, "neck_girth", neck_girth="45", keep="1")
    response = answer(woman, "neck_girth", neck_girth="46", seen="45")
    assert response.location == "/measure/neck_girth#check"


def test_a_number_that_is_another_measurement_is_moved_by_one_press(woman):
    answer(woman, "waist_girth", waist_girth="99")
    woman.get("/measure/waist_girth")
    place = proposal(woman, "move")
    assert place == "hip_girth"
    answer(woman, "waist_girth", waist_girth="99", move=place)
    assert "waist_girth" not in kept(woman).answers
    assert kept(woman).answers["hip_girth"] == "99"


def test_an_inside_leg_to_the_floor_that_is_told_to_the_ankle_is_seen(woman):
    to = {"inseam_height:to": "ankle"}
    response = answer(woman, "inseam_height", inseam_height="83", **to)
    woman.get(response.location)
    assert proposal(woman, "leg") == "floor"
    answer(woman, "inseam_height", inseam_height="83", leg="floor", **to)
    assert kept(woman).leg_to == "floor"


def test_what_cannot_be_is_not_kept_by_any_button(woman):
    for button in ({"keep": "1"}, {"seen": "900"}, {"use": "900"}, {"move": "hip_girth"}):
        answer(woman, "waist_girth", waist_girth="900", **button)
        assert kept(woman).kept == frozenset(), button
        assert woman.get("/avatar").location == "/review", button
        woman.get("/review")


def test_numbers_are_checked_as_they_are_typed_and_nothing_is_kept(woman):
    def check(**fields):
        response = woman.send("/check/waist_girth", units="metric", **fields)
        assert response.status_code == 200
        return response.json

    assert "Fits the others" in check(waist_girth="74")["said"]
    assert "seems unusual" in check(waist_girth="97")["said"]
    wrong = check(waist_girth="29")
    assert wrong["faults"] == ["That looks like inches. Did you mean 73.7 cm?"]
    assert 'value="73.7"' in wrong["said"]
    assert check(waist_girth="") == {"faults": [], "said": check()["said"]}
    assert "waist_girth" not in kept(woman).answers
    assert woman.post("/check/waist_girth", data={"waist_girth": "74"}).status_code == 400
    assert woman.send("/check/shoe_size").status_code == 404


def test_leaving_out_has_a_price_that_is_told(woman):
    woman.get("/measure/hip_girth")
    price = text(woman.page.find(".//p[@id='price']"))
    assert "cm, give or take" in price
    woman.get("/measure/stature")
    assert woman.page.find(".//p[@id='price']") is None


def test_the_review_says_which_single_measurement_would_help_most(woman):
    woman.get("/review")
    said = [text(element) for element in woman.page.iter("a") if element.get("class") == "best"]
    assert " would help most: the rest known to " in said[0]
    assert any(row.label in said[0] for row in MEASUREMENTS.values())


def test_a_persons_own_repeatability_narrows_and_widens_the_ranges(woman):
    def width(second):
        fields = {"waist_girth": "74", "waist_girth:2": second, "enough": "1"}
        answer(woman, "waist_girth", **fields)
        woman.get("/avatar")
        (row,) = [r for r in woman.page.iter("tr") if r.get("data-measurement") == "abdomen_girth"]
        low, high = text(row.findall("td")[-1]).split(" to ")
        return float(high) - float(low)

    assert width("74") < width("84")
