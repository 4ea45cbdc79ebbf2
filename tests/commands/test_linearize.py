"""`workbench linearize`: poles as people read them, every state counted, nothing leaked."""

import re

import pytest

from tests.jointed import drone, joint, link


@pytest.mark.parametrize(
    "options",
    [
        [],
        ["--loop", "vehicle", "--time", "continuous"],
        ["--loop", "pitch", "--minimal"],
        ["--at", "vx=5", "--loop", "yaw_rate", "--cut", "error"],
    ],
)
def test_the_poles_add_up_to_the_states(run, options):
    said = run("linearize", *options)
    assert said.code == 0
    assert said.err == ""
    assert "nan" not in said.out
    assert "e-2" not in said.out
    lines = said.out.splitlines()
    states = int(re.search(r"(\d+) states", lines[0])[1])
    rows = [line for line in lines[4:] if re.match(r" *-?[0-9.]+", line) and "  " in line]
    counts = [int(line.split()[0]) for line in lines[4:] if line not in rows]
    assert len(rows) + sum("±" in row for row in rows) + sum(counts) == states


def test_what_only_adds_up_and_what_dies_out_is_counted(run):
    said = run("linearize")
    assert "\n4 integrators\n" in said.out
    assert said.out.endswith("\n3 more die out within a sample\n")


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["--loop", "position_x", "--at", "vx=3"], "the position is held in hover only"),
        (["--cut", "error"], "'closed' has no loop to cut"),
        (["--loop", "vehicle", "--cut", "error"], "'vehicle' has no loop to cut"),
        (["--at", "vx=1,vx=2"], "vx twice"),
    ],
)
def test_what_makes_no_sense_is_refused(refused, options, word):
    assert word in refused("linearize", *options)


@pytest.mark.parametrize("command", [("linearize",), ("frames",)])
def test_a_command_that_does_not_fly_says_which_joints_are_held(run, tmp_path, command):
    crate = link("crate", 0.1) + joint("free", "floating", "base", "crate", (0, 0, -0.3))
    said = run(*command, "--model", drone(tmp_path, crate))
    assert said.code == 0
    held = "joint 'free': a joint of the kind 'floating' is not flown; held at zero"
    assert said.err.count(held) == 1


def test_a_setpoint_of_a_servo_that_is_not_there_is_refused_in_a_sentence(run):
    none = "servo_x cannot be set: this drone has no servos, or its control law commands them all\n"
    for command in (("linearize", "--set", "servo_x=1"), ("sweep", "servo_x=0..1:2")):
        said = run(*command)
        assert (said.code, said.err.endswith(none)) == (2, True)
    said = run("linearize", "--model", "gimbal", "--set", "servo_gimbal_pich=1")
    assert said.code == 2
    assert "unknown servo 'servo_gimbal_pich': did you mean 'servo_gimbal_pitch'?" in said.err
