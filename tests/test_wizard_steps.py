"""The wizard's steps: one measurement a page, in turn, back, skipped, edited, read twice."""

import pytest
from conftest import text

from model.anthropometry import TAKEN
from model.measurements import BODY_KINDS, MEASUREMENTS
from webapp import guide, readings
from webapp.answers import Typed
from webapp.guide_girths import GIRTHS
from webapp.guide_lengths import LENGTHS


@pytest.fixture
def woman(client):
    client.send("/", body="female", units="metric")
    return client


def answer(client, name, **fields):
    return client.send(f"/measure/{name}", units="metric", **fields)


def faults(page):
    return [text(element) for element in page.iter("p") if element.get("class") == "fault"]


@pytest.mark.parametrize("kind", BODY_KINDS)
def test_each_kind_of_body_is_led_from_the_start_to_the_review(client, kind):
    response = client.send("/", body=kind, units="metric")
    seen = []
    while response.location.startswith("/measure/"):
        name = response.location.rpartition("/")[2]
        seen.append(name)
        client.get(response.location)
        assert client.page.find(f".//input[@id='{name}']") is not None
        if name == "stature":
            response = answer(client, name, stature="170")
        else:
            response = answer(client, name, skip="1")
    assert response.location == "/review"
    assert set(seen) == {name for name, row in MEASUREMENTS.items() if kind in row.in_wizard}
    assert seen[:2] == ["stature", "weight"]
    assert seen[-1] == "inseam_height"
    assert len(seen) <= 9


def test_nobody_is_measured_before_they_say_who_it_is_for(client):
    assert client.get("/measure/stature").location == "/"
    assert client.get("/review").location == "/"
    assert client.get("/measure").location == "/"
    response = client.send("/", units="metric")
    assert response.status_code == 422
    assert faults(client.page) == ["Choose one of the three."]


@pytest.mark.parametrize("name", TAKEN)
def test_every_measurement_has_its_page_with_words_and_a_picture(woman, name):
    assert woman.get(f"/measure/{name}").status_code == 200
    page = text(woman.page)
    words = guide.WORDS[name]
    assert str(words.what) in page
    assert str(words.mistake) in page
    if MEASUREMENTS[name].helper_needed:
        assert words.alone
    picture = woman.page.find(".//main").find(".//img")
    assert picture.get("src").startswith("/static/guide/")
    assert "?v=" in picture.get("src"), "the file is there"
    assert len(picture.get("alt")) > 30


@pytest.mark.parametrize("kind", BODY_KINDS)
def test_how_every_tape_lies_is_said_above_the_first_number_and_below_all(client, kind):
    client.send("/", body=kind, units="metric")
    above = []
    for name in guide.steps(kind):
        client.get(f"/measure/{name}")
        page = text(client.page.find(".//main"))
        above += [name] if "All tapes: level, snug" in page else []
        if MEASUREMENTS[name].kind == "girth":
            assert str(guide.tape(name)) in page
            assert str(guide.wear(name, kind)) in page
    assert above == ["bust_girth"]


def test_what_is_asked_in_turn_is_told_in_a_breath():
    """What a measurement is and how it is taken: some six seconds of reading at most."""
    for kind in BODY_KINDS:
        for name in guide.steps(kind):
            said = f"{guide.WORDS[name].what} {guide.how(name)}"
            assert len(said.split()) <= 25, name


def test_who_needs_a_helper_is_told_before_the_number(woman):
    woman.get("/measure/shoulder_length")
    (hint,) = [a for a in woman.page.iter("a") if a.get("href") == "#alone"]
    assert text(hint).startswith("Best done by someone else")
    assert "plaster" in text(woman.page.find(".//div[@id='alone']"))
    woman.get("/measure/waist_girth")
    assert not [a for a in woman.page.iter("a") if a.get("href") == "#alone"]


