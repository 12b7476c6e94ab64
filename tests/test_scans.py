"""The command on a set that is made here, whose landmarks and measurements are known."""

import csv
import json
import os
import subprocess
import sys
import time
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from distributed import Client
from made_scans import write_set

from model.anthropometry import TAKEN, TAPES, measure, measure_batch
from model.estimators import load_estimators
from model.gltf import to_glb
from model.measurements import BODY_KINDS, MEASUREMENTS, MeasurementSet
from model.rendering import render_png
from model.shape_basis import load_shape_basis
from model.template_mesh import DATA, load_template_mesh
from model.training.__main__ import main
from model.training.mesh_repair import repair
from model.training.population import load_population
from model.training.scans_anatomy import read_landmarks
from model.training.scans_files import ScanError, read_scan
from model.training.survey import SEXES, SURVEY_TAPES
from webapp import environment

ROOT = Path(__file__).resolve().parent.parent

PER_SEX = 6

LARGEST_INDEX = 40
"""Of body mass, in kg/m²: what the survey's people have."""


@pytest.fixture(scope="module")
def bodies():
    """Bodies of the population, women first, as far from symmetric as people are: (n, V, 3)."""
    population, basis, template = load_population(), load_shape_basis(), load_template_mesh()
    random = np.random.default_rng(5)
    columns = [population.taken[:, list(SURVEY_TAPES).index(n)] for n in ("weightkg", "stature")]
    usual = columns[0] / columns[1] ** 2 < LARGEST_INDEX
    rows = [
        random.permutation(np.flatnonzero(population.of(sex) & usual))[:PER_SEX] for sex in SEXES
    ]
    bodies = basis.vertices(population.coefficients[np.concatenate(rows)])
    # Spines that bend sideways, a little to the left on average.
    sway = random.normal(0.003, 0.006, (len(bodies), 1))
    bodies[..., 0] += sway * np.sin(np.pi * bodies[..., 1] / template.vertices[:, 1].max())
    return bodies


@pytest.fixture(scope="module")
def folder(tmp_path_factory, bodies):
    folder = tmp_path_factory.mktemp("scans")
    write_set(folder, bodies, np.repeat(SEXES, PER_SEX))
    return folder


def run(monkeypatch, *arguments):
    monkeypatch.setattr(sys, "argv", ["scans", "scans", *map(str, arguments)])
    main()


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory):
    """The address of a Dask scheduler with two workers, all processes of their own."""
    place = tmp_path_factory.mktemp("cluster")
    told = place / "scheduler.json"
    command = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port=0", "--no-dashboard"]
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", "--nthreads=1", "--no-nanny"]
    with ExitStack() as running, (place / "log").open("w") as log:
        for start in (command, worker, worker):
            process = subprocess.Popen(
                [*start, f"--scheduler-file={told}"],
                cwd=place,
                # Workers have the project, and nothing else of what is here.
                env={**os.environ, "PYTHONPATH": str(ROOT)},
                stdout=log,
                stderr=log,
            )
            running.callback(process.wait)
            running.callback(process.terminate)
            for _ in range(600):
                if told.exists():
                    break
                time.sleep(0.1)
        address = json.loads(told.read_text())["address"]
        with Client(address, timeout=60) as client:
            client.wait_for_workers(2, timeout=60)
        yield address


@pytest.fixture(scope="module")
def output(folder, scheduler, tmp_path_factory):
    """What the command made of the set, with two workers of a Dask cluster."""
    output = tmp_path_factory.mktemp("output")
    with pytest.MonkeyPatch.context() as monkeypatch:
        run(monkeypatch, folder, "--output", output, "--dask", scheduler)
    return output


def table(output):
    """The written measurements, SI: (n, M)."""
    with (output / "measurements.csv").open(newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0][2:] == [f"{name}_{MEASUREMENTS[name].unit}" for name in TAKEN]
    return np.array([[float(value or "nan") for value in row[2:]] for row in rows[1:]])


