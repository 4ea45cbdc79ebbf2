"""`workbench lidar-trial`."""

import csv

import pytest

from workbench.commands import lidar_trial
from workbench.commands.lidar_trial import trial_result

PNG = b"\x89PNG"
SHORT = """\
title: a short trial
duration: 2.0
world: {world}
script: [{{at: 0.0, set: {{max_speed: 2.0}}}}, {{at: 0.25, go_to: [4.0, 0.0, 1.5]}}]
"""
WORLD = """\
obstacles:
  - {name: crate, shape: {box: [1.0, 1.0, 2.0]}, position: [6.0, 2.0, 1.0]}
  - {name: ball, shape: {sphere: 1.0}, position: [32.5, 0.0, 1.5]}
  - {name: star, shape: {sphere: 1.0}, position: [0.0, 0.0, 25.0]}
moving:
  - {name: cart, shape: {box: [1.0, 1.0, 1.0]}, path: [[0, 8, -4, 0.5], [3, 8, -1, 0.5]]}
"""


@pytest.fixture(scope="module")
def scenario(tmp_path_factory):
    folder = tmp_path_factory.mktemp("trial")
    (folder / "yard.yaml").write_text(WORLD)
    path = folder / "short.yaml"
    path.write_text(SHORT.format(world=folder / "yard.yaml"))
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("lidar") / "out"


@pytest.fixture(scope="module")
def said(run, scenario, folder):
    options = ("--output", folder, "--html", folder / "trial.html", "--json")
    return run("lidar-trial", "--scenario", scenario, *options)


def test_it_meets_what_is_demanded_and_says_so(said):
    assert said.code == 0, said.err
    found = said.json
    assert found["met"] is True
    assert {demand["met"] for demand in found["demands"]} == {True}
    assert found["accuracy"]["returns"] > 10_000
    assert abs(found["accuracy"]["bias"]) < 0.001
    assert found["accuracy"]["rmse"] == pytest.approx(0.01, rel=0.03)
    assert found["accuracy"]["without_noise"]["maximum"] < 1e-6
    assert (found["accuracy"]["missed"], found["accuracy"]["false"]) == (0, 0)
    assert found["response"]["share_on_time"] == 1.0
    assert found["response"]["maximum_age"] <= 1 / 128
    assert found["response"]["rate"] == pytest.approx(10.0)
    assert found["clearance"]["obstacle"] == "crate"


def test_each_obstacle_is_found_when_it_comes_into_range_or_never(said):
    found = {each["obstacle"]: each for each in said.json["detection"]}
    assert set(found) == {"crate", "ball", "star", "cart", "ground"}
    assert found["crate"]["from_start"] and found["cart"]["from_start"]
    ball = found["ball"]
    assert 0.5 < ball["entered"] < ball["returned"] < ball["entered"] + 0.11
    assert 29.0 < ball["returned_distance"] < ball["entered_distance"] < 30.0
    assert found["star"]["entered"] is None and found["star"]["delay"] is None


def test_log_picture_and_page_are_written_and_nothing_else(said, folder):
    names = {"lidar-trial.csv", "lidar-trial.png", "trial.html"}
    assert {path.name for path in folder.iterdir()} == names
    assert set(said.json["files"]) == {str(path) for path in folder.iterdir()}
    assert (folder / "lidar-trial.png").read_bytes()[:4] == PNG
    assert "<html" in (folder / "trial.html").read_text()
    rows = list(csv.reader((folder / "lidar-trial.csv").read_text().splitlines()))
    assert float(rows[2][0]) == 1 / 1024  # between which scans are interpolated


@pytest.mark.slow
def test_a_seed_changes_the_noise_and_nothing_else(run, scenario, said, out):
    options = ("--output", out, "--no-plots", "--json", "--seed", "5")
    other = run("lidar-trial", "--scenario", scenario, *options).json
    assert other["accuracy"]["bias"] != said.json["accuracy"]["bias"]
    assert other["accuracy"]["without_noise"] == said.json["accuracy"]["without_noise"]
    assert other["detection"] == said.json["detection"]
    assert {path.name for path in out.iterdir()} == {"lidar-trial.csv"}


def test_the_table_names_what_is_not_as_demanded_and_returns_1(
    run, scenario, write, out, monkeypatch
):
    """A frozen lidar says where things were."""
    results = []
    monkeypatch.setattr(
        lidar_trial,
        "trial_result",
        lambda *args: results.append(trial_result(*args)) or results[-1],
    )
    text = scenario.read_text().replace("set: {", "set: {lidar_fault: 1, ")
    options = ("--output", out, "--no-plots")
    said = run("lidar-trial", "--scenario", write("frozen.yaml", text), *options)
    assert said.code == 1, said.err
    assert "requirements not met: " in said.err
    assert results[0]["met"] is False  # of --json
    assert "accuracy: error without noise is " in said.err
    assert "mm (at most 1.000 mm)" in said.err
    lines = {line.partition("  ")[0]: line for line in said.out.splitlines()}
    assert lines["accuracy: error without noise"].endswith(" not ok")
    assert lines["response: late scans"].endswith(" ok")
    first, *lines = said.out.splitlines()
    assert first.startswith("dh_drone, sensor 'lidar': 16 layers of 360 rays, 0.1 .. 30 m")
    for head in ("accuracy: ", "speed of detection: ", "responsiveness: ", "demanded"):
        assert any(line.startswith(head) for line in lines)
    assert any(line.split()[:2] == ["star", "never"] for line in lines)
    assert any(line.startswith("bound: ") and line.endswith(" 107.8 ms") for line in lines)
    assert any("within 3." in line and "of crate" in line for line in lines)


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["--scenario", "lidar-trail"], "lidar-trial"),
        (["--seed", "-1"], "0 or more"),
        (["--world", "gone.yaml"], "gone.yaml"),
        (["--arg", "lidar:=false"], "no lidar"),
    ],
)
def test_bad_input_is_a_sentence_and_leaves_nothing(refused, out, options, word):
    assert word in refused("lidar-trial", "--output", out, *options)
    assert not out.parent.exists()


@pytest.mark.parametrize(
    ("more", "options", "word"),
    [
        ("duration: 0.0005", (), "no scan was delivered in the flight"),
        ("duration: 0.005", (), "no scan was delivered in the flight"),
        ("duration: 0.5\nsensors: {latency: {lidar: 2}}", (), "fly longer than 2.11 s"),
        ("duration: 0.5", ("--set", "lidar_fault=3"), "that works"),
    ],
)
def test_a_flight_without_scans_is_a_sentence(refused, write, out, more, options, word):
    path = write("brief.yaml", f"{more}\nworld: room\n")
    said = refused("lidar-trial", "--scenario", path, "--output", out, *options)
    assert word in said
    assert not list(out.parent.glob("out/*"))


def test_a_wall_that_is_hit_is_touched(run, write, out):
    script = "script: [{at: 0, velocity: [2, 0, 0]}]"
    start = "start: {position: [4, 0, 1.5]}"
    path = write("wall.yaml", f"duration: 1.0\nworld: room\n{start}\n{script}\n")
    said = run("lidar-trial", "--scenario", path, "--output", out, "--no-plots")
    assert said.code == 1
    assert "the flight touched wall_east: it came within" in said.out
