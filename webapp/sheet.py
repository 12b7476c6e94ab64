"""What a shopper takes along besides the body: all measurements, as CSV and on a sheet to print."""

import csv
import io

from flask import Blueprint, Response, render_template
from flask_babel import gettext as _

from model.measurements import MEASUREMENTS
from webapp import table_words, units
from webapp.avatars import Avatar, estimated_groups, rows, shown, why_no_pictures

COLUMNS = ("measurement", "label", "unit", "asked", "taken", "low", "high")
"""Of the table as CSV, the same in every language; `asked` is empty where nothing was entered."""

bp = Blueprint("sheet", __name__)


@bp.get("/avatar.csv")
def table() -> Response:
    """The measurements as a spreadsheet's file, in the shopper's units."""
    response = Response(_csv(shown()), mimetype="text/csv")
    response.headers.set("Content-Disposition", "attachment", filename="measurements.csv")
    return response


@bp.get("/avatar/sheet")
def page() -> str:
    """The measurements and the pictures on one sheet of paper."""
    avatar = shown()
    every = rows(avatar)
    entered = {_("You entered"): [row for row in every if row.asked is not None]}
    return render_template(
        "avatars/sheet.html",
        units=avatar.wanted.units,
        groups=entered | estimated_groups(every),
        labels=table_words.body_labels(),
        measurements=MEASUREMENTS,
        version=avatar.estimator.version,
        pictures=not why_no_pictures(),
    )


def _csv(avatar: Avatar) -> str:
    """One line for each measurement, in the table's order."""
    chosen = avatar.wanted.units
    text = io.StringIO(newline="")
    lines = csv.writer(text)
    lines.writerow(COLUMNS)
    for row in rows(avatar):
        measurement = MEASUREMENTS[row.name]
        symbol = units.SYMBOLS[measurement.unit][chosen]
        numbers = [
            "" if value is None else f"{units.from_si(value, measurement.unit, chosen):.2f}"
            for value in (row.asked, row.taken, row.low, row.high)
        ]
        lines.writerow([row.name, table_words.body_label(row.name), symbol, *numbers])
    return text.getvalue()
