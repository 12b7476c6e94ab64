"""A photo's arms hang as they hang; what they tell is how far they reach."""

import numpy as np
import pytest

from bench.outlines import FINE_ROWS, with_arms, with_fingers
from model.cameras import USUAL_CAMERA, Camera, seen, seen_slopes
from model.comparison import compare, photo_edges
from model.masks import person
from model.silhouette import silhouette
from model.template_mesh import Body, load_template_mesh


@pytest.mark.parametrize(("lift", "swing"), [(-0.1, 0.04), (-0.2, 0.04), (-0.28, 0.08)])
def test_a_hand_that_stands_out_before_a_thigh_is_left_out(lift, swing):
    template = load_template_mesh()
    body = Body(template, template.vertices, "neutral")
    turned = with_arms(body, (lift, 0.0), (lift, swing))
    seen = silhouette(turned, "profile", camera=USUAL_CAMERA, facing="right", rows=FINE_ROWS)
    comparison = compare(person(np.pad(seen.cover, 60)), body, "profile", camera=USUAL_CAMERA)
    assert comparison.iou > 0.991


def hands_of(body, lift):
    """What a photo of a body tells of its hands, its arms lifted; and the lifted body."""
    lifted = with_arms(body, (lift, 0.0), (lift, 0.0))
    photo = silhouette(lifted, "front", camera=USUAL_CAMERA, rows=FINE_ROWS)
    mask = person(np.pad(photo.cover, 60))
    return photo_edges(mask, body, "front", USUAL_CAMERA, "right").hands, lifted


@pytest.mark.parametrize("lift", [-0.15, 0.0, 0.2])
def test_hands_end_where_the_photos_end(lift):
    template = load_template_mesh()
    hands, lifted = hands_of(Body(template, template.vertices, "neutral"), lift)
    assert set(hands) == {"left", "right"}
    flat = seen(lifted.vertices, "front", USUAL_CAMERA)
    for side, end in hands.items():
        own = np.unique(template.faces[template.faces_of(f"hand_{side}")])
        assert np.linalg.norm(flat[own] - end, axis=1).min() < 0.003
        near, weights = template.landmark_weights(f"acromion_{side}")
        shoulder = weights @ flat[near]
        furthest = np.linalg.norm(flat[own] - shoulder, axis=1).max()
        assert np.linalg.norm(end - shoulder) == pytest.approx(furthest, abs=0.003)


def test_a_hand_before_a_thigh_tells_nothing():
    template = load_template_mesh()
    hands, _ = hands_of(Body(template, template.vertices, "neutral"), -0.55)
    assert hands == {}


def test_fingers_are_bent_by_a_share_and_nothing_else():
    template = load_template_mesh()
    body = Body(template, template.vertices, "neutral")
    bent = with_fingers(body, 0.1, 0.0)
    moved = np.flatnonzero((bent.vertices != body.vertices).any(axis=1))
    own = np.unique(template.faces[template.faces_of("hand_left")])
    assert set(moved) <= set(own)
    elbow, wrist = (
        template.landmark_points(body.vertices, f"{name}_left") for name in ("radiale", "stylion")
    )
    along = (wrist - elbow) / np.linalg.norm(wrist - elbow)
    before, after = (((one.vertices[own] - wrist) @ along).max() for one in (body, bent))
    assert after == pytest.approx(0.9 * before)


@pytest.mark.parametrize(("side", "facing"), [("front", "right"), ("profile", "left")])
def test_derivatives_of_what_is_seen_are_difference_quotients(side, facing):
    random = np.random.default_rng(4)
    points, ways = random.normal(0, 0.5, (2, 7, 3))
    camera = Camera(distance=2.5, height=1.1)
    step = 1e-5
    forth, back = (seen(points + sign * step * ways, side, camera, facing) for sign in (1, -1))
    slopes = seen_slopes(points, side, camera, facing)
    for column in (0, 1):
        expected = ((forth - back) / (2 * step))[:, column]
        assert (slopes[column] * ways).sum(axis=1) == pytest.approx(expected, abs=1e-7)
