"""What a shopper takes along: the measurements as CSV, and the sheet to print."""

import csv
import io

import pytest
from conftest import SHOWN_LABELS, text

from model.measurements import MEASUREMENTS
from webapp.units import SYMBOLS, from_si

ANSWERS = {"stature": "168", "weight": "66", "waist_girth": "76.5"}


@pytest.fixture
def shopper(client):
    with client.session_transaction() as session:
        session["typed"] = {"body": "female", "units": "metric"} | ANSWERS
    return client


def lines(response):
    assert response.mimetype == "text/csv"
    assert response.headers["Content-Disposition"] == "attachment; filename=measurements.csv"
    return list(csv.DictReader(io.StringIO(response.text, newline="")))


def test_the_table_holds_what_the_page_says(shopper):
    rows = lines(shopper.get("/avatar.csv"))
    assert list(rows[0]) == ["measurement", "label", "unit", "asked", "taken", "low", "high"]
    assert [row["measurement"] for row in rows] == list(MEASUREMENTS)
    answered = {row["name"]: row for row in shopper.get("/avatar.json").json["measurements"]}
    for row in rows:
        name = row["measurement"]
        assert row["label"] == SHOWN_LABELS.get(name, MEASUREMENTS[name].label)
        assert row["unit"] == SYMBOLS[MEASUREMENTS[name].unit]["metric"]
        assert (row["asked"] != "") == (name in ANSWERS)
        for column in ("taken", "low", "high"):
            assert float(row[column]) == pytest.approx(answered[name][column], abs=0.006)
        assert float(row["low"]) <= float(row["taken"]) <= float(row["high"])
    assert {row["measurement"]: row["asked"] for row in rows}["waist_girth"] == "76.50"


def test_the_table_speaks_the_shoppers_units(client):
    with client.session_transaction() as session:
        session["typed"] = {"body": "male", "units": "imperial", "stature": "71", "weight": "170"}
    rows = {row["measurement"]: row for row in lines(client.get("/avatar.csv"))}
    assert rows["stature"]["unit"] == "in" and rows["weight"]["unit"] == "lb"
    assert rows["stature"]["asked"] == "71.00"
    assert float(rows["stature"]["taken"]) == pytest.approx(71, abs=0.05)
    assert float(rows["weight"]["taken"]) == pytest.approx(
        from_si(77.1107, "kg", "imperial"), abs=0.3
    )


def test_the_sheet_shows_all_measurements_and_both_pictures(shopper):
    assert shopper.get("/avatar/sheet").status_code == 200
    cells = {
        row.get("data-measurement"): [text(cell) for cell in row]
        for row in shopper.page.iter("tr")
        if row.get("data-measurement")
    }
    assert set(cells) == set(MEASUREMENTS)
    assert cells["waist_girth"] == [MEASUREMENTS["waist_girth"].label, "76.5", "76.5", ""]
    _, entered, taken, spread = cells["neck_girth"]
    low, high = map(float, spread.split(" to "))
    assert entered == "" and low <= float(taken) <= high
    pictures = [image.get("src") for image in shopper.page.iter("img")]
    assert pictures == ["/avatar/front.png", "/avatar/profile.png"]


def test_the_avatars_page_leads_to_both(shopper):
    shopper.get("/avatar")
    links = [link.get("href") for link in shopper.page.iter("a")]
    assert "/avatar/sheet" in links and "/avatar.csv" in links


@pytest.mark.parametrize("path", ["/avatar.csv", "/avatar/sheet"])
def test_without_measurements_there_is_nothing_to_take(client, path):
    assert client.get(path).status_code == 404


def test_no_one_else_keeps_the_sheet(shopper):
    for path in ("/avatar.csv", "/avatar/sheet"):
        assert shopper.get(path).cache_control.no_store