def said(output):
    return (output / "report.txt").read_text()


# ---------------------------------------------------------------- what it must show


def test_it_says_what_it_found(output):
    text = said(output)
    assert "6 female and 6 male scans; work on 2 threads of the Dask cluster at tcp://" in text
    assert "mesh: 12500 vertices and 25002 faces, after repair 12503 and 25002" in text
    assert "edges of more than two faces, parted: 3 (edge" in text
    assert "unit m: statures 1." in text
    assert "up is +z, people face -y" in text


def test_landmarks_are_found_within_10_mm_on_every_scan(output, folder, bodies):
    ours, template = load_template_mesh(), load_template_mesh(output)
    files = sorted(folder.rglob("*.obj"))
    assert len(files) == len(bodies)
    scans = [read_scan(file.name, file.read_bytes()) for file in files]
    mended = repair(scans[0].faces, np.mean([scan.vertices for scan in scans], axis=0))
    for file, read, body in zip(files, scans, bodies, strict=True):
        scan = mended.apply(read.vertices)
        for name in ours.landmarks:
            x, y, z = template.landmark_points(scan, name)
            truth = ours.landmark_points(body, name) - ours.landmark_points(body, "crotch")
            assert np.linalg.norm([x, z, -y] - truth) < 0.010, (file.name, name)


def test_every_measurement_of_every_scan_is_within_2_mm(output, bodies):
    misses = table(output) - measure_batch(load_template_mesh(), bodies)
    lengths = [i for i, name in enumerate(TAKEN) if name != "weight"]
    worst = {TAKEN[i]: float(np.abs(misses[:, i]).max() * 1e3) for i in lengths}
    assert {name: miss for name, miss in worst.items() if not miss < 2} == {}
    assert np.abs(misses[:, TAKEN.index("weight")]).max() < 0.05


def test_parts_are_where_they_are_on_ours(output):
    ours, template = load_template_mesh(), load_template_mesh(output)
    assert template.part_names == ours.part_names
    for part in ours.part_names:
        middle, truth = (
            mesh.vertices[np.unique(mesh.faces[mesh.faces_of(part)])].mean(axis=0)
            for mesh in (template, ours)
        )
        assert np.linalg.norm((middle - truth)[:2]) < 0.06, part
    for mark in template.landmarks.values():
        assert sum(mark.weights) == pytest.approx(1)
        assert min(mark.weights) >= 0


def test_the_basis_holds_every_scan(output, bodies):
    template, basis = load_template_mesh(output), load_shape_basis(output)
    assert (basis.mirror == np.arange(len(template.vertices))).all()
    mean = basis.vertices(np.zeros((1, len(basis.directions))))[0]
    assert np.abs(mean - template.vertices).max() < 1e-3
    estimator = load_estimators(output)["neutral"]
    values = table(output)
    again = measure_batch(
        template, basis.vertices(estimator.linear.predict(values[:, : len(estimator.names)]))
    )
    # More measurements than scans: each scan is what it measures.
    assert np.abs(again / values - 1).max() < 0.01


def test_the_site_starts_on_it(output, make_site):
    site = make_site(FITTING_ROOM_DATA=output)
    client = site.test_client()
    asked = {"stature": 165, "bust_girth": 95}
    for kind in BODY_KINDS:
        answer = client.post("/api/v1/avatars", json={"body": kind, "measurements": asked})
        assert answer.status_code == 200, answer.text
        rows = {row["name"]: row for row in answer.json["measurements"]}
        assert set(rows) == set(TAKEN)
        assert answer.json["estimator"]["trained_on"].startswith(
            "registered scans: 6 female, 6 male; "
        )
    answer = client.post("/api/v1/avatars.glb", json={"measurements": asked, "body": "female"})
    assert answer.data[:4] == b"glTF"


