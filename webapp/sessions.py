"""Sessions that outlive a jump of the clock, and servers whose clocks differ."""

from datetime import UTC, datetime

from flask import Flask, Request, current_app, session
from flask.sessions import SecureCookieSession, SecureCookieSessionInterface
from itsdangerous import BadSignature

COOKIE = 3800
"""Bytes of the session's cookie at most: browsers keep 4,096, its name and attributes included."""


def cookie_fits() -> bool:
    """Whether the session, as it is now, is no larger than a cookie may be."""
    signer = SecureCookieSessionInterface().get_signing_serializer(current_app)
    return signer is None or len(signer.dumps(dict(session))) <= COOKIE


class ClockProofSessions(SecureCookieSessionInterface):
    """Signed cookies, which are as good when they were signed in what is the future here.

    Flask's own are refused if signed one second ahead: where two servers' clocks differ, or one is
    set back, shoppers would lose what they typed. Too old a cookie is refused here too.
    """

    def open_session(self, app: Flask, request: Request) -> SecureCookieSession | None:
        """The session of a request; an empty one where its cookie is not ours, or too old."""
        serializer = self.get_signing_serializer(app)
        if serializer is None:
            return None
        value = request.cookies.get(self.get_cookie_name(app))
        if not value:
            return self.session_class()
        try:
            content, signed = serializer.loads(value, return_timestamp=True)
        except BadSignature:
            return self.session_class()
        if datetime.now(UTC) - signed > app.permanent_session_lifetime:
            return self.session_class()
        return self.session_class(content)
