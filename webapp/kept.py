"""What a shopper typed, from one request to the next.

It is kept, exactly as typed, in the signed session cookie; the server remembers nobody.
"""

from flask import request, session

from webapp import refined
from webapp.answers import LEG, Typed
from webapp.language import usual_units
from webapp.sessions import cookie_fits


def remembered() -> Typed:
    """What the session keeps; before it keeps anything, the units that are usual there."""
    return Typed.of(session.get("typed") or {"units": usual_units()})


def remember(typed: Typed) -> None:
    """Keep it in the session: as typed, or shorter where the cookie would not hold it."""
    if typed.fields() != session.get("typed"):
        refined.leave()
    for kept in (typed, typed.shortest(), typed.shortest().once()):
        session["typed"] = kept.fields()
        if cookie_fits():
            return


def given(name: str) -> Typed:
    """The session's answers with the posted readings of one measurement."""
    posted = Typed.of(request.form)
    typed = remembered().written_in(posted.units, posted.leg_to if name == LEG else "")
    if not typed.body:
        typed = typed.with_body(posted.body)
    return typed.with_texts(name, posted.texts(name))