def test_the_environment_says_where_the_estimators_are():
    assert environment({"FITTING_ROOM_DATA": "build/scans"})["FITTING_ROOM_DATA"] == "build/scans"
    for unset in ({}, {"FITTING_ROOM_DATA": ""}):
        assert environment(unset)["FITTING_ROOM_DATA"] == DATA


def test_a_folder_without_estimators_is_named(make_site, tmp_path):
    with pytest.raises(FileNotFoundError, match="SHA256SUMS"):
        make_site(FITTING_ROOM_DATA=tmp_path)


def test_a_body_of_scans_is_drawn(output):
    estimator = load_estimators(output)["female"]
    body = estimator.estimate(MeasurementSet({"stature": 1.65}))
    assert set(measure(body).values) == set(TAPES)
    assert len(to_glb(body)) > 300_000
    assert render_png(body, "profile", size=(60, 120), silhouette=True)[:4] == b"\x89PNG"


# ---------------------------------------------------------------- again


def test_again_it_goes_on_from_what_was_done(output, folder, capsys, monkeypatch):
    before, text = table(output), (output / "landmarks.json").read_text()
    run(monkeypatch, folder, "--output", output, "--jobs", "1")
    told = capsys.readouterr().out
    assert "1 of 1 parts were read before" in told
    assert "laying our template" not in told
    assert "was moved" not in told
    assert (output / "landmarks.json").read_text() == text
    assert np.array_equal(table(output), before)


def test_a_landmark_is_corrected_by_hand(output, folder, monkeypatch, capsys):
    path = output / "landmarks.json"
    kept = path.read_text()
    content = json.loads(kept)
    point = content["landmarks"]["omphalion"]["point"]
    content["landmarks"]["omphalion"]["point"] = [point[0], point[1] - 0.02, point[2] + 0.03]
    path.write_text(json.dumps(content))
    before = load_template_mesh(output)
    run(monkeypatch, folder, "--output", output, "--jobs", "1")
    told = capsys.readouterr().out
    load_template_mesh.cache_clear()
    after = load_template_mesh(output)
    assert "omphalion was moved by 36.1 mm" in told
    moved = after.landmark_points(after.vertices, "omphalion")
    assert moved[1] == pytest.approx(point[1] - 0.02, abs=0.01)
    assert np.array_equal(after.landmarks["crotch"].weights, before.landmarks["crotch"].weights)
    path.write_text(kept)


def test_a_landmark_that_the_file_lacks_is_left_open(output):
    template = load_template_mesh(output)
    content = json.loads((output / "landmarks.json").read_text())
    del content["landmarks"]["menton"]
    path = output / "fewer.json"
    path.write_text(json.dumps(content))
    read = read_landmarks(path, template.vertices, template.faces, template.landmarks)
    assert template.landmarks.keys() - read.landmarks.keys() == {"menton"}
    assert read.moved == {}


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"crotch"', '"crutch"', ": no landmark is called 'crutch'"),
        ('  "landmarks"', '  landmarks"', ", line 4: no JSON"),
        ('"mesh": "', '"mesh": "0', " belongs to scans of another mesh"),
        ('"face": ', '"face": 99', ": crotch lies on face 99[0-9]+, there are 25002"),
        ('"point": [', '"point": [1.0, ', ": not as this command writes it"),
        ('"point": [', '"point": [NaN, ', ": not as this command writes it"),
        ('"point": [', '"point": [0.3, 0.2, 0.4], "was": [', " mm from the skin; at most 50"),
    ],
)
def test_landmarks_that_cannot_be_are_refused(output, old, new, told):
    template = load_template_mesh(output)
    path = output / "wrong.json"
    path.write_text((output / "landmarks.json").read_text().replace(old, new, 1))
    with pytest.raises(ScanError, match=rf"wrong.json.*{told}"):
        read_landmarks(path, template.vertices, template.faces, template.landmarks)
