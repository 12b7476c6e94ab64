"""The form of all numbers: nothing typed is lost, and every fault is told at its field."""

import pytest
from conftest import text
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from model.measurements import MEASUREMENTS
from webapp.guide import QUICK

WOMAN = {"body": "female", "units": "metric", "stature": "168", "waist_girth": "74,5"}


def values(page):
    """What stands in the form's fields."""
    return {
        field.get("name"): field.get("value")
        for field in page.iter("input")
        if field.get("name") in QUICK and field.get("value")
    }


def faults(page):
    """The messages at the fields."""
    return {
        element.get("id").removesuffix("-fault"): text(element)
        for element in page.iter("p")
        if element.get("class") == "fault"
    }


def test_the_form_asks_for_what_the_wizard_asks_any_kind_of_body(client):
    assert client.get("/numbers").status_code == 200
    asked = [
        field.get("name")
        for field in client.page.iter("input")
        if field.get("name") in MEASUREMENTS
    ]
    assert asked == list(QUICK)
    assert set(asked) == {name for name, row in MEASUREMENTS.items() if row.in_wizard}
    assert asked[:4] == ["stature", "weight", "bust_girth", "waist_girth"]


def test_the_form_says_which_waist(client):
    client.get("/numbers")
    assert "narrowest" in text(client.page.find(".//p[@id='waist_girth-how']"))
    assert "navel" in text(client.page.find(".//p[@id='abdomen_girth-how']"))


def test_the_form_asks_where_an_inside_leg_ends(client):
    response = client.send(**WOMAN, inseam_height="78")
    assert response.status_code == 422
    assert set(faults(client.page)) == {"inseam_height-to"}
    assert (
        client.send(**WOMAN, inseam_height="78", **{"inseam_height:to": "floor"}).status_code == 303
    )
    client.get("/numbers")
    chosen = client.page.find(".//select/option[@selected]")
    assert chosen.get("value") == "floor"


def test_each_unit_is_told_to_everyone(client):
    client.get("/numbers")
    for name in QUICK:
        field = client.page.find(f".//input[@name='{name}']")
        assert f"{name}-unit" in field.get("aria-describedby").split()
        assert field.get("inputmode") == ("text" if name == "inseam_height" else "decimal")


def test_measurements_lead_to_the_body(client):
    response = client.send(**WOMAN)
    assert response.status_code == 303
    assert response.location == "/avatar"


def test_what_was_typed_is_there_on_coming_back(client):
    client.send(**WOMAN)
    client.get("/numbers")
    assert values(client.page) == {"stature": "168", "waist_girth": "74,5"}
    assert client.page.find(".//input[@id='body-female']").get("checked") is not None


def test_a_fault_is_told_at_its_field_and_in_the_summary(client):
    response = client.send(**(WOMAN | {"stature": "1.68", "hip_girth": "wide"}))
    assert response.status_code == 422
    assert text(client.page.find("head/title")).startswith("Please check")
    assert faults(client.page) == {
        "stature": "That looks like metres. Did you mean 168 cm?",
        "hip_girth": "We could not read this as a number. Write it like 57.5 or 57,5.",
    }
    summary = client.page.find(".//div[@id='summary']")
    assert summary.get("tabindex") == "-1"
    assert summary.get("autofocus") is not None
    assert [link.get("href") for link in summary.iter("a")] == ["#stature", "#hip_girth"]
    for name in ("stature", "hip_girth"):
        field = client.page.find(f".//input[@name='{name}']")
        assert field.get("aria-invalid") == "true"
        assert f"{name}-fault" in field.get("aria-describedby").split()


def test_a_fault_loses_nothing_that_was_typed(client):
    typed = {"stature": "1.68", "waist_girth": "74,5", "hip_girth": "wide <b>"}
    client.send(**(WOMAN | typed))
    assert values(client.page) == typed
    client.get("/numbers")
    assert values(client.page) == typed


def test_a_form_without_a_body_is_told_so_at_the_choice(client):
    assert client.send(stature="168").status_code == 422
    assert faults(client.page) == {"body": "Choose one of the three."}
    assert client.page.find(".//a[@href='#body-female']") is not None


def test_an_empty_form_is_told_what_is_needed(client):
    client.send()
    assert set(faults(client.page)) == {"body", "stature"}


def test_a_change_of_units_converts_what_was_typed(client):
    response = client.send(**WOMAN, switch_to="imperial")
    assert response.status_code == 303
    client.get(response.location)
    assert values(client.page) == {"stature": "5 ft 6.14 in", "waist_girth": "29.33"}
    assert client.page.find(".//input[@name='units']").get("value") == "imperial"
    pressed = client.page.find(".//button[@aria-pressed='true']")
    assert text(pressed) == "in and lb"

    client.send(units="imperial", **values(client.page), switch_to="metric")
    client.get("/numbers")
    assert values(client.page) == {"stature": "168", "waist_girth": "74.5"}


