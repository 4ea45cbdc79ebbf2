"""`workbench frequency-response`."""

import csv
import math
import re

import numpy as np
import pytest

from workbench.design.judge.loop_response import loop_responses
from workbench.design.linear.study import LinearStudy

QUICK = ("--lowest", "3", "--periods", "3")


@pytest.mark.slow
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
    *lines, last = said.out.splitlines()
    assert "flight and model differ by" in last
    rows = np.array([line.split() for line in lines[3:] if "-" not in line.split()], dtype=float)
    frequency, coherence, *_, model_size, model_phase, size, phase = rows.T
    assert math.isclose(frequency[0], 3.0, rel_tol=0.01)
    modelled = loop_responses(LinearStudy().sampled(), ["roll_acceleration"]).at(frequency)[0]
    assert model_size == pytest.approx(20.0 * np.log10(np.abs(modelled)), abs=0.15)
    off = np.angle(modelled * np.exp(-1j * np.radians(model_phase)), deg=True)
    assert np.abs(off).max() < 1.0
    told = {unit: float(number) for number, unit in re.findall(r"([\d.]+) (rad/s|dB|deg)", last)}
    judged = (frequency <= told["rad/s"]) & (coherence >= 0.9)
    assert told["dB"] == pytest.approx(np.abs(size[judged]).max(), abs=0.011) and told["dB"] < 1.0
    assert told["deg"] == pytest.approx(np.abs(phase[judged]).max(), abs=0.11)


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
