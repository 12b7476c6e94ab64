"""The shopper's file, measured by other means: trimesh reads it, Qhull ties the tapes."""

import io

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull, cKDTree

from model.tapes import BODY_DENSITY

MILLIMETRE = 1e-3

PEOPLE = [
    {"body": "female", "measurements": {"stature": 168, "weight": 68, "bust_girth": 92}},
    {"body": "male", "measurements": {"stature": 182, "hip_girth": 104, "waist_girth": 96}},
    {"body": "neutral", "measurements": {"stature": 160, "weight": 95}},
]


@pytest.fixture(scope="module", params=PEOPLE, ids=lambda person: person["body"])
def avatar(site, request):
    """The file's mesh, and what the API says it measures."""
    client = site.test_client()
    response = client.post("/api/v1/avatars.glb", json=request.param)
    scene = trimesh.load(io.BytesIO(response.data), file_type="glb", process=False)
    rows = client.post("/api/v1/avatars", json=request.param).json["measurements"]
    return scene.to_mesh(), {row["name"]: row for row in rows}


def test_all_41_measurements_come_with_their_paths(avatar):
    _, rows = avatar
    assert len(rows) == 41
    assert [name for name, row in rows.items() if not row["path"]] == ["weight"]


def test_girths_are_the_hulls_of_the_files_sections(avatar):
    mesh, rows = avatar
    for name, row in rows.items():
        if row["kind"] != "girth" or name == "armscye_girth":
            continue
        path = np.array(row["path"])
        centre = path.mean(axis=0)
        across, along, normal = np.linalg.svd(path - centre)[2]
        section = mesh.section(plane_origin=centre, plane_normal=normal)
        # Of the curves that the plane cuts, those that the tape touches: not the other limbs.
        curves = [np.asarray(curve) for curve in section.discrete]
        touched = [curve for curve in curves if _near(curve, path)]
        points = np.concatenate(touched)
        flat = (points - centre) @ np.stack([across, along], axis=1)
        assert 100 * ConvexHull(flat).area == pytest.approx(row["taken"], abs=0.1), name


def test_lengths_run_over_the_files_skin(avatar):
    mesh, rows = avatar
    for name, row in rows.items():
        loop = name == "armscye_girth"  # runs into the armpit, where no plane's hull goes
        if row["kind"] == "length" or loop:
            path = np.array(row["path"])
            path = np.concatenate([path, path[:1]]) if loop else path
            _, near = cKDTree(mesh.vertices).query(path, k=12)
            skin = mesh.submesh([np.isin(mesh.faces, near).any(axis=1)], append=True)
            _, away, _ = trimesh.proximity.closest_point_naive(skin, path)
            assert away.max() < MILLIMETRE / 10, name
            steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
            assert 100 * steps.sum() == pytest.approx(row["taken"], abs=0.1), name


def test_heights_and_weight_are_the_files(avatar):
    mesh, rows = avatar
    assert 100 * mesh.extents[1] == pytest.approx(rows["stature"]["taken"], abs=0.1)
    for name, row in rows.items():
        if row["kind"] == "height":
            top, bottom = np.array(row["path"])
            assert 100 * (top - bottom)[1] == pytest.approx(row["taken"], abs=0.1), name
    assert mesh.volume * BODY_DENSITY == pytest.approx(rows["weight"]["taken"], abs=0.1)
    for floor in ("stature", "waist_height", "foot_height"):
        assert rows[floor]["path"][1][1] == pytest.approx(mesh.bounds[0][1], abs=MILLIMETRE)


def _near(curve, path):
    """Whether any corner of a tape lies on a curve."""
    start, step = curve[:-1], np.diff(curve, axis=0)
    for point in path:
        share = np.einsum("ni,ni->n", point - start, step) / np.einsum("ni,ni->n", step, step)
        nearest = start + np.clip(share, 0, 1)[:, None] * step
        if np.linalg.norm(nearest - point, axis=1).min() < MILLIMETRE / 10:
            return True
    return False
