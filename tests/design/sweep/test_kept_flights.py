"""A sweep that is ended goes on from what it has flown, and ends as if it never had been."""

import json
from functools import partial

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.design.executor import cluster
from workbench.design.executor.executor import InThisProcess
from workbench.design.metrics import FLOWN_METRICS
from workbench.design.sweep import compiled_flights, kept_flights
from workbench.design.sweep.full_flights import fly_full
from workbench.design.sweep.kept_flights import KeptFlights
from workbench.design.sweep.sweep import sweep
from workbench.scenario.scenario import Scenario, ScenarioStart

SWEPT = ["kp_velocity_z=2..10:5"]


@pytest.fixture(autouse=True)
def soon(monkeypatch):
    """Keep each flight at once."""
    monkeypatch.setattr(kept_flights, "FIRST_WRITE_DELAY_S", 0.0)
    monkeypatch.setattr(kept_flights, "WRITE_PERIOD_S", 0.0)


class Calculated:
    """Flies nothing: the numbers of a flight follow from its candidate.

    Attributes:
        flown: the candidates that were asked for.
    """

    def __init__(self, most=10**9, failure=None):
        self.flown, self._most, self._failure = [], most, failure

    def __call__(self, case, vehicle, candidates, stop=None):
        for index, each in enumerate(candidates[: self._most]):
            self.flown.append(each.settings["kp_velocity_z"])
            values = np.sqrt(self.flown[-1] + np.arange(len(FLOWN_METRICS)))
            yield [index], values[None], np.array([0.1 if self.flown[-1] > 7.0 else np.nan])
            if self._failure and index + 1 == self._most:
                raise self._failure

    __name__ = "calculated"


def bytes_of(table):
    return [np.asarray(each).tobytes() for each in (table.rows, table.present_values)]


def test_what_was_flown_is_not_flown_again(tmp_path, caplog):
    path, whole = tmp_path / "kept", sweep(SWEPT, fly=Calculated())
    part = sweep(SWEPT, fly=Calculated(most=3), kept=path)
    assert len(part) == 2  # and the present gains
    rest = Calculated()
    assert bytes_of(sweep(SWEPT, fly=rest, kept=path)) == bytes_of(whole)
    assert rest.flown == [6.0, 8.0, 10.0]
    assert caplog.messages == [
        "3 of 6 flights are kept from the sweep that was ended: flying the others"
    ]
    nothing = Calculated()
    assert bytes_of(sweep(SWEPT, fly=nothing, kept=path)) == bytes_of(whole)
    assert nothing.flown == []


@pytest.mark.parametrize("failure", [KeyboardInterrupt(), WorkbenchError("a process is lost")])
def test_what_was_flown_before_a_failure_is_kept(tmp_path, failure):
    path = tmp_path / "kept"
    with pytest.raises(type(failure)):
        sweep(SWEPT, fly=Calculated(4, failure), kept=path)
    rest = Calculated()
    whole = sweep(SWEPT, fly=Calculated())
    assert bytes_of(sweep(SWEPT, fly=rest, kept=path)) == bytes_of(whole)
    assert len(rest.flown) == 2


def test_an_incomplete_line_is_flown_again(tmp_path):
    """As after the machine has lost its power."""
    path, whole = tmp_path / "kept", sweep(SWEPT, fly=Calculated())
    sweep(SWEPT, fly=Calculated(most=3), kept=path)
    kept = path.read_bytes()
    for end in (-1, -5, -150):
        path.write_bytes(kept[:end])
        rest = Calculated()
        assert bytes_of(sweep(SWEPT, fly=rest, kept=path)) == bytes_of(whole)
        assert len(rest.flown) == 4
        nothing = Calculated()
        assert bytes_of(sweep(SWEPT, fly=nothing, kept=path)) == bytes_of(whole)
        assert nothing.flown == []