@pytest.mark.parametrize(
    ("languages", "units"),
    [
        ("en-US,en;q=0.9", "imperial"),
        ("en-GB,en-US;q=0.8", "metric"),
        ("pt-PT", "metric"),
        ("", "metric"),
    ],
)
def test_the_units_are_those_usual_where_a_browser_is_until_others_are_chosen(
    client, languages, units
):
    headers = {"Accept-Language": languages}
    for page in ("/", "/numbers"):
        client.get(page, headers=headers)
        chosen = client.page.find(".//*[@name='units'][@checked]")
        if chosen is None:
            chosen = client.page.find(".//input[@name='units']")
        assert chosen.get("value") == units
    client.send("/", body="female", units="metric")
    client.get("/measure/waist_girth", headers=headers)
    assert client.page.find(".//input[@name='units']").get("value") == "metric"


def test_the_guide_has_words_for_every_measurement_and_groups_them_all():
    assert set(GIRTHS) | set(LENGTHS) == set(MEASUREMENTS)
    assert set(GIRTHS) & set(LENGTHS) == set()
    grouped = [name for _, names in guide.GROUPS.values() for name in names]
    assert sorted(grouped) == sorted(MEASUREMENTS)


def test_a_number_leads_on_and_is_there_on_coming_back(woman):
    assert answer(woman, "stature", stature="168,5").location == "/measure/weight"
    woman.get("/measure/weight")
    assert woman.page.find(".//a[@id='back']").get("href") == "/measure/stature"
    woman.get("/measure/stature")
    assert woman.page.find(".//input[@id='stature']").get("value") == "168,5"


def test_a_number_that_cannot_be_is_told_and_not_lost(woman):
    response = answer(woman, "waist_girth", waist_girth="wide")
    assert response.status_code == 422
    assert faults(woman.page)[0].startswith("We could not read this")
    woman.get("/measure/waist_girth")
    assert woman.page.find(".//input[@id='waist_girth']").get("value") == "wide"


def test_height_cannot_be_passed_over(woman):
    assert answer(woman, "stature").status_code == 422
    assert answer(woman, "weight").status_code == 303


def test_skipping_leaves_a_measurement_out(woman):
    answer(woman, "weight", weight="62")
    assert answer(woman, "weight", skip="1").location == "/measure/bust_girth"
    woman.get("/measure/weight")
    assert woman.page.find(".//input[@id='weight']").get("value") == ""


def test_an_edit_from_the_review_comes_back_to_it(woman):
    answer(woman, "stature", stature="168")
    woman.get("/review")
    (edit,) = [a for a in woman.page.iter("a") if (a.get("aria-label") or "") == "Edit: Height"]
    woman.get(edit.get("href"))
    assert woman.page.find(".//input[@name='then']").get("value") == "review"
    assert answer(woman, "stature", stature="169", then="review").location == "/review"
    woman.get("/review")
    assert "169" in text(woman.page)


def test_all_41_are_offered_and_a_further_one_leads_back(woman):
    woman.get("/measure")
    names = {
        a.get("href").partition("?")[0].rpartition("/")[2]
        for a in woman.page.iter("a")
        if a.get("href").startswith("/measure/")
    }
    assert names == set(MEASUREMENTS)
    assert answer(woman, "calf_girth", calf_girth="37", then="more").location == "/measure"


def test_a_change_of_units_converts_every_reading(woman):
    fields = {"hip_girth": "100", "hip_girth:2": "101"}
    response = answer(woman, "hip_girth", **fields, switch_to="imperial")
    woman.get(response.location)
    values = [woman.page.find(f".//input[@name='{name}']").get("value") for name in fields]
    assert values == ["39.37", "39.76"]


def test_two_readings_that_agree_lead_on(woman):
    fields = {"waist_girth": "74", "waist_girth:2": "75"}
    assert answer(woman, "waist_girth", **fields).location == "/measure/abdomen_girth"


