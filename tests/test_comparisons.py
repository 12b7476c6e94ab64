"""Comparing outlines: the page and the API."""

import base64
import io
import json
import tempfile

import jsonschema
import numpy as np
import pytest
from PIL import Image
from scipy import ndimage
from werkzeug.datastructures import FileStorage
from werkzeug.test import encode_multipart

from model.comparison import EDGE_LEVELS
from webapp.uploads import ROOM

PERSON = {
    "body": "male",
    "measurements": {"stature": 178, "weight": 80, "waist_girth": 88, "hip_girth": 100},
}
TYPED = {"body": "male", "units": "metric", "stature": "178", "weight": "80"}


def outline(client, side, person=PERSON, **drawing):
    """A body's outline as the API draws it: a PNG file."""
    document = person | {"silhouette": True} | drawing
    return client.post(f"/api/v1/avatars/{side}.png", json=document).data


def send(client, avatar=PERSON, path="/api/v1/comparisons", **pictures):
    """Sends parts as other programs do: the JSON as a file of its type, too."""
    data = {
        side: FileStorage(io.BytesIO(content), f"{side}.png", content_type="image/png")
        for side, content in pictures.items()
    }
    if avatar is not None:
        content = avatar if isinstance(avatar, bytes) else json.dumps(avatar).encode()
        data["avatar"] = FileStorage(
            io.BytesIO(content), "avatar.json", content_type="application/json"
        )
    # Encoded here: the test client writes what is large into a file.
    boundary, body = encode_multipart(data)
    return client.post(path, data=body, content_type=f"multipart/form-data; boundary={boundary}")


def faults(response):
    return {(fault["field"], fault["code"]) for fault in response.json["errors"]}


def picture(data):
    assert data.startswith("data:image/png;base64,")
    return Image.open(io.BytesIO(base64.b64decode(data.partition(",")[2])))


def test_the_avatars_own_outline_is_the_same(client):
    pictures = {side: outline(client, side) for side in ("front", "profile")}
    answer = send(client, **pictures).json
    assert list(answer) == ["front", "profile"]
    for view in answer.values():
        contract = {"iou", "mean_outline_distance_cm", "levels", "overlay_png"}
        assert set(view) == contract | {"camera", "arms", "unseen"}
        assert view["arms"] == "left_out"
        assert view["camera"]["estimated"] == ["distance", "height"]
        assert view["iou"] > 0.985
        assert view["mean_outline_distance_cm"] < 0.15
        for level in view["levels"]:
            assert level["photo_cm"] == pytest.approx(level["avatar_cm"], abs=0.25), level
        assert picture(view["overlay_png"]).height > 900
        names = [level["measurement"] for level in view["levels"]]
        assert len(names) >= 7
        assert "waist_girth" in names
        assert not {*names} & {*view["unseen"]}


def test_it_is_seen_by_the_photos_camera_and_from_either_side(client):
    camera = {"distance": 1.8, "height": 1.4}
    profile = outline(client, "profile", camera=camera, facing="left")
    usual = {"distance": 3.0, "height": 0.9}
    right, wrong, found = (
        send(client, PERSON | told, profile=profile).json["profile"]
        for told in ({"camera": camera}, {"camera": usual}, {})
    )
    assert right["camera"] == camera | {"estimated": []}
    assert right["iou"] > 0.985
    assert right["iou"] > wrong["iou"] + 0.01
    # What is not told is estimated, mostly how steeply the camera looks at the feet.
    assert found["iou"] > wrong["iou"] + 0.01
    half = send(client, PERSON | {"camera": {"distance": 1.8}}, profile=profile).json["profile"]
    assert half["camera"]["estimated"] == ["height"]
    assert half["camera"]["height"] == pytest.approx(1.4, abs=0.1)


def test_a_jpeg_and_a_plain_field_are_read_too(client):
    stream = io.BytesIO()
    Image.open(io.BytesIO(outline(client, "front"))).convert("L").save(stream, "JPEG")
    data = {"avatar": json.dumps(PERSON), "front": (io.BytesIO(stream.getvalue()), "front.jpg")}
    answer = client.post("/api/v1/comparisons", data=data, content_type="multipart/form-data")
    assert answer.json["front"]["iou"] > 0.98


def test_a_broader_waist_is_told_in_the_waists_level(client):
    stout = PERSON | {"measurements": PERSON["measurements"] | {"waist_girth": 97}}
    pictures = {side: outline(client, side, stout) for side in ("front", "profile")}
    for view in send(client, **pictures).json.values():
        levels = {level["measurement"]: level for level in view["levels"]}
        waist = levels["waist_girth"]
        assert waist["photo_cm"] - waist["avatar_cm"] > 1
        calf = levels["calf_girth"]
        assert calf["photo_cm"] == pytest.approx(calf["avatar_cm"], abs=0.5)


