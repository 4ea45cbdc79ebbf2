"""The pilot of the demo, above a flight that only listens."""

import dataclasses

import pytest

from workbench.control.mode import FlightMode
from workbench.gui.app import DEMO_WAYPOINTS_M, WAYPOINT_INTERVAL_S, DemoPilot
from workbench.live.messages import Phase
from workbench.scenario.scenario import Action


@pytest.fixture
def orders():
    return []


@pytest.fixture
def pilot(workspace, canned, monkeypatch, orders):
    """A pilot whose orders take effect at once, at the time of the newest view."""
    made = DemoPilot(workspace.flight, workspace.notices)
    clock = [0.0]

    def do(order, done, refused=None):
        orders.append(order)
        done(clock[0])

    def show(mode, time, place=None, phase=Phase.FLYING):
        clock[0] = time
        reference = (0.0, 0.0, 0.0, 0.0, *(place or (0.0, 0.0, 0.0)), 1.0 if place else 0.0)
        snapshot = canned.views[0].snapshot
        snapshot = dataclasses.replace(snapshot, mode=mode, time=time, reference=reference)
        view = dataclasses.replace(canned.views[0], snapshot=snapshot, phase=phase)
        workspace.flight.viewed.emit(view)

    monkeypatch.setattr(workspace.flight, "do", do)
    made.show = show
    return made


def take_off(pilot):
    pilot.show(FlightMode.OFF, 0.0)
    pilot.show(FlightMode.OFF, 0.1)  # not heard yet
    pilot.show(FlightMode.TAKING_OFF, 1.0)
    pilot.show(FlightMode.HOVERING, 3.0)


def test_it_takes_off_once_and_flies_to_the_first_place(pilot, orders):
    take_off(pilot)
    assert orders == [Action(request="take_off"), Action(go_to=[*DEMO_WAYPOINTS_M[0]])]


def test_it_flies_the_round_again_and_again(pilot, orders):
    take_off(pilot)
    for number in range(1, 9):
        time = 3.0 + number * WAYPOINT_INTERVAL_S
        pilot.show(FlightMode.CRUISING, time - 0.1, DEMO_WAYPOINTS_M[(number - 1) % 4])
        pilot.show(FlightMode.HOVERING, time, DEMO_WAYPOINTS_M[(number - 1) % 4])
    assert [tuple(order.go_to) for order in orders[1:]] == [
        *DEMO_WAYPOINTS_M,
        *DEMO_WAYPOINTS_M,
        DEMO_WAYPOINTS_M[0],
    ]


@pytest.mark.parametrize(
    ("mode", "place", "why"),
    [
        (FlightMode.CRUISING, None, "somebody else flies"),
        (FlightMode.LANDING, DEMO_WAYPOINTS_M[0], "the drone lands"),
        (FlightMode.OFF, DEMO_WAYPOINTS_M[0], "the drone lands"),
    ],
)
def test_it_leaves_the_drone_to_whoever_else_flies(pilot, orders, told, mode, place, why):
    take_off(pilot)
    pilot.show(mode, 5.0, place)
    pilot.show(FlightMode.HOVERING, 50.0, place)
    assert len(orders) == 2
    assert [notice.what for notice in told] == [
        f"the demo has ended, because {why}; a reset starts it again"
    ]


def test_a_reset_begins_it_again(pilot, orders, workspace, canned):
    take_off(pilot)
    pilot.show(FlightMode.LANDING, 5.0)
    workspace.flight.begun.emit(canned.views[0])
    take_off(pilot)
    assert orders[2:] == orders[:2]


def test_it_flies_in_no_other_scenario(pilot, orders, workspace, canned):
    first = canned.views[0]
    other = dataclasses.replace(first, scenario=dataclasses.replace(first.scenario, world="empty"))
    for view in (first, other):
        workspace.flight.begun.emit(view)
    pilot.show(FlightMode.OFF, 0.0)
    assert orders == []
    workspace.flight.begun.emit(first)
    pilot.show(FlightMode.OFF, 0.0)
    assert orders == [Action(request="take_off")]


def test_a_pause_is_waited_for(pilot, orders):
    pilot.show(FlightMode.OFF, 0.0, phase=Phase.PAUSED)
    assert orders == []