def test_feet_and_fractions_of_inches_can_be_typed_on_a_telephone(client):
    client.send(units="imperial", switch_to="imperial")
    for page in ("/numbers", "/measure/hip_girth"):
        client.send("/", body="female", units="imperial")
        client.get(page)
        assert client.page.find(".//input[@name='hip_girth']").get("inputmode") == "text"
    client.get("/numbers")
    assert client.page.find(".//input[@name='stature']").get("inputmode") == "text"
    assert client.page.find(".//input[@name='weight']").get("inputmode") == "decimal"
    assert client.send(body="male", units="imperial", stature="5'10").status_code == 303


def test_a_change_of_units_is_no_time_for_messages(client):
    assert client.send(stature="tall", switch_to="imperial").status_code == 303
    client.get("/numbers")
    assert values(client.page) == {"stature": "tall"}
    assert faults(client.page) == {}


def test_the_enter_key_shows_the_body_and_changes_no_units(client):
    client.get("/numbers")
    first = next(button for button in client.page.iter("button") if button.get("type") == "submit")
    assert first.get("form") == "measurements"
    assert first.get("name") is None


def test_a_form_without_its_token_is_shown_again_with_what_was_typed(client):
    response = client.post("/numbers", data=WOMAN)
    assert response.status_code == 400
    assert "press the button once more" in response.text
    assert values(client.page) == {"stature": "168", "waist_girth": "74,5"}
    client.get("/numbers")
    assert values(client.page) == {}


def test_a_forged_token_is_refused(client):
    client.get("/numbers")
    assert client.post("/numbers", data=WOMAN | {"csrf_token": "forged"}).status_code == 400


def test_measurements_can_be_forgotten(client):
    client.send(**WOMAN)
    assert client.send("/forget").status_code == 303
    client.get("/numbers")
    assert values(client.page) == {}
    assert "Your measurements are forgotten." in text(client.page)


def test_forgetting_needs_the_token_too(client):
    client.send(**WOMAN)
    assert client.post("/forget").status_code == 400
    client.get("/numbers")
    assert values(client.page) == {"stature": "168", "waist_girth": "74,5"}


answers = st.text(max_size=40) | st.decimals(1, 300, places=1).map(str)


@given(st.dictionaries(st.sampled_from(["body", "units", "switch_to", *QUICK]), answers))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_any_form_is_answered(client, fields):
    response = client.send(**fields)
    assert response.status_code in (303, 422)
    kept = values(client.page) if response.status_code == 422 else {}
    for name, value in kept.items():
        assert value in "".join(sign if sign.isprintable() else " " for sign in fields[name])


@given(
    st.binary(max_size=300),
    st.sampled_from(
        [
            "application/x-www-form-urlencoded",
            "multipart/form-data",
            "multipart/form-data; boundary=a",
            "application/json",
            "text/plain",
        ]
    ),
)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_bytes_that_are_no_form_are_told_so_on_the_page(client, content, content_type):
    response = client.post("/numbers", data=content, content_type=content_type)
    assert response.status_code in (400, 413)


@pytest.mark.parametrize("count", [1, len(QUICK)])
def test_the_cookie_stays_within_a_browsers_limit(client, count):
    client.send(**dict.fromkeys(QUICK[:count], "".join(map(chr, range(0x1F600, 0x1F640)))))
    cookie = client.get_cookie("__Host-fitting_room")
    assert len(cookie.value) < 4000


def test_the_cookie_holds_every_measurement_read_three_times(client):
    client.send("/", body="female", units="imperial")
    for place, name in enumerate(MEASUREMENTS):
        inches = (28, 60, 20)[len(name) % 3] + place / 8
        texts = [f"{inches + extra} inches" for extra in (0, 0.25, 0.125)]
        fields = {name: texts[0], f"{name}:2": texts[1], f"{name}:3": texts[2]}
        client.send(f"/measure/{name}", **fields, units="imperial")
    assert len(client.get_cookie("__Host-fitting_room").value) < 4000
    with client.session_transaction() as session:
        kept = session["typed"]
    assert set(MEASUREMENTS) <= set(kept)
    assert f"{next(iter(MEASUREMENTS))}:3" in kept


def test_what_the_form_does_not_ask_is_kept_and_named(client):
    client.send("/", body="female", units="metric")
    client.send("/measure/calf_girth", units="metric", calf_girth="37")
    client.send(**WOMAN)
    client.get("/numbers")
    assert "Entered besides: Calf." in text(client.page)
