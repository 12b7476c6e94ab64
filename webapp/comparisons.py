"""Outlines of a shopper's photos beside the avatar: the page, and what it and the API answer."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from flask import (
    Blueprint,
    Response,
    abort,
    flash,
    jsonify,
    redirect,
    render_template,
    request,
    url_for,
)
from flask_babel import gettext
from werkzeug.wrappers import Response as AnyResponse

from model.camera_estimate import estimate_camera
from model.cameras import Camera, Side
from model.comparison import EDGE_LEVELS, Comparison, compare
from model.comparison_pictures import difference, filled, overlay, projection
from model.masks import Mask, PictureRefusedError
from model.measurements import MEASUREMENTS
from model.refinement import HANGING, WORN, Photo, Refined, Worn, refine
from model.rendering import render_png
from model.studio import RenderingUnavailable
from webapp import refined, units
from webapp.avatars import Avatar, avatar_of, make_avatar, shown_request
from webapp.comparison_words import CLOTHES, REASONS, TITLES, reasons_at
from webapp.forms import CAMERA_LIMITS, AvatarRequest, Refusal, Refused
from webapp.sessions import cookie_fits
from webapp.table_words import label
from webapp.uploads import PicturesRefused, masks_sent

bp = Blueprint("comparisons", __name__)


def camera_of(avatar: Avatar, masks: Mapping[Side, Mask]) -> Camera:
    """Where the camera stood: as told, and otherwise as the outlines have it."""
    camera, told = avatar.wanted.camera, avatar.wanted.told
    if {"distance", "height"} <= told:
        return camera
    return estimate_camera(
        masks, avatar.body, **{name: getattr(camera, name) for name in sorted(told)}
    )


def compare_all(
    avatar: Avatar, masks: Mapping[Side, Mask], camera: Camera
) -> dict[Side, Comparison]:
    """Each outline beside the avatar.

    Raises
    ------
    Refused
        Where one has too little in common with any person who stands upright.
    """
    found: dict[Side, Comparison] = {}
    faults: dict[str, PictureRefusedError] = {}
    for side, mask in masks.items():
        try:
            found[side] = compare(mask, avatar.body, side, camera=camera)
        except PictureRefusedError as fault:
            faults[side] = fault
    if faults:
        raise PicturesRefused(faults)
    return found


@dataclass(frozen=True, slots=True)
class Improved:
    """An avatar that the outlines had a say in, and the same outlines beside it."""

    avatar: Avatar
    refined: Refined
    views: Mapping[Side, Comparison]


def improve(
    avatar: Avatar, masks: Mapping[Side, Mask], views: Mapping[Side, Comparison]
) -> Improved:
    """The avatar as the outlines would have it; entered values hold as they did."""
    photos = [Photo(masks[side], side, view.camera, view.facing) for side, view in views.items()]
    camera = photos[0].camera
    found = refine(avatar.estimator, avatar.wanted.asked, photos, avatar.wanted.worn)
    # Where the outlines had no say, a body that earlier ones refined stays as it is.
    improved = avatar_of(avatar.wanted, avatar.estimator, found.fit.body) if found.pull else avatar
    return Improved(improved, found, compare_all(improved, masks, camera))


def refinement(avatar: Avatar, improved: Improved) -> dict[str, Any]:
    """What the outlines changed, in the request's units; and the views, in centimetres."""
    found, chosen = improved.refined, avatar.wanted.units
    before, after = avatar.measured.values, improved.avatar.measured.values
    # From the body that is shown before: one that earlier outlines refined is not the plain fit.
    moved = np.linalg.norm(improved.avatar.body.vertices - avatar.body.vertices, axis=1)
    return {
        "pull": found.pull,
        "moved_cm": {
            "mean": round(100 * float(moved.mean()), 3),
            "most": round(100 * float(moved.max()), 3),
        },
        "cloth_cm": round(100 * float(found.cloth.mean()), 2),
        **_clothes(improved),
        "unexplained": round(found.unexplained, 3),
        "measurements": [
            {
                "name": name,
                "unit": units.SYMBOLS[MEASUREMENTS[name].unit][chosen],
                "before": round(units.from_si(before[name], MEASUREMENTS[name].unit, chosen), 3),
                "after": round(units.from_si(after[name], MEASUREMENTS[name].unit, chosen), 3),
            }
            for name in before
        ],
        **{side: document(view, avatar.wanted) for side, view in improved.views.items()},
    }