def test_flights_of_another_sweep_are_refused(tmp_path, case):
    path = tmp_path / "kept"
    sweep(SWEPT, fly=Calculated(most=3), kept=path)
    before = path.read_bytes()
    for other, what in (
        ({"ranges": ["kp_velocity_z=2..9:5"]}, "candidates"),
        ({"amplitude": 0.5}, "step"),
        ({"settings": {"kd_velocity_z": 0.2}}, "settings"),
        ({"fly": partial(fly_full, executor=InThisProcess())}, "engine"),
    ):
        with case(what), pytest.raises(WorkbenchError, match=f"with other {what}: delete it"):
            sweep(**{"ranges": SWEPT, "fly": Calculated(), "kept": path} | other)
    path.write_text("time,state\n0,1\n")
    with pytest.raises(WorkbenchError, match="kept: keeps no flights of a sweep: delete it"):
        sweep(SWEPT, fly=Calculated(), kept=path)
    path.write_bytes(before)
    head = json.loads(before.partition(b"\n")[0])
    with (
        KeptFlights(path, lambda: head, 6),
        pytest.raises(WorkbenchError, match="another sweep writes it: wait for that"),
    ):
        sweep(SWEPT, fly=Calculated(), kept=path)


def test_flights_of_another_vehicle_or_version_are_refused(tmp_path, monkeypatch):
    path = tmp_path / "kept"
    sweep(SWEPT, fly=Calculated(most=3), kept=path)
    start = Scenario(start=ScenarioStart(position=[0.0, 0.0, 9.0]))
    with pytest.raises(WorkbenchError, match="with other scenario: delete it"):
        sweep(SWEPT, fly=Calculated(), kept=path, scenario=start)
    here = cluster.process_versions()
    monkeypatch.setattr(cluster, "process_versions", lambda: here | {"pydrake": "0.0"})
    with pytest.raises(WorkbenchError, match="with other versions: delete it"):
        sweep(SWEPT, fly=Calculated(), kept=path)


def test_a_short_sweep_keeps_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(kept_flights, "FIRST_WRITE_DELAY_S", 3600.0)
    sweep(SWEPT, fly=Calculated(most=3), kept=tmp_path / "kept")
    assert not list(tmp_path.iterdir())


def test_a_full_device_ends_the_keeping_and_not_the_sweep(caplog):
    table = sweep(SWEPT, fly=Calculated(), kept=kept_flights.Path("/dev/full/kept"))
    assert len(table) == 5
    assert caplog.messages == [
        "further flights are not kept: [Errno 20] Not a directory: '/dev/full/kept'"
    ]


@pytest.mark.parametrize("chunk", [1, 2])
def test_the_compiled_engine_goes_on_to_the_bit(lost_table, tmp_path, monkeypatch, chunk):
    """A flight does not depend on those beside it."""
    monkeypatch.setattr(compiled_flights, "CANDIDATES_PER_CHUNK", chunk)
    words = [f"{each.name}={each.low:g}..{each.high:g}:{each.points}" for each in lost_table.ranges]
    step = {"axis": "x", "amplitude": 1.0, "kept": tmp_path / "kept"}
    asked = []
    part = sweep(words, **step, stop=lambda: asked.append(0) or len(asked) > 3)
    assert 0 < len(part) < len(lost_table)
    assert bytes_of(sweep(words, **step)) == bytes_of(lost_table)


@pytest.mark.slow
def test_the_full_diagram_goes_on_to_the_bit(tmp_path):
    fly = partial(fly_full, executor=InThisProcess())
    step = {"axis": "z", "duration": 0.3, "fly": fly}
    whole = sweep(["kp_velocity_z=2..6:2"], **step)
    kept = tmp_path / "kept"
    assert len(sweep(["kp_velocity_z=2..6:2"], **step, kept=kept, stop=lambda: True)) == 0
    assert len(kept.read_text().splitlines()) == 2
    assert bytes_of(sweep(["kp_velocity_z=2..6:2"], **step, kept=kept)) == bytes_of(whole)
