"""A photo's arms hang as they hang, and are no difference between the person and the body."""

import numpy as np
import pytest

from bench.outlines import FINE_ROWS, with_arms
from model.cameras import USUAL_CAMERA
from model.comparison import compare
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