def _clothes(improved: Improved) -> dict[str, Any]:
    """What was taken for clothes, and where outlines only said where the body ends at most.

    Of every girth at whose height outlines have a say, whether or not a view shows its level; from
    the top down.
    """
    measured = improved.avatar.measured
    stature = measured.values["stature"]
    heights = {name: float(measured.paths[name][:, 1].mean()) for name in EDGE_LEVELS}
    shares = {
        name: height / stature
        for name, height in sorted(heights.items(), key=lambda pair: -pair[1])
    }
    found = improved.refined
    cloth = {name: found.cloth_at(share) for name, share in shares.items()}
    return {
        "clothes": [
            {"measurement": name, "cloth_cm": round(100 * off, 2)}
            for name, off in cloth.items()
            if off >= HANGING
        ],
        "limited": [name for name, share in shares.items() if found.loose_at(share)],
    }


def document(comparison: Comparison, wanted: AvatarRequest) -> dict[str, Any]:
    """One view, as the contract has it, in centimetres; and where the camera stood, in metres."""
    camera = {name: round(getattr(comparison.camera, name), 2) for name in CAMERA_LIMITS}
    return {
        "camera": camera | {"estimated": [name for name in camera if name not in wanted.told]},
        "arms": "left_out",
        "unseen": list(comparison.unseen),
        "iou": round(comparison.iou, 4),
        "mean_outline_distance_cm": round(100 * comparison.distance, 3),
        "levels": [
            {
                "measurement": level.measurement,
                "photo_cm": round(100 * level.photo, 2),
                "avatar_cm": round(100 * level.avatar, 2),
                "reasons": reasons_at(level, wanted.asked),
            }
            for level in comparison.levels
        ],
        "overlay_png": _data(overlay(comparison)),
    }


def shown(comparison: Comparison, avatar: Avatar) -> dict[str, Any]:
    """One view, as the page needs it: the contract's members and more."""
    chosen = avatar.wanted.units
    height, width = comparison.photo.shape
    left, top, scale = comparison.place
    view = document(comparison, avatar.wanted)
    return view | {
        "levels": [
            row
            | {
                "label": label(level.measurement),
                "why": [str(TITLES[code]) for code in row["reasons"]],
                "photo": round(units.from_si(level.photo, "m", chosen), 2),
                "avatar": round(units.from_si(level.avatar, "m", chosen), 2),
                "row": round(comparison.origin[1] - level.height / comparison.step, 1),
            }
            for row, level in zip(view["levels"], comparison.levels, strict=True)
        ],
        "hidden": [label(name) for name in comparison.unseen],
        "facing": comparison.facing,
        "width": width,
        "height": height,
        "place": {"left": left, "top": top, "scale": scale},
        "photo_png": _data(filled(comparison.photo)),
        "avatar_png": _data(_drawn(comparison, avatar)),
        "difference_png": _data(difference(comparison)),
    }


@bp.get("/compare")
def page() -> str | AnyResponse:
    """The page on which photos become outlines."""
    wanted = shown_request()
    if wanted is None:
        return redirect(url_for("wizard.start"), 303)
    return _page(wanted)


