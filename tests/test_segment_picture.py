import io

import numpy as np
from PIL import Image

from model.template_mesh import Body, load_template_mesh
from model.training.segment_picture import SEGMENTS, segment_picture, segment_words


def test_every_part_of_the_template_is_of_one_segment():
    template = load_template_mesh()
    covered = sum(template.faces_of(name).astype(int) for name in SEGMENTS)
    assert (covered == 1).all()


def test_the_picture_shows_every_segment_in_its_colour():
    template = load_template_mesh()
    data = segment_picture(Body(template, template.vertices, "neutral"))
    pixels = np.asarray(Image.open(io.BytesIO(data)).convert("RGB")).astype(float)
    shades = pixels / pixels.sum(axis=2, keepdims=True)
    for name, (_, colour) in SEGMENTS.items():
        shade = np.array(colour) / sum(colour)
        assert (np.abs(shades - shade).max(axis=2) < 0.02).sum() > 300, name


def test_the_words_name_every_segment():
    words = segment_words()
    assert all(name in words for name, _ in SEGMENTS.values())
