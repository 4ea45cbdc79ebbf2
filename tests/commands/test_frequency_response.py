"""`workbench frequency-response`."""

import csv
import math

import numpy as np
import pytest

from workbench.design.judge.loop_response import loop_responses
from workbench.design.linear.study import LinearStudy

QUICK = ("--lowest", "3", "--periods", "3")


def test_json_and_table_have_flight_and_model(run, tmp_path):
    said = run("frequency-response", "velocity_z", *QUICK, "--output", tmp_path, "--json")
    assert said.code == 0, said.err
    found = said.json
    assert (found["loop"], found["cut"], found["periods"]) == ("velocity_z", "actuator", 2)
    model = LinearStudy().sampled()
    loops = loop_responses(model, ["acceleration_z"])
    modelled = np.abs(loops.at(np.array([row["frequency"] for row in found["rows"]]))[0])
    for row, size in zip(found["rows"], modelled, strict=True):
        assert row["model_size"] == pytest.approx(size, rel=1e-6)
        assert row["measured_size"] == pytest.approx(size, rel=0.05)
    names = {"frequency-response-velocity_z.csv", "frequency-response-velocity_z.png"}
    assert {path.name for path in tmp_path.iterdir()} == names
    with (tmp_path / "frequency-response-velocity_z.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(found["rows"])
    assert float(rows[0]["frequency [rad/s]"]) == pytest.approx(3.0, rel=0.01)


def test_the_table_ends_with_how_far_flight_and_model_differ(run, out):
    said = run("frequency-response", "roll", *QUICK, "--no-plots", "--output", out)
    assert said.code == 0, said.err
    last = said.out.splitlines()[-1]
    assert "flight and model differ by" in last
    assert float(last.split(" dB")[0].split()[-1]) < 1.0
    assert math.isclose(float(said.out.splitlines()[3].split()[0]), 3.0, rel_tol=0.01)


def test_wrong_inputs_are_a_sentence(run, out, case):
    for arguments, said in (
        (("velocty",), "unknown loop 'velocty'"),
        (("roll", "--lowest", "0"), "reaches from 0"),
        (("roll", "--periods", "2"), "has 2 periods"),
        (("roll", "--size", "nan"), "size injected is nan"),
    ):
        with case(said):
            found = run("frequency-response", *arguments, "--output", out)
            assert found.code == 2 and said in found.err
            assert not out.exists()
