"""What a pilot asks for, and that it is held."""

import pytest

from workbench.control.guidance import Reference
from workbench.control.mode import FlightMode, ModeRequest
from workbench.systems.pilot import (
    ZERO_REFERENCE,
    PilotCommand,
    PilotSystem,
    with_mode_request,
    with_position_command,
    with_velocity_command,
)

MOVING = PilotCommand(Reference(1.0, 2.0, 3.0, 0.1, 0.0, 0.0, 0.0, 0.0), 1.0, 4.0, 2.0)


def test_a_velocity_ends_a_way_to_a_place_and_leaves_the_yaw_rate():
    going = with_position_command(MOVING, [7.0, 8.0, 9.0])
    assert going.reference == Reference(0.0, 0.0, 0.0, 0.1, 7.0, 8.0, 9.0, 1.0)
    assert going[1:] == MOVING[1:]
    moving = with_velocity_command(going, [1.0, 0.0, -1.0])
    assert moving.reference == Reference(1.0, 0.0, -1.0, 0.1, 7.0, 8.0, 9.0, 0.0)
    assert with_velocity_command(MOVING, None, 0.3).reference == MOVING.reference._replace(
        yaw_rate=0.3
    )
    assert with_velocity_command(MOVING) == MOVING


@pytest.mark.parametrize("what", [ModeRequest.LAND, ModeRequest.STOP])
def test_landing_and_stopping_end_what_was_asked(what):
    asked = with_mode_request(MOVING, what, 0.0, FlightMode.CRUISING, 4.0)
    assert asked == PilotCommand(ZERO_REFERENCE, float(what), 5.0, 0.0)


def test_a_request_in_the_air_leaves_the_command():
    asked = with_mode_request(MOVING, ModeRequest.TAKE_OFF, 3.0, FlightMode.TAKING_OFF, 4.0)
    assert asked == PilotCommand(MOVING.reference, float(ModeRequest.TAKE_OFF), 5.0, 3.0)


@pytest.mark.parametrize("mode", [FlightMode.OFF, FlightMode.ARMED])
def test_on_the_ground_an_old_command_does_not_wait_for_the_take_off(mode):
    assert (
        with_mode_request(MOVING, ModeRequest.TAKE_OFF, 3.0, mode, 4.0).reference == ZERO_REFERENCE
    )


def test_of_two_requests_between_updates_the_more_urgent_one_stays():
    stop = with_mode_request(MOVING, ModeRequest.STOP, 0.0, FlightMode.HOVERING, 4.0)
    assert (
        with_mode_request(stop, ModeRequest.ARM, 0.0, FlightMode.HOVERING, 4.0).request
        == ModeRequest.STOP
    )
    assert (
        with_mode_request(stop, ModeRequest.ARM, 0.0, FlightMode.HOVERING, 5.0).request
        == ModeRequest.ARM
    )


def test_a_hold_outranks_the_take_off_before_it_and_not_the_one_after():
    """A new holder's first take-off comes right after the hold of the change of hands."""
    rising = with_mode_request(PilotCommand(), ModeRequest.TAKE_OFF, 2.0, FlightMode.OFF, 0.0)
    held = with_mode_request(rising, ModeRequest.HOLD, 0.0, FlightMode.OFF, 0.0)
    assert held.request == ModeRequest.HOLD
    assert (
        with_mode_request(held, ModeRequest.TAKE_OFF, 2.0, FlightMode.OFF, 0.0).request
        == ModeRequest.TAKE_OFF
    )
    assert (
        with_mode_request(held, ModeRequest.LAND, 0.0, FlightMode.OFF, 0.0).request
        == ModeRequest.LAND
    )


def test_the_system_shows_and_keeps_the_wish():
    pilot = PilotSystem()
    context = pilot.CreateDefaultContext()
    assert pilot.command(context) == PilotCommand()
    pilot.set_command(context, MOVING)
    assert pilot.command(context) == MOVING
    assert pilot.GetOutputPort("reference").Eval(context).tolist() == list(MOVING.reference)
    assert pilot.GetOutputPort("request").Eval(context).tolist() == [1.0, 4.0, 2.0]
    other = pilot.CreateDefaultContext()
    assert pilot.command(other) == PilotCommand()
