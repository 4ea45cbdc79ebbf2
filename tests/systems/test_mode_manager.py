"""Oracle: the pure functions of `flight_mode`, called here with the same numbers."""

import math

import pytest
from pydrake.systems.analysis import Simulator

from workbench.control.flight_mode import (
    FlightModeInputs,
    FlightModeSettings,
    ModeState,
    guidance,
    initial_state,
    next_state,
    with_walls,
)
from workbench.control.guidance import Guidance, Reference
from workbench.control.mode import FlightMode, ModeRequest
from workbench.systems.mode_manager import ModeManager

PERIOD = 0.25
SETTINGS = FlightModeSettings(take_off_speed=1.2, landing_speed=0.3, battery_reserve=0.2)
P = [1.0, 2.0, 3.0]
V = [0.5, 0.0, 0.1]
STATE = [1.0, 0.0, 0.0, 0.0, *P, 0.0, 0.0, 0.0, *V]
REFERENCE = Reference(0.5, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0)


@pytest.fixture
def flown():
    """A manager in the air, with its inputs fixed, in a simulator."""
    manager = ModeManager(period=PERIOD, settings=SETTINGS, standing_height=0.1)
    simulator = Simulator(manager)
    context = simulator.get_mutable_context()
    manager.GetInputPort("state").FixValue(context, STATE)
    manager.GetInputPort("reference").FixValue(context, list(REFERENCE))
    manager.GetInputPort("request").FixValue(context, [0.0, 0.0, 0.0])
    manager.GetInputPort("charge").FixValue(context, [0.9])
    manager.set_mode(context, initial_state(FlightMode.HOVERING, P), P)
    return manager, simulator


def outputs(manager, context) -> tuple[list[float], list[float]]:
    return tuple(manager.GetOutputPort(n).Eval(context).tolist() for n in ("mode", "guidance"))


def test_what_is_set_comes_out_at_once(flown):
    manager, simulator = flown
    state = initial_state(FlightMode.HOVERING, P)
    mode, guide = outputs(manager, simulator.get_context())
    assert mode == list(state)
    assert guide == list(guidance(state, P, SETTINGS))


def test_every_period_it_does_what_the_pure_functions_do(flown):
    manager, simulator = flown
    context = simulator.get_mutable_context()
    state = initial_state(FlightMode.HOVERING, P)
    requests = [
        (0.0, 0.0),
        (0.0, 0.0),
        (float(ModeRequest.LAND), 1.0),
        (float(ModeRequest.LAND), 1.0),
    ]
    for update, (request, serial) in enumerate(requests):
        manager.GetInputPort("request").FixValue(context, [request, serial, 2.0])
        time = update * PERIOD
        now = FlightModeInputs(time, P, V, REFERENCE, int(request), serial, 2.0, 0.9, 0.1)
        state = next_state(state, now, SETTINGS)
        simulator.AdvanceTo(time + 0.5 * PERIOD)
        mode, guide = outputs(manager, context)
        assert mode == list(state)
        assert guide == list(guidance(state, P, SETTINGS))
    assert mode[0] == FlightMode.LANDING


def test_between_updates_nothing_happens(flown):
    manager, simulator = flown
    simulator.AdvanceTo(0.1)
    context = simulator.get_mutable_context()
    before = outputs(manager, context)
    manager.GetInputPort("request").FixValue(context, [float(ModeRequest.STOP), 1.0, 0.0])
    simulator.AdvanceTo(0.2)
    assert outputs(manager, context) == before
    simulator.AdvanceTo(0.3)
    assert outputs(manager, context)[0][0] == FlightMode.OFF


def test_settings_are_live(flown):
    manager, simulator = flown
    context = simulator.get_mutable_context()
    manager.GetInputPort("request").FixValue(context, [float(ModeRequest.TAKE_OFF), 1.0, 9.0])
    context.get_mutable_numeric_parameter(0).SetFromVector(list(FlightModeSettings(0.45, 0.3, 0.1)))
    manager.set_mode(context, initial_state(FlightMode.ARMED, P)._replace(target=9.0), P)
    simulator.AdvanceTo(1.1)
    assert outputs(manager, context)[1][3] == 0.45


