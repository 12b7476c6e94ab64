"""A body that an outline had a say in, kept where all is kept: in the shopper's own cookie.

The server forgets outlines with its answer. What they made of the body is handed to the page as a
signed text; where the shopper takes that body along, the text goes into the session's cookie. It
holds for the entered values alone that it was made with, and is left aside once those change.
"""

import base64
import hashlib
import json

import numpy as np
from flask import current_app, session
from itsdangerous import BadSignature, URLSafeSerializer

from model.estimators import Estimator
from model.geometry import Floats
from model.measurements import MeasurementSet
from model.template_mesh import Body

_STEP = 1e-3
"""Of a coefficient's deviation: to that its text is exact, and a body to some hundredths of a
millimetre."""


def packed(estimator: Estimator, asked: MeasurementSet, coefficients: Floats) -> str:
    """A body's coefficients, ndarray of shape (K,), and what they were made with, as a text."""
    w = np.linalg.solve(estimator.spread, coefficients - estimator.mean) / _STEP
    steps = np.clip(np.round(w), -32767, 32767).astype("<i2")
    return f"{_origin(estimator, asked)}.{base64.urlsafe_b64encode(steps.tobytes()).decode()}"


def unpacked(estimator: Estimator, asked: MeasurementSet, text: str) -> Body | None:
    """The body of such a text; None where it was made with other values, or by another training."""
    origin, _, content = text.partition(".")
    if origin != _origin(estimator, asked):
        return None
    w = np.frombuffer(base64.urlsafe_b64decode(content), dtype="<i2") * _STEP
    return estimator.body(estimator.mean + estimator.spread @ w)


def signed(text: str) -> str:
    """The text as the page may hold it."""
    return _signer().dumps(text)


def take(token: str) -> bool:
    """Keep what `signed` gave; whether it was ours."""
    try:
        session["refined"] = str(_signer().loads(token))
    except BadSignature:
        return False
    return True


def kept() -> str:
    """What was taken along; "" where nothing was."""
    return str(session.get("refined", ""))


def leave() -> None:
    """Keep it no longer."""
    session.pop("refined", None)


def _origin(estimator: Estimator, asked: MeasurementSet) -> str:
    """Tells values and trainings from one another."""
    made_with = [estimator.kind, estimator.version, sorted(asked.items())]
    return hashlib.sha256(json.dumps(made_with).encode()).hexdigest()[:16]


def _signer() -> URLSafeSerializer:
    return URLSafeSerializer(current_app.secret_key or "", salt="refined")
