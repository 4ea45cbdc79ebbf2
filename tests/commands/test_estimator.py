"""`--estimator`: what the controller knows of the motion, in the commands."""

import argparse
from pathlib import Path

import pytest

from workbench.commands.chosen_vehicle import chosen_scenario
from workbench.commands.cli import _parser
from workbench.commands.options import add_vehicle_options
from workbench.live.choice import Choice
from workbench.scenario.scenario import Scenario

LAG = Path(__file__).parents[1] / "estimation" / "lag.py"


def test_the_command_line_chooses_and_else_the_scenario_does():
    parser = argparse.ArgumentParser()
    add_vehicle_options(parser)

    def flown(*words):
        return chosen_scenario(parser.parse_args(words), Scenario(estimator="ekf")).estimator

    assert flown() == "ekf"
    assert [flown("--estimator", name) for name in ("truth", "complementary")] == [
        "truth",
        "complementary",
    ]
    assert Choice(scenario="hover", estimator="ekf").load().estimator == "ekf"
    assert Choice(scenario="hover").load().estimator == "truth"


def test_a_file_of_ones_own_flies_where_it_is_named(run, refused, tmp_path, out):
    """A scenario that names it does not run it: its code would have the reader's rights."""
    own = tmp_path / "own.py"
    own.write_text(LAG.read_text(encoding="utf-8"), encoding="utf-8")
    scenario = tmp_path / "own.yaml"
    scenario.write_text("estimator: own.py\nduration: 0.3\n", encoding="utf-8")
    said = refused("fly", scenario)
    assert "own.yaml:1: own.py is Python code that would run here: if you trust it, name it" in said
    assert f"as --estimator {own}" in said
    flown = ("fly", scenario, "--estimator", own, "--output", out, "--no-plots")
    log = tmp_path / "own.mcap"
    sensors = ("--sensors", "imu,gps,magnetometer")
    found = run(*flown, "--set", "lag_share=0.5", *sensors, "--log", log, "--json")
    assert found.code == 0, found.err
    assert found.json["estimate"]["nees"] is not None
    rows = run("params", "--estimator", own, "--set", "lag_share=0.5", "--json").json["parameters"]
    (row,) = [row for row in rows if row["name"] == "lag_share"]
    assert (row["value"], row["min"], row["max"], row["unit"]) == (0.5, 0.0, 1.0, "1")
    assert "unknown parameter 'lag_shore': did you mean 'lag_share'" in refused(
        *flown, "--set", "lag_shore=1"
    )
    for command in ("replay", "estimate"):
        assert f"was flown on {own}, Python code that would run here" in refused(command, log)
    assert "equal: all" in run("replay", log, "--estimator", own).out
    assert "was flown on own, and ekf has other parameters" in refused(
        "replay", log, "--estimator", "ekf"
    )
    there = ("--output", out, "--no-plots", "--json")
    estimated = run("estimate", log, "--estimator", own, "--set", "lag_share=0.4", *there).json
    assert (estimated["estimator"], estimated["settings"]) == ("own", {"lag_share": 0.4})
    own.write_text("def update(", encoding="utf-8")
    assert f"{own}:1: is not valid Python" in refused("fly", "hover", "--estimator", own)
    own.unlink()
    assert f"{own}: no such file: give the estimator's file" in refused(
        "step", "--axis", "x", "--estimator", own
    )


def test_wherever_a_flight_takes_a_controller_it_takes_an_estimator():
    commands = _parser()._subparsers._group_actions[0].choices
    # they fly what a file says: a spec, or a log with the estimate of its flight computer; a plan
    # is written for the controller alone
    of_files = {"regress", "predict", "what-if", "excite"}
    taking = {
        option: {name for name, each in commands.items() if option in each._option_string_actions}
        for option in ("--controller", "--estimator")
    }
    assert taking["--controller"] - of_files <= taking["--estimator"]
    assert {"fly", "step", "hover", "serve", "gui"} <= taking["--controller"] - of_files


@pytest.mark.parametrize("command", ["fly hover", "step", "hover", "reproduce", "serve", "gui"])
def test_a_name_of_none_is_refused(command, refused):
    said = refused(*command.split(), "--estimator", "efk")
    assert "unknown estimator 'efk'" in said
    assert "ekf" in said
    assert "did you mean 'ekf'?" in refused(*command.split(), "--estimator", "EKF")


def test_a_flight_on_an_estimate_is_judged_and_drawn(run, out):
    short = ("fly", "hover", "--duration", "0.5", "--output", out)
    said = run(*short, "--estimator", "ekf")
    assert said.code == 0, said.err
    assert "NEES of attitude, position and velocity" in said.out
    assert "magnetometer" in said.out
    picture = out / "hover-estimate.png"
    assert picture.read_bytes().startswith(b"\x89PNG")
    picture.unlink()
    found = run(*short, "--estimator", "complementary", "--no-plots", "--json").json
    states = {row["name"]: row for row in found["estimate"]["states"]}
    assert states["x"]["unit"] == "m"
    assert 0.0 < states["x"]["rms"] <= states["x"]["worst"] < 0.5
    assert found["estimate"]["nees"] is None
    assert not picture.exists()
    assert str(picture) not in found["files"]
    assert run(*short, "--no-plots", "--json").json["estimate"] is None
    table = out.parent / "thrusts.csv"
    table.write_text("t [s],1,2,3,4\n0,4,4,4,4\n", encoding="utf-8")
    refusal = run(*short, "--rotor-commands", table, "--estimator", "ekf")
    assert refusal.code == 2
    assert "--estimator" in refusal.err


def test_a_number_of_an_estimator_that_does_not_fly_is_told_on_one_line(run, out, case):
    short = ("fly", "hover", "--duration", "0.1", "--output", out, "--no-plots")
    gate = ("--set", "ekf_gate=3")
    for options, wanted in (
        (
            gate,
            "nothing uses ekf_gate, because the controller gets the truth: add `--estimator ekf`",
        ),
        (
            (*gate, "--set", "ekf_barometer=1", "--estimator", "complementary"),
            "nothing uses ekf_gate and ekf_barometer, because the controller gets what "
            "complementary estimates: add `--estimator ekf`",
        ),
        ((*gate, "--estimator", "ekf"), None),
        (("--set", "kp_roll=40"), None),
    ):
        with case(options):
            said = run(*short, *options)
            assert said.code == 0, said.err
            told = [line for line in said.err.splitlines() if "nothing uses" in line]
            assert told == ([f"workbench: {wanted}"] if wanted else [])


def test_noise_of_a_voltage_that_nobody_estimates_is_refused(refused):
    for options in ((), ("--estimator", "ekf")):  # the shipped drone states no battery
        said = refused("fly", "hover", "--set", "voltage_noise=0.1", *options)
        assert "voltage_noise cannot be set" in said
        assert "with an estimator, as `--estimator ekf`" in said
