"""A measurement tells of its whole periods, and takes its injection along when it ends."""

from types import SimpleNamespace

import pytest

from workbench.control.mode import FlightMode
from workbench.live import measurer as module
from workbench.live.measurer import Measurer
from workbench.scenario.scenario import Injection, Rates


class FlownSession:
    """A session that a test moves on: its injection, its mode, and who has control."""

    def __init__(self):
        self.scenario = SimpleNamespace(rates=Rates(), figure_eight=None)
        self.injected, self.injecting, self.time = None, 0.5, 0.0
        self.mode, self.operates = FlightMode.HOVERING, True

    def snapshot(self):
        return SimpleNamespace(mode=self.mode, p_WB=(1.0, 2.0, 3.0))


class CalmGuard:
    def __init__(self, session):
        pass

    def trouble(self):
        return ""

    def obstacle(self):
        return ""


@pytest.fixture
def bench(monkeypatch):
    """A session whose measurement has begun, with what it was asked and what was told."""
    monkeypatch.setattr(module, "ExcitationGuard", CalmGuard)
    session, done, told = FlownSession(), [], []
    measurer = Measurer(session, lambda: session.operates, done.append, told.append)
    measurer.begin(Injection(point="acceleration_z", size=1.0), hold=False)
    done.clear()
    return SimpleNamespace(session=session, measurer=measurer, done=done, told=told)


def fly(bench, periods):
    """Fly a step, after which so many periods have been measured."""
    bench.session.injected = SimpleNamespace(came=[0.0] * periods)
    list(bench.measurer.parts(1))


def test_each_whole_period_is_told_once_from_the_second_on(bench):
    for periods in (0, 1, 1, 2, 2, 3):
        fly(bench, periods)
    assert [len(each.came) for each in bench.told] == [2, 3]
    assert bench.measurer.share == 0.5 and bench.done == []


def test_whatever_ends_it_ends_the_injection_too(bench, case):
    """It is over, another one flies, or the drone lands: nothing must go on shaking the drone."""
    for change, goes_to in (
        ({"injecting": 1.0}, [1.0, 2.0, 3.0]),
        ({"operates": False}, None),
        ({"mode": FlightMode.LANDING}, None),
    ):
        with case(change):
            session = bench.session
            session.injecting, session.mode, session.operates = 0.5, FlightMode.HOVERING, True
            bench.measurer.begin(Injection(point="acceleration_z", size=1.0), hold=False)
            bench.done.clear()
            vars(session).update(change)
            fly(bench, 0)
            [action] = bench.done
            assert action.injection == Injection() and action.go_to == goes_to
            assert bench.measurer.share is None
