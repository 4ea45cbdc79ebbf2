"""`workbench sweep`."""

import csv
import os
import signal
import sys

import pytest

from workbench.design.step_response import fly_step
from workbench.design.sweep import compiled_flights, kept_flights
from workbench.design.sweep.kept_flights import KeptFlights
from workbench.design.sweep.sweep import sweep

pytestmark = pytest.mark.usefixtures("pictures_here")
PNG = b"\x89PNG"
SHORT = ("sweep", "kp_velocity_z=2..6:3")


@pytest.mark.slow
def test_json_is_the_table_of_the_python_call(run, out):
    said = run(*SHORT, "--output", out, "--json").json
    table = sweep(["kp_velocity_z=2..6:3"], axis="z", amplitude=1.0)
    assert (said["flown"], said["planned"], said["diverged"]) == (3, 3, 0)
    assert list(said["columns"]) == list(table.names)
    assert [row["overshoot"] for row in said["candidates"]] == table.column("overshoot").tolist()
    assert [row["kp_velocity_z"] for row in said["candidates"]] == [2.0, 4.0, 6.0]
    assert said["candidates"][0]["diverged_at"] is None
    assert said["present"]["kp_velocity_z"] == 4.4
    best = said["best"]
    assert best["row"] == table.ranking("settling_time")[0]
    full = fly_step("z", 1.0, settings={"kp_velocity_z": best["kp_velocity_z"]})
    assert best["on_full_diagram"]["rise_time"] == full.metrics.rise_time


def test_table_and_picture_are_written_and_nothing_else(run, out):
    said = run(*SHORT, "--output", out)
    assert said.code == 0
    assert {path.name for path in out.iterdir()} == {"sweep-z.csv", "sweep-z.png"}
    assert (out / "sweep-z.png").read_bytes()[:4] == PNG
    rows = list(csv.reader((out / "sweep-z.csv").read_text().splitlines()))
    assert rows[0][0] == "kp_velocity_z [1/s]"
    assert [row[0] for row in rows[1:]] == ["2.0", "4.0", "6.0"]
    head, *lines = said.out.splitlines()
    assert head == "3 candidates, z step of 1 m/s, dh_drone with its own gains: 0 diverged"
    assert lines[0].split() == ["present", "best", "full", "diagram"]
    assert any(line.startswith("settling_time *") for line in lines)


def test_settings_and_variations_hold_for_all_and_the_table_may_stand_elsewhere(run, out, tmp_path):
    table = tmp_path / "there" / "climb.csv"
    words = (*SHORT, "--output", out, "--no-plots", "--json", "--table", table)
    said = run(*words, "--set", "kd_velocity_z=0.3", "--vary", "mass=1.2").json
    plain = run(*words, "--margins").json
    best, rows = plain["best"], plain["candidates"]
    margin = best["phase_margin_deg"]
    assert plain["columns"]["phase_margin_deg"] == "deg" and 60.0 < margin < 120.0
    assert rows[best["row"]]["phase_margin_deg"] == margin
    assert plain["present"]["phase_margin_deg"] == pytest.approx(margin, abs=30.0)
    assert said["set"] == {"kd_velocity_z": 0.3}
    assert said["variation"]["mass"] == 1.2
    assert said["present"]["peak_rotor_use"] > plain["present"]["peak_rotor_use"]
    assert table.is_file()
    assert not out.exists()


@pytest.mark.slow
def test_margins_are_of_the_axis_or_of_a_loop(run, out):
    words = (
        "sweep",
        "kp_velocity_x=2..6:2",
        "--axis",
        "x",
        "--no-plots",
        "--json",
        "--output",
        out,
    )
    own = run(*words, "--margins", "--metric", "phase_margin").json
    named = run(*words, "--margins", "velocity_x").json
    other = run(*words, "--margins", "pitch").json
    key = "delay_margin"
    assert own["present"][key] == named["present"][key] != other["present"][key]
    assert own["best"]["kp_velocity_x"] == 2.0


def test_what_diverges_is_a_row(run, out):
    said = run("sweep", "kp_pitch=200..2400:2", "--axis", "x", "--output", out, "--json")
    assert said.code == 0
    first, second = said.json["candidates"]
    assert first["diverged_at"] is None
    assert 0.0 <= second["diverged_at"] <= 5.0
    assert second["rise_time"] is None
    assert said.json["diverged"] == 1


def test_a_sweep_in_which_all_diverge_is_said_so(run, out):
    said = run("sweep", "kp_pitch=2300..2400:2", "--axis", "x", "--output", out)
    assert said.code == 0
    assert "2 diverged" in said.out
    assert "no candidate flies to the end" in said.out
    assert (
        run("sweep", "kp_pitch=2300..2400:2", "--axis", "x", "--output", out, "--json").json["best"]
        is None
    )


