"""Cameras found from outlines, of known bodies by planted cameras."""

import numpy as np
import pytest

from bench.outlines import roughened
from model.camera_estimate import estimate_camera
from model.cameras import USUAL_CAMERA, Camera
from model.estimators import load_estimators
from model.masks import person
from model.silhouette import silhouette
from model.training.population import load_population

PLANTED = [Camera(2.2, 1.3), Camera(3.8, 0.7), Camera(2.5, 0.6)]


@pytest.fixture(scope="module")
def body():
    return load_estimators()["neutral"].body(load_population().coefficients[7])


def photos(body, camera, *sides):
    random = np.random.default_rng(0)
    return {
        side: person(
            roughened(silhouette(body, side, camera=camera, facing="left"), 0.01, 1.7, random)
        )
        for side in sides
    }


@pytest.mark.parametrize("planted", PLANTED, ids=str)
def test_how_steeply_the_camera_looks_is_found(body, planted):
    found = estimate_camera(photos(body, planted, "front", "profile"), body)
    steepness = planted.height / planted.distance
    assert found.height / found.distance == pytest.approx(steepness, abs=0.04)
    assert abs(found.height - planted.height) < abs(USUAL_CAMERA.height - planted.height)


def test_what_is_told_is_kept_and_leads_to_the_rest(body):
    planted = PLANTED[0]
    masks = photos(body, planted, "profile")
    by_distance = estimate_camera(masks, body, distance=planted.distance)
    assert by_distance.distance == planted.distance
    assert by_distance.height == pytest.approx(planted.height, abs=0.1)
    by_height = estimate_camera(masks, body, height=planted.height)
    assert by_height.height == planted.height
    assert by_height.distance == pytest.approx(planted.distance, abs=0.25)


def test_a_usual_photo_is_taken_by_the_usual_camera(body):
    found = estimate_camera(photos(body, USUAL_CAMERA, "front"), body)
    assert found.distance == pytest.approx(USUAL_CAMERA.distance, abs=0.2)
    assert found.height == pytest.approx(USUAL_CAMERA.height, abs=0.1)