def test_outlines_refine_the_body_and_entered_values_stay(client, description):
    """Of a man with a deeper chest and thicker thighs than most of his height and waist."""
    true = PERSON["measurements"] | {"bust_girth": 111, "thigh_girth": 63}
    pictures = {
        side: outline(client, side, PERSON | {"measurements": true})
        for side in ("front", "profile")
    }
    answer = send(client, PERSON | {"refine": True}, **pictures).json
    schema = description["components"]["schemas"]["Comparison"]
    components = {"components": description["components"]}
    jsonschema.Draft202012Validator(schema | components).validate(answer)
    refinement = answer["refinement"]
    assert refinement["pull"] == 1
    assert 0.1 < refinement["moved_cm"]["mean"] < refinement["moved_cm"]["most"]
    rows = {row["name"]: row for row in refinement["measurements"]}
    for name, value in PERSON["measurements"].items():
        assert rows[name]["before"] == pytest.approx(value, abs=0.1)
        assert rows[name]["after"] == pytest.approx(value, abs=0.1)
    for name in ("bust_girth", "thigh_girth"):
        before, after = (abs(rows[name][when] - true[name]) for when in ("before", "after"))
        assert after < 0.8 * before, name
    for side in ("front", "profile"):
        before, after = answer[side], refinement[side]
        assert after["iou"] > before["iou"]
        assert after["mean_outline_distance_cm"] < 0.7 * before["mean_outline_distance_cm"]


def test_a_skirt_is_taken_for_clothes_and_told(client):
    pictures = {side: skirted(outline(client, side), 0.03) for side in ("front", "profile")}
    refinement = send(client, PERSON | {"refine": True}, **pictures).json["refinement"]
    told = {row["measurement"]: row["cloth_cm"] for row in refinement["clothes"]}
    assert told["hip_girth"] == pytest.approx(3, abs=1)
    assert not {"bust_girth", "calf_girth"} & {*told}
    assert {*told} <= {*refinement["limited"]}
    plain = {side: outline(client, side) for side in ("front", "profile")}
    refinement = send(client, PERSON | {"refine": True}, **plain).json["refinement"]
    assert refinement["clothes"] == []
    assert refinement["limited"] == []


def test_where_clothes_are_said_to_be_loose_outlines_only_bound(client):
    """Thick thighs follow the outline, unless it only says where they end at most."""
    true = PERSON["measurements"] | {"thigh_girth": 63}
    pictures = {
        side: outline(client, side, PERSON | {"measurements": true})
        for side in ("front", "profile")
    }
    thighs, limited = {}, {}
    for worn in ("tight", "loose_top", "loose_legs", "loose"):
        answer = send(client, PERSON | {"refine": True, "worn": worn}, **pictures).json
        rows = {row["name"]: row for row in answer["refinement"]["measurements"]}
        thigh = rows["thigh_girth"]
        thighs[worn] = thigh["after"] - thigh["before"]
        limited[worn] = answer["refinement"]["limited"]
    assert thighs["tight"] > 1
    assert max(thighs["loose_legs"], thighs["loose"]) < 0.7 * thighs["tight"]
    assert limited["tight"] == []
    assert {"bust_girth", "hip_girth"} <= {*limited["loose_top"]}
    assert "calf_girth" not in limited["loose_top"]
    assert {"waist_girth", "calf_girth"} <= {*limited["loose_legs"]}
    assert "bust_girth" not in limited["loose_legs"]
    assert {*limited["loose"]} == {*EDGE_LEVELS}
    refused = send(client, PERSON | {"refine": True, "worn": "a hat"}, **pictures)
    assert faults(refused) == {("worn", "invalid_choice")}


def skirted(content, off):
    """An outline that stands off by so many metres from mid-thigh to waist: a PNG file."""
    person = pixels(content) > 127
    rows = np.flatnonzero(person.any(axis=1))
    high = rows[-1] - rows[0]
    wide = ndimage.binary_dilation(person, iterations=round(off / 1.78 * high))
    above = 1 - (np.arange(len(person)) - rows[0]) / high
    worn = (above > 0.34) & (above < 0.62)
    return file_of(np.where(person | wide & worn[:, None], 255, 0).astype(np.uint8))


def test_clothes_are_told_where_no_view_shows_the_level(client):
    """From the front the thigh's tape runs where legs touch."""
    person = PERSON | {"measurements": PERSON["measurements"] | {"thigh_girth": 58}}
    front = skirted(outline(client, "front", person), 0.03)
    answer = send(client, person | {"refine": True}, front=front).json
    for view in (answer["front"], answer["refinement"]["front"]):
        assert "thigh_girth" not in {level["measurement"] for level in view["levels"]}
    told = [row["measurement"] for row in answer["refinement"]["clothes"]]
    assert told.index("hip_girth") < told.index("thigh_girth")