@bp.post("/compare")
def answer() -> Response | AnyResponse | str | tuple[str, int]:
    """The outlines beside the avatar: as JSON for scripts, as a page for those who have none."""
    wanted = shown_request()
    scripted = request.accept_mimetypes.best_match(["text/html", "application/json"])
    as_json = scripted == "application/json"
    if wanted is None:
        if as_json:
            raise Refused(
                [Refusal("avatar", "required", gettext("Please enter your measurements first."))]
            )
        return redirect(url_for("wizard.start"), 303)
    try:
        wanted = _with_setup(wanted)
        masks = masks_sent()
        avatar = make_avatar(wanted)
        compared = compare_all(avatar, masks, camera_of(avatar, masks))
        views = {side: shown(view, avatar) for side, view in compared.items()}
        changes: dict[str, Any] = {}
        if request.form.get("refine"):
            improved = improve(avatar, masks, compared)
            changes = refinement(avatar, improved)
            coefficients = improved.refined.fit.coefficients
            text = refined.packed(avatar.estimator, avatar.wanted.asked, coefficients)
            changes["take"] = refined.signed(text)
            for row in changes["measurements"]:
                row["label"] = label(row["name"])
            for row in changes["clothes"]:
                row["label"] = label(row["measurement"])
            changes["limited"] = [label(name) for name in changes["limited"]]
            for side, view in improved.views.items():
                changes[side] = shown(view, improved.avatar)
    except Refused as refused:
        if as_json:
            raise
        return _page(wanted, faults=refused.faults), getattr(refused, "status", 422)
    if not as_json:
        return _page(wanted, views=views, changes=changes)
    reasons = [
        {"code": code, "title": str(title), "words": str(words)} for code, title, words in REASONS
    ]
    content = {"units": wanted.units, "reasons": reasons} | views
    return jsonify(content | ({"refinement": changes} if changes else {}))


@bp.post("/compare/body")
def take() -> AnyResponse:
    """Go on with the body that the outlines had a say in; or, with `leave`, without their say."""
    if request.form.get("leave"):
        refined.leave()
    elif not refined.take(request.form.get("refined", "")):
        abort(400)
    elif not cookie_fits():
        refined.leave()
        flash(gettext("There is no room for that body beside all that you entered."))
    return redirect(url_for("avatars.page"), 303)


def _page(
    wanted: AvatarRequest,
    views: Mapping[Side, Mapping[str, Any]] | None = None,
    faults: tuple[Refusal, ...] = (),
    changes: Mapping[str, Any] | None = None,
) -> str:
    return render_template(
        "comparisons/compare.html",
        units=wanted.units,
        symbol=units.SYMBOLS["m"][wanted.units],
        views=views or {},
        changes=changes or {},
        faults=faults,
        messages={fault.field: fault.message for fault in faults},
        reasons=REASONS,
        clothes=CLOTHES,
        worn=_worn() or "",
        camera={name: request.form.get(f"camera_{name}", "")[:20] for name in CAMERA_LIMITS},
    )


def _with_setup(wanted: AvatarRequest) -> AvatarRequest:
    """The same request, with the clothes and seen by the camera that the form tells of."""
    placed, faults = {}, []
    for name, (low, high) in CAMERA_LIMITS.items():
        field = f"camera_{name}"
        typed = request.form.get(field, "").strip()[:20]
        if not typed:
            continue
        try:
            value = units.parse(typed, "m", wanted.units)
        except ValueError:
            faults.append(
                Refusal(field, "not_a_number", gettext("We could not read this as a number."))
            )
            continue
        if low <= value <= high:
            placed[name] = value
        else:
            least, most = units.range_in(low, high, "m", wanted.units, 0)
            symbol = units.SYMBOLS["m"][wanted.units]
            message = gettext(
                "Between %(least)s and %(most)s %(unit)s, please.",
                least=f"{least:g}",
                most=f"{most:g}",
                unit=symbol,
            )
            faults.append(Refusal(field, "out_of_range", message))
    if faults:
        raise Refused(faults)
    return replace(wanted, worn=_worn(), camera=Camera(**placed), told=frozenset(placed))


def _worn() -> Worn | None:
    """What the form says is worn; None where it does not say."""
    return next((one for one in WORN if one == request.form.get("worn")), None)


def _drawn(comparison: Comparison, avatar: Avatar) -> bytes:
    """The avatar as the photo's camera sees it; its outline alone where nothing can be drawn."""
    height, width = comparison.photo.shape
    try:
        return render_png(
            avatar.body,
            comparison.side,
            size=(width, height),
            projection=projection(comparison),
        )
    except RenderingUnavailable:
        return filled(comparison.avatar)


def _data(png: bytes) -> str:
    return "data:image/png;base64," + base64.b64encode(png).decode()
