"""A flight continues after the program that runs its law has ended."""

import shutil

import pytest

from workbench.scenario.scenario import Scenario, ScenarioStart
from workbench.session.session import Session

TEXT = """
from workbench.common.errors import FlightBrokenError


class Program:
    count = 0

    def update(self, measured, setpoint, g, vehicle, memory, dt, loops):
        self.count += 1
        if self.count > 40:
            raise FlightBrokenError("it ended")
        return (9.81 * vehicle.mass, 0.0, 0.0, 0.0), memory

    def report(self):
        return {"updates": self.count}

    def records(self):
        return {}

    def close(self):
        pass


def program(known, period):
    return Program()
"""


@pytest.fixture
def ended(tmp_path):
    """Return a session whose law has ended after 40 updates, within `programs`."""
    path = tmp_path / "short.py"
    path.write_text(TEXT, encoding="utf-8")
    start = ScenarioStart(position=[0.0, 0.0, 40.0])
    session = Session(Scenario(controller=str(path), start=start))
    with session.programs():
        session.tick(0.5)
        assert session.ended.startswith("it ended at t = 0.312 s; the rotors stop")
        yield session


def test_one_that_continues_from_there_says_so_starts_nothing_and_starts_after_a_reset(ended):
    again = Session(ended.scenario)
    with again.programs():
        again.begin_from(ended.checkpoint())
        assert again.ended.startswith("the program that runs short ended before t = 0.500 s")
        again.tick(0.25)
        assert again.ended and again.program is None
        assert max(again.snapshot().thrusts) < 0.1
        again.reset()
        again.tick(0.25)
        assert not again.ended and again.exchange["updates"] == 32


def test_a_law_of_the_same_text_that_takes_over_runs(ended, tmp_path):
    shutil.copy(tmp_path / "short.py", tmp_path / "copy.py")
    ended.fly_controller(str(tmp_path / "copy.py"))
    assert not ended.ended
    ended.tick(0.25)
    assert not ended.ended and ended.exchange["updates"] == 32
    assert min(ended.snapshot().thrusts) > 0.5