@pytest.mark.parametrize(("waist", "why"), [(97, "clothes"), (79, "tape")])
def test_each_level_has_its_usual_reasons(client, waist, why):
    other = PERSON | {"measurements": PERSON["measurements"] | {"waist_girth": waist}}
    for side in ("front", "profile"):
        view = send(client, **{side: outline(client, side, other)}).json[side]
        assert "waist_girth" in {level["measurement"] for level in view["levels"]}
        for level in view["levels"]:
            entered = level["measurement"] in PERSON["measurements"]
            assert ("tape" in level["reasons"]) == (entered and bool(level["reasons"]))
            assert ("estimate" in level["reasons"]) == (not entered and bool(level["reasons"]))
            apart = level["photo_cm"] - level["avatar_cm"]
            assert bool(level["reasons"]) == (abs(apart) >= 1), level
            # Clothes make nobody slimmer.
            assert apart > 0 or "clothes" not in level["reasons"]
            if level["measurement"] == "waist_girth":
                assert why in level["reasons"]


def test_nothing_is_refined_unless_it_is_asked_for(client):
    assert "refinement" not in send(client, front=outline(client, "front")).json
    refused = send(client, PERSON | {"refine": "yes"}, front=outline(client, "front"))
    assert faults(refused) == {("refine", "invalid_choice")}


def test_levels_are_in_centimetres_in_all_units(client):
    inches = {"stature": 70, "weight": 176, "waist_girth": 34.6, "hip_girth": 39.4}
    person = {"body": "male", "units": "imperial", "measurements": inches}
    front = send(client, person, front=outline(client, "front", person)).json["front"]
    waist = next(level for level in front["levels"] if level["measurement"] == "waist_girth")
    assert 25 < waist["avatar_cm"] < 36


def test_requests_that_lack_something_are_refused(client):
    front = outline(client, "front")
    assert faults(send(client)) == {("front", "required")}
    assert faults(send(client, None, front=front)) == {("avatar", "required")}
    assert faults(send(client, front=front, back=front)) == {("back", "unknown_member")}
    assert faults(send(client, {"body": "male"}, front=front)) == {("measurements", "required")}
    assert send(client, b"{", front=front).status_code == 400
    assert send(client, b" " * 70_000, front=front).status_code == 413
    assert client.post("/api/v1/comparisons", json=PERSON).status_code == 415


@pytest.mark.parametrize(
    ("spoil", "status", "code"),
    [
        (lambda front: b"<svg/>", 415, "wrong_type"),
        (lambda front: front[: len(front) // 2], 415, "unreadable"),
        (lambda front: front + bytes(5 * 2**20), 413, "too_large"),
        (lambda front: file_of(np.zeros((900, 500), np.uint8)), 422, "no_person"),
        (lambda front: file_of(pixels(front)[:900]), 422, "cut_off"),
        (lambda front: file_of(np.hstack([pixels(front)] * 2)), 422, "several_people"),
        (lambda front: file_of(pixels(front)[::5, ::5]), 422, "too_small"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_is_no_outline_is_refused_by_name(client, spoil, status, code):
    response = send(client, front=spoil(outline(client, "front")))
    assert response.status_code == response.json["status"] == status
    assert faults(response) == {("front", code)}
    assert response.mimetype == "application/problem+json"


def pixels(content):
    return np.asarray(Image.open(io.BytesIO(content)).convert("L"))


def file_of(array):
    stream = io.BytesIO()
    Image.fromarray(array).save(stream, "PNG")
    return stream.getvalue()


def test_no_picture_touches_the_disk(client, monkeypatch):
    """Werkzeug by itself writes files of more than half a megabyte to a temporary one."""
    stream = io.BytesIO()
    whole = Image.open(io.BytesIO(outline(client, "front"))).convert("RGB")
    whole.save(stream, "PNG", compress_level=0)
    assert len(stream.getvalue()) > 2 * 2**20

    def refuse(*args, **kwargs):
        raise AssertionError("a temporary file")

    for name in ("TemporaryFile", "NamedTemporaryFile", "mkstemp", "mkdtemp"):
        monkeypatch.setattr(tempfile, name, refuse)
    assert send(client, front=stream.getvalue()).json["front"]["iou"] > 0.985


def test_too_much_at_once_is_refused(client):
    content = bytes(ROOM)
    assert send(client, front=content, profile=content).status_code == 413
    chunked = client.post(
        "/api/v1/comparisons",
        input_stream=io.BytesIO(b"--x\r\n" + bytes(ROOM + 100)),
        content_type="multipart/form-data; boundary=x",
        environ_overrides={"wsgi.input_terminated": True},
    )
    assert chunked.status_code == 413
    assert send(client, path="/api/v1/avatars", front=bytes(100_000)).status_code in (413, 415)