def test_two_readings_that_differ_ask_for_a_third_that_may_be_refused(woman):
    fields = {"waist_girth": "74", "waist_girth:2": "77"}
    response = answer(woman, "waist_girth", **fields)
    assert response.location == "/measure/waist_girth#third"
    woman.get(response.location)
    assert woman.page.find(".//input[@name='waist_girth:3']") is not None
    assert answer(woman, "waist_girth", **fields, enough="1").status_code == 303
    third = fields | {"waist_girth:3": "74,5"}
    assert answer(woman, "waist_girth", **third).location == "/measure/abdomen_girth"


@pytest.mark.parametrize(
    ("name", "place"),
    [
        ("waist_girth", "abdomen_girth"),
        ("abdomen_girth", "waist_girth"),
        ("bust_girth", "underbust_girth"),
        ("underbust_girth", "bust_girth"),
    ],
)
def test_a_tape_that_lies_elsewhere_is_kept_as_what_it_is(woman, name, place):
    answer(woman, name, **{name: "84"}, place=place)
    with woman.session_transaction() as session:
        typed = Typed.of(session["typed"])
    assert typed.answers == {place: "84"}
    response = answer(woman, name, **{name: "80"}, place=place)
    assert response.status_code == 422
    assert "You entered your" in faults(woman.page)[0]


def test_an_inside_leg_is_asked_where_it_ends(woman):
    assert answer(woman, "inseam_height", inseam_height="78").status_code == 422
    assert faults(woman.page) == ["Say where your number ends, so that we read it rightly."]
    answer(woman, "inseam_height", inseam_height="78", **{"inseam_height:to": "floor"})
    woman.get("/measure/inseam_height")
    assert woman.page.find(".//input[@id='to-floor']").get("checked") is not None
    pictures = [image for image in woman.page.iter("img") if "inside_leg" in image.get("src")]
    assert len(pictures) == 3


def test_the_picture_is_of_a_body_like_theirs(woman):
    def shown(name):
        woman.get(f"/measure/{name}")
        return woman.page.find(".//main").find(".//img").get("src")

    assert "waist_girth_female_medium" in shown("waist_girth")
    answer(woman, "stature", stature="168")
    answer(woman, "weight", weight="95")
    assert "waist_girth_female_broad" in shown("waist_girth")
    answer(woman, "weight", weight="54")
    assert "waist_girth_female_slim" in shown("waist_girth")


def test_a_page_whose_session_has_ended_is_shown_again_with_its_number(client):
    fields = {"body": "male", "units": "metric", "hip_girth": "101"}
    response = client.post("/measure/hip_girth", data=fields)
    assert response.status_code == 400
    assert client.page.find(".//input[@id='hip_girth']").get("value") == "101"
    assert client.post("/", data={"body": "male"}).status_code == 400
    assert client.page.find(".//input[@id='body-male']").get("checked") is not None


def test_there_is_no_step_for_what_is_no_measurement(woman):
    assert woman.get("/measure/shoe_size").status_code == 404
    assert woman.send("/measure/shoe_size").status_code == 404


def test_a_third_reading_is_wanted_beyond_the_known_repeatability():
    assert readings.differ("stature", [1.70, 1.711])
    assert not readings.differ("stature", [1.70, 1.709])
    assert not readings.differ("stature", [1.70, 1.75, 1.71])
    assert readings.middle([1.0, 3.0, 1.2]) == 1.2
    assert set(readings.REPEATABILITY) == set(MEASUREMENTS)


def test_a_person_who_repeats_well_is_surer():
    good = {"waist_girth": [0.800, 0.801], "hip_girth": [1.0, 1.001]}
    poor = {"waist_girth": [0.800, 0.850], "hip_girth": [1.0, 1.05]}
    assert readings.own_factor({}) == 1
    assert readings.own_factor(good) < 1 < readings.own_factor(poor)
    assert readings.noise(good)["waist_girth"] < readings.noise(poor)["waist_girth"]
    assert readings.noise({"waist_girth": [0.8]}) == {}