def test_a_landing_ends_where_a_contact_force_carries_the_drone(flown):
    """It is the sum of those on all bodies; unconnected, nothing touches the drone."""
    manager = ModeManager(period=PERIOD, settings=SETTINGS, standing_height=0.1, bodies=2)
    simulator = Simulator(manager)
    context = simulator.get_mutable_context()
    for name in ("reference", "request", "charge"):
        port = flown[0].GetInputPort(name)
        manager.GetInputPort(name).FixValue(context, port.Eval(flown[1].get_context()))
    state = initial_state(FlightMode.LANDING, P)._replace(holding=1.0)
    manager.set_mode(context, state, P)
    manager.GetInputPort("state").FixValue(context, [*STATE[:10], 0.0, 0.0, 0.0])
    for contact, expected in (
        (None, FlightMode.LANDING),
        ([0.0, 0.0, 1.0, 0.0, 2.0, 0.0], FlightMode.LANDING),
        ([0.0, 2.0, 1.0, 0.0, -2.0, 1.0], FlightMode.OFF),
    ):
        if contact:
            manager.GetInputPort("contact_forces").FixValue(context, contact)
        simulator.AdvanceTo(context.get_time() + 4.0)
        assert outputs(manager, context)[0][0] == expected


def test_walls_that_are_connected_limit_the_speed(flown):
    manager, simulator = flown
    context = simulator.get_mutable_context()
    walls = [0.6, 0.8, 0.0, 2.5, 0.0, 0.0, 1.0, 4.0, 0.0, 0.0, 0.0, math.inf]
    manager.GetInputPort("walls").FixValue(context, walls)
    settings = SETTINGS._replace(obstacle_brake=0.7, stop_distance=0.4)
    context.get_mutable_numeric_parameter(0).SetFromVector(list(settings))
    simulator.AdvanceTo(0.1)
    mode, guide = outputs(manager, context)
    plain = guidance(ModeState(*mode), P, settings)
    assert guide == list(with_walls(plain, walls, P, FlightMode(int(mode[0])), settings))
    assert guide[9] == 0.7


def test_no_output_follows_an_input_directly(flown):
    manager, _ = flown
    assert not manager.HasAnyDirectFeedthrough()


def test_the_state_is_that_of_the_pure_functions(flown):
    manager, _ = flown
    assert manager.GetOutputPort("mode").size() == len(ModeState._fields)
    assert manager.GetOutputPort("guidance").size() == len(Guidance._fields)


def braking() -> tuple[ModeManager, Simulator]:
    """Return a mode that brakes before walls, which it looks at four times a period."""
    settings = SETTINGS._replace(obstacle_brake=1.0, stop_distance=0.5)
    manager = ModeManager(
        period=PERIOD, settings=settings, standing_height=0.1, wall_period=PERIOD / 4
    )
    simulator = Simulator(manager)
    context = simulator.get_mutable_context()
    for name, value in (("reference", list(REFERENCE)), ("request", [0.0] * 3), ("charge", [0.9])):
        manager.GetInputPort(name).FixValue(context, value)
    manager.GetInputPort("state").FixValue(context, STATE)
    return manager, simulator


def test_walls_are_renewed_between_updates_of_the_mode_and_nothing_else():
    manager, simulator = braking()
    context = simulator.get_mutable_context()
    nothing = [0.0, 0.0, 0.0, math.inf]
    manager.GetInputPort("walls").FixValue(context, [1.0, 0.0, 0.0, 3.0] + 2 * nothing)
    manager.set_mode(context, initial_state(FlightMode.HOVERING, P), P)
    simulator.AdvanceTo(0.6 * PERIOD)  # it has looked at 0, 1/4 and 1/2 of a period
    before = Guidance(*outputs(manager, context)[1])
    manager.GetInputPort("state").FixValue(context, [*STATE[:4], P[0] + 0.1, *STATE[5:]])
    manager.GetInputPort("walls").FixValue(context, [1.0, 0.0, 0.0, 2.0] + 2 * nothing)
    simulator.AdvanceTo(0.9 * PERIOD)
    after = Guidance(*outputs(manager, context)[1])
    assert before.wall_1_offset == pytest.approx(P[0] + 3.0 - 0.5)
    assert after.wall_1_offset == pytest.approx(P[0] + 0.1 + 2.0 - 0.5)
    assert after == before._replace(wall_1_offset=after.wall_1_offset)


def test_walls_below_a_landing_do_not_count_between_updates_of_the_mode_either():
    manager, simulator = braking()
    context = simulator.get_mutable_context()
    ahead, below = [1.0, 0.0, 0.0, 3.0], [0.0, 0.0, -1.0, 1.0]
    manager.GetInputPort("walls").FixValue(context, [*below, *ahead, 0.0, 0.0, 0.0, math.inf])
    manager.set_mode(context, initial_state(FlightMode.LANDING, P), P)
    for share in (0.1, 0.6):  # after an update of the mode, and after two of the walls alone
        simulator.AdvanceTo(share * PERIOD)
        guide = Guidance(*outputs(manager, context)[1])
        assert (guide.wall_1_z, guide.wall_1_offset) == (0.0, 0.0)
        assert guide.wall_2_offset == pytest.approx(P[0] + 3.0 - 0.5)
