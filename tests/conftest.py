"""The site for tests, and a client that checks the HTML of every page it is given."""

import os
import sys
from collections import Counter

import html5lib
import jsonschema
import pytest
from flask.testing import FlaskClient
from hypothesis import settings

from model import studio
from model.measurements import BODY_KINDS, MEASUREMENTS
from webapp import create_app

# A slow machine is no failure; and what is checked before landing is the same each time.
settings.register_profile("any-speed", deadline=None, derandomize=bool(os.environ.get("CI")))
settings.load_profile("any-speed")

SETTINGS = {
    "TESTING": True,
    "SECRET_KEY": "of the tests, and no secret",
    "SESSION_COOKIE_SECURE": False,
    "RATELIMIT_ENABLED": False,
}

WOMAN = {
    "body": "female",
    "units": "metric",
    "stature": "168",
    "bust_girth": "92",
    "waist_girth": "74",
    "hip_girth": "100",
    "thigh_girth": "58",
}
"""Somebody, as they fill in the form."""

LIMITS = {
    kind: {name: (30, 200) if name == "weight" else (0.05, 2.0) for name in MEASUREMENTS}
    | {"stature": (1.3, 2.1), "waist_girth": (0.45, 1.7)}
    for kind in BODY_KINDS
}
"""Between which values must lie, by kind of body, SI: an estimator's, made up."""

SHOWN_LABELS = {"inseam_height": "Inside leg to the ankle", "neck_height": "Neck height"}
"""What a person is told who knows these measurements otherwise than by the table's labels."""

SLOWEST = (
    "test_scans",
    "test_mesh_repair",
    "test_refinement",
    "test_scans_registration",
    "test_api",
    "test_tape_fit",
    "test_comparisons",
    "test_silhouettes_bench",
    "test_delivery",
    "test_masks",
    "test_limits",
    "test_replicas",
)
"""Files that take the longest. They go first: what is left for the last one to finish is short."""


def pytest_collection_modifyitems(items):
    """Put the slowest files first, and leave all else as it is."""
    places = {name: place for place, name in enumerate(SLOWEST)}
    items.sort(key=lambda item: places.get(item.path.stem, len(places)))


def check_page(html):
    """Refuse a page that is no valid HTML or that some people could not use; return its tree."""
    parser = html5lib.HTMLParser(strict=True, namespaceHTMLElements=False)
    tree = parser.parse(html)
    everything = list(tree.iter())
    ids = Counter(element.get("id") for element in everything if element.get("id"))
    labelled = {label.get("for") for label in tree.iter("label")}

    assert tree.get("lang") in ("en-GB", "pt-PT")
    assert text(tree.find("head/title")).endswith(" – The Fitting Room")
    for landmark in ("header", "main", "footer"):
        assert len(list(tree.find("body").iter(landmark))) == 1, landmark
    assert len(list(tree.iter("h1"))) == 1
    assert [name for name, count in ids.items() if count > 1] == []
    for element in everything:
        if element.tag in ("input", "select") and element.get("type") != "hidden":
            assert element.get("id") in labelled, element.attrib
        if element.tag == "img":
            assert element.get("alt"), element.attrib
        if element.tag in ("a", "button", "legend", "caption", "th"):
            assert text(element) or element.get("aria-label"), element.attrib
        if element.tag == "form" and element.get("method") == "post":
            assert element.find(".//input[@name='csrf_token']") is not None
        if element.tag in ("a", "link", "script", "img"):
            address = element.get("href") or element.get("src") or "/"
            own = ("/", "#", "data:image/png;") if element.tag == "img" else ("/", "#")
            assert address.startswith(own), address
            assert not address.startswith("#") or address[1:] in ids, address
        for attribute in ("for", "aria-describedby", "aria-labelledby"):
            for name in (element.get(attribute) or "").split():
                assert name in ids, (attribute, name)
    return tree


def text(element):
    """What an element says."""
    return " ".join("".join(element.itertext()).split())


class CheckingClient(FlaskClient):
    """A browser of sorts: `page` is the last page's tree, and forms are sent with their token."""

    page = None

    def open(self, *args, **kwargs):
        response = super().open(*args, buffered=True, **kwargs)
        if response.mimetype == "text/html" and not 300 <= response.status_code < 400:
            self.page = check_page(response.text)
        return response

    def token(self, base_url=None):
        """What a form of this session must have with it, as the first page has it."""
        self.get("/", base_url=base_url)
        return self.page.find(".//input[@name='csrf_token']").get("value")

    def send(self, path="/numbers", **fields):
        """Post a form with its token."""
        return self.post(path, data={"csrf_token": self.token()} | fields)


@pytest.fixture(scope="session")
def make_site():
    """The site with some settings of its own."""

    def make(**settings):
        site = create_app(SETTINGS | settings)
        site.test_client_class = CheckingClient
        return site

    return make


@pytest.fixture(scope="session")
def site(make_site):
    return make_site()


@pytest.fixture
def client(site):
    return site.test_client()


@pytest.fixture
def shopper(client):
    """A client whose form is filled in."""
    client.send(**WOMAN)
    return client


@pytest.fixture
def no_pyrender():
    """Nothing can be drawn: what draws broke, and is not found again. Its `undo` mends that."""

    def fail(_):
        raise RuntimeError("broken")

    with pytest.MonkeyPatch.context() as hidden:
        hidden.setitem(sys.modules, "pyrender", None)
        with pytest.raises(studio.RenderingUnavailable):
            studio._in_studio(fail)
        yield hidden


@pytest.fixture(scope="session")
def description(site):
    return site.test_client().get("/api/v1/openapi.json").json


@pytest.fixture
def call(client, description):
    """Call the API and hold what it is sent and what it answers to its description."""

    def schema_of(part):
        return part["schema"] | {"components": description["components"]}

    def call(path, document=None, **options):
        method = "get" if document is None and not options else "post"
        if document is not None:
            options["json"] = document
        response = getattr(client, method)(path, **options)
        operation = description["paths"][path.partition("?")[0]][method]
        answer = operation["responses"][str(response.status_code)]
        ((media_type, part),) = answer["content"].items()
        assert response.mimetype == media_type
        if media_type.endswith("json"):
            jsonschema.Draft202012Validator(schema_of(part)).validate(response.json)
        if response.status_code == 200 and document is not None:
            (part,) = operation["requestBody"]["content"].values()
            jsonschema.Draft202012Validator(schema_of(part)).validate(document)
        assert "Set-Cookie" not in response.headers
        return response

    return call
