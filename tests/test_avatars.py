"""The avatar's page, file and pictures."""

import io

import pytest
import trimesh
from conftest import WOMAN, text
from PIL import Image

from model.anthropometry import ImpossibleBodyError
from model.measurements import MEASUREMENTS
from webapp import avatars


def table(page):
    """The numbers' tables: measurement to its other cells."""
    rows = [row for row in page.iter("tr") if row.get("data-measurement")]
    return {row.get("data-measurement"): [text(cell) for cell in row][1:] for row in rows}


def test_the_page_tells_asked_and_taken_for_every_measurement(shopper):
    assert shopper.get("/avatar").status_code == 200
    numbers = table(shopper.page)
    assert set(numbers) == set(MEASUREMENTS)
    asked, taken, difference = numbers["bust_girth"]
    assert asked == "92.0"
    sign = difference.replace("−", "-")
    assert float(taken) - 92 == pytest.approx(float(sign), abs=0.11)


def test_the_body_has_what_was_typed_and_the_page_says_so(shopper):
    shopper.get("/avatar")
    assert "It measures what you typed" in text(shopper.page)
    numbers = table(shopper.page)
    for name in ("stature", "bust_girth", "waist_girth", "hip_girth", "thigh_girth"):
        asked, taken, difference = numbers[name]
        assert asked == taken
        assert difference == "0.0"


def test_what_does_not_go_together_is_named(client):
    client.send(body="female", stature="168", bust_girth="140", waist_girth="50", weight="45")
    client.get("/avatar")
    opening = text(client.page.find(".//div[@class='opening']"))
    assert "as near to what you typed as a body can" in opening
    asked, taken, difference = table(client.page)["bust_girth"]
    assert "Bust / chest" in opening
    assert difference == f"\N{MINUS SIGN}{float(asked) - float(taken):.1f}"


def test_a_value_that_was_not_entered_comes_with_its_range(shopper):
    shopper.get("/avatar")
    taken, spread = table(shopper.page)["neck_girth"]
    low, high = map(float, spread.split(" to "))
    assert low < float(taken) < high


def test_the_page_speaks_the_shoppers_units(client):
    client.send(body="male", units="imperial", stature="5'11", weight="170")
    client.get("/avatar")
    assert text(client.page.find(".//caption")) == "Lengths in inches, weight in pounds"
    assert table(client.page)["stature"][0] == "5′ 11.00″"
    assert table(client.page)["weight"][0] == "170.0"


def test_the_page_holds_what_the_viewer_needs(shopper):
    shopper.get("/avatar")
    viewer = shopper.page.find(".//div[@id='viewer']")
    assert viewer.get("data-glb") == "/avatar.glb"
    assert viewer.find("img") is not None
    buttons = list(shopper.page.iter("button"))
    assert [button.get("data-view") for button in buttons if button.get("data-view")] == [
        "front",
        "quarter",
        "side",
        "back",
    ]
    assert {button.get("data-zoom") for button in buttons} >= {"in", "out"}


def test_the_way_back_keeps_what_was_typed(shopper):
    shopper.get("/avatar")
    back = next(link for link in shopper.page.iter("a") if text(link) == "Edit measurements")
    shopper.get(back.get("href"))
    assert "Height 168" in text(shopper.page)


def test_the_file_has_the_stature_that_the_page_states(shopper):
    shopper.get("/avatar")
    response = shopper.get("/avatar.glb")
    assert response.mimetype == "model/gltf-binary"
    assert response.headers["Content-Disposition"] == "attachment; filename=avatar.glb"
    scene = trimesh.load_scene(io.BytesIO(response.data), file_type="glb")
    low, high = scene.bounds[:, 1]
    assert low == pytest.approx(0, abs=1e-4)
    assert 100 * high == pytest.approx(float(table(shopper.page)["stature"][1]), abs=0.06)


@pytest.mark.parametrize("side", ["front", "profile"])
def test_the_pictures_are_pictures(shopper, side):
    response = shopper.get(f"/avatar/{side}.png")
    assert response.mimetype == "image/png"
    with Image.open(io.BytesIO(response.data)) as picture:
        assert picture.size == (600, 1200)


def test_without_measurements_the_page_leads_kindly_to_the_form(client):
    response = client.get("/avatar")
    assert response.status_code == 303
    assert response.location == "/"
    assert "we need your height first" in client.get("/").text


@pytest.mark.parametrize("path", ["/avatar.glb", "/avatar/front.png", "/avatar/back.png"])
def test_without_measurements_there_is_no_file(client, path):
    assert client.get(path).status_code == 404
    assert "There is nothing here" in text(client.page)


def test_answers_that_make_no_body_lead_to_the_form(client):
    client.send(body="female", stature="tall")
    assert client.get("/avatar").status_code == 303
    assert "need another look" in client.get("/review").text
    assert "tall" in text(client.page)
    client.get("/numbers")
    assert client.page.find(".//input[@name='stature']").get("value") == "tall"


def impossible(body):
    raise ImpossibleBodyError("the body has no weight")


def test_values_that_no_body_has_together_lead_kindly_to_the_form(shopper, monkeypatch, caplog):
    monkeypatch.setattr(avatars, "measure", impossible)
    response = shopper.get("/avatar")
    assert response.status_code == 303
    assert response.location == "/review"
    shopper.get("/review")
    assert "contradict each other" in text(shopper.page.find(".//p[@role='status']"))
    shopper.get("/numbers")
    for name in ("stature", "waist_girth", "thigh_girth"):
        assert shopper.page.find(f".//input[@name='{name}']").get("value") == WOMAN[name]
    assert [record for record in caplog.records if record.levelname != "INFO"] == []


@pytest.mark.parametrize("path", ["/avatar.glb", "/avatar/front.png", "/avatar/profile.png"])
def test_values_that_no_body_has_together_have_no_file(shopper, monkeypatch, caplog, path):
    monkeypatch.setattr(avatars, "measure", impossible)
    assert shopper.get(path).status_code == 404
    assert [record for record in caplog.records if record.levelname != "INFO"] == []


@pytest.mark.parametrize("path", ["/avatar", "/avatar.glb", "/avatar/front.png"])
def test_what_shows_a_person_is_never_stored(shopper, path):
    assert shopper.get(path).headers["Cache-Control"] == "no-store"


def test_a_server_that_cannot_draw_says_so_and_serves_the_rest(shopper, no_pyrender):
    assert shopper.get("/avatar").status_code == 200
    assert "cannot draw pictures" in text(shopper.page)
    assert list(shopper.page.iter("img")) == []
    assert shopper.get("/avatar.glb").status_code == 200
    answer = shopper.get("/avatar/front.png")
    assert answer.status_code == 503
    assert "Retry-After" not in answer.headers


def test_a_server_that_can_draw_again_does_so_and_tries_no_more(shopper, no_pyrender, monkeypatch):
    shopper.get("/avatar")
    assert list(shopper.page.iter("img")) == []
    no_pyrender.undo()
    drawn, draw = [], avatars.render_png
    monkeypatch.setattr(avatars, "render_png", lambda *a, **k: drawn.append(draw(*a, **k)))
    for _ in range(2):
        shopper.get("/avatar")
        assert len(list(shopper.page.iter("img"))) == 3
    assert len(drawn) == 1
