"""`workbench linearize`: poles as people read them, every state counted, nothing leaked."""

import re

import pytest


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