@pytest.mark.parametrize(
    "ranges", [["kp_velocity_z=2..6:2"], pytest.param([], marks=pytest.mark.slow)]
)
def test_no_drone_is_chosen_as_the_best(run, out, ranges):
    """The lightest drone climbs fastest, which says nothing about gains."""
    words = ("sweep", *ranges, "vary.mass=0.9..1.1:2", "--duration", "3", "--output", out)
    said = run(*words)
    assert said.code == 0
    assert "no best is chosen: vary.mass is of the drone, not of its gains" in said.out
    assert (out / "sweep-z.png").is_file()
    found = run(*words, "--json").json
    assert found["best"] is None
    assert found["no_best"].startswith("no best is chosen: vary.mass")
    assert len(found["candidates"]) == 2 ** (1 + len(ranges))
    gains = run("sweep", "kp_velocity_z=2..6:2", "--duration", "3", "--output", out, "--json")
    assert gains.json["no_best"] == ""


@pytest.mark.parametrize(
    "number",
    [
        signal.SIGINT,
        pytest.param(signal.SIGTERM, marks=pytest.mark.slow),
        pytest.param(signal.SIGHUP, marks=pytest.mark.slow),
    ],
)
def test_a_sweep_that_is_ended_goes_on_from_there(run, out, tmp_path, monkeypatch, number):
    monkeypatch.setattr(kept_flights, "FIRST_WRITE_DELAY_S", 0.0)
    monkeypatch.setattr(compiled_flights, "CANDIDATES_PER_CHUNK", 4)
    keep, kept = KeptFlights.keep, []

    def keep_and_end(self, *flights):
        keep(self, *flights)
        kept.append(flights)
        if len(kept) == 2:
            os.kill(os.getpid(), number)

    words = ("sweep", "kp_velocity_z=2..6:20", "--duration", "0.3", "--output")
    with monkeypatch.context() as patched:
        patched.setattr(KeptFlights, "keep", keep_and_end)
        said = run(*words, out)
    assert said.code == 128 + number
    rows = (out / "sweep-z.csv").read_text().splitlines()
    assert 1 < len(rows) < 20
    assert f"interrupted after {len(rows) - 1} of 20 candidates; those are in the" in said.err
    assert (out / "sweep-z.png").is_file()
    said = run(*words, out)
    assert said.code == 0
    assert f"{len(rows)} of 21 flights are kept from the sweep that was ended" in said.err
    assert {path.name for path in out.iterdir()} == {"sweep-z.csv", "sweep-z.png"}
    run(*words, tmp_path / "whole")
    whole = (tmp_path / "whole" / "sweep-z.csv").read_bytes()
    assert (out / "sweep-z.csv").read_bytes() == whole


def test_bad_input_is_a_sentence_and_leaves_nothing(case, refused, out):
    for options, word in [
        ([], "required: NAME=LOW..HIGH"),
        (["kp_roll"], "is not a range"),
        (["kp_rol=1..2"], "did you mean 'kp_roll'"),
        (["kp_roll=1..9999"], "0 .. 2500"),
        (["kp_roll=1..2", "kp_roll=1..3"], "swept twice"),
        (["kp_roll=1..2", "--metric", "overshot"], "did you mean 'overshoot'"),
        (["kp_roll=1..2", "--metric", "gain_margin"], "add --margins"),
        (["kp_roll=1..2", "--margins", "rol"], "did you mean 'roll'"),
        (["kp_roll=1..2", "--method", "gird"], "did you mean 'grid'"),
        (["kp_roll=1..2", "--method", "sobol", "--samples", "0"], "0 candidates"),
        (["kp_roll=1..2:9999", "kd_roll=1..2:9999"], "cannot be swept"),
        (["kp_roll=1..2", "--seed", "-1", "--method", "random"], "seed"),
        (["kp_roll=1..2", "--amplitude", "99"], "max_speed"),
        (["kp_roll=1..2", "--amplitude", "nan"], "amplitude"),
        (["kp_roll=1..2", "--duration", "0"], "0.1 s or more"),
        (["kp_roll=1..2", "--duration", "601"], "600 s at most"),
        (["kp_roll=1..2", "--axis", "w"], "unknown --axis 'w'"),
        (["kp_roll=1..2", "--table", "a.txt"], ".csv or .parquet"),
        (["kp_roll=1..2", "--model", "gone.urdf"], "gone.urdf"),
        (["rotor_9=0..1"], "4 rotors"),
    ]:
        with case(options, word):
            assert word in refused("sweep", "--output", out, *options)
            assert not out.parent.exists()


def test_parquet_without_pyarrow_is_a_sentence(refused, out, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    said = refused(*SHORT, "--output", out, "--table", out / "a.parquet")
    assert "pip install pyarrow" in said
