"""Pictures of outlines as requests bring them: how large, how many, and why one is refused.

Only outlines come here, as black and white pictures, and none is kept: a request's files are held
in memory until it is answered.
"""

import io
from collections.abc import Mapping
from typing import IO

from flask import Request, request
from flask_babel import gettext

from model.cameras import SIDES, Side
from model.masks import MOST_BYTES, Mask, PictureRefusedError, read_mask
from webapp.comparison_words import WORDS
from webapp.forms import Refusal, Refused

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


def _sent(side: Side) -> bytes:
    """The bytes of one picture; none where it was not sent, or a form's field was left empty."""
    if side in request.files:
        return request.files[side].read()
    return request.form.get(side, "").encode()
