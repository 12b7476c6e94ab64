"""A shopper's photos beside the avatar: the page, and what it and the API answer.

Only outlines come here, as black and white pictures, and none is kept: a request's files are held
in memory until it is answered.
"""

import base64
import io
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import IO, Any

import numpy as np
from flask import (
    Blueprint,
    Request,
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
from model.masks import MOST_BYTES, Mask, PictureRefusedError, read_mask
from model.measurements import MEASUREMENTS
from model.refinement import HANGING, WORN, Photo, Refined, Worn, refine
from model.rendering import render_png
from model.studio import RenderingUnavailable
from webapp import refined, units
from webapp.avatars import Avatar, avatar_of, make_avatar, shown_request
from webapp.comparison_words import CLOTHES, REASONS, TITLES, WORDS, reasons_at
from webapp.forms import CAMERA_LIMITS, AvatarRequest, Refusal, Refused
from webapp.sessions import cookie_fits
from webapp.table_words import label

SIDES: tuple[Side, ...] = ("front", "profile")

MOST_DOCUMENT = 64 * 1024
"""Bytes of the part that asks for the avatar, as of any other request."""

ROOM = len(SIDES) * MOST_BYTES + 2 * MOST_DOCUMENT
"""Bytes of a request with pictures."""

STATUS: Mapping[str, int] = {
    "wrong_type": 415,
    "animated": 415,
    "unreadable": 415,
    "too_large": 413,
}
"""What a picture is refused with; 422 where it is a picture, but of no person standing alone."""

bp = Blueprint("comparisons", __name__)


class InMemory(Request):
    """A request whose files never touch the disk."""

    def _get_file_stream(
        self,
        total_content_length: int | None,  # noqa: ARG002 - the signature is Werkzeug's
        content_type: str | None,  # noqa: ARG002
        filename: str | None = None,  # noqa: ARG002
        content_length: int | None = None,  # noqa: ARG002
    ) -> IO[bytes]:
        return io.BytesIO()


class PicturesRefused(Refused):
    """Pictures that cannot be compared; `status` is the first one's."""

    def __init__(self, faults: Mapping[str, PictureRefusedError]) -> None:
        reasons = {field: fault.reason for field, fault in faults.items()}
        super().__init__(
            [Refusal(field, reason, str(WORDS[reason])) for field, reason in reasons.items()]
        )
        self.status = STATUS.get(next(iter(reasons.values())), 422)


def make_room() -> None:
    """Let requests with pictures be larger than others."""
    if request.endpoint in ("api.comparison", "comparisons.answer"):
        request.max_content_length = ROOM


def masks_sent() -> dict[Side, Mask]:
    """The outlines of the request's pictures.

    Raises
    ------
    Refused
        Without any, or with one that is no outline of one standing person.
    """
    masks: dict[Side, Mask] = {}
    faults: dict[str, PictureRefusedError] = {}
    for side in SIDES:
        content = _sent(side)
        if not content:
            continue
        try:
            masks[side] = read_mask(content)
        except PictureRefusedError as fault:
            faults[side] = fault
    if faults:
        raise PicturesRefused(faults)
    if not masks:
        message = gettext("A picture is needed: front, profile or both.")
        raise Refused([Refusal("front", "required", message)])
    return masks


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


def _sent(side: Side) -> bytes:
    """The bytes of one picture; none where it was not sent, or a form's field was left empty."""
    if side in request.files:
        return request.files[side].read()
    return request.form.get(side, "").encode()


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
