"""What a pilot asks for, and that it is held."""

import pytest

from workbench.control.guidance import Reference
from workbench.control.mode import FlightMode, Request
from workbench.systems.pilot import AT_REST, Pilot, Wish, commanded, gone_to, requested

MOVING = Wish(Reference(1.0, 2.0, 3.0, 0.1, 0.0, 0.0, 0.0, 0.0), 1.0, 4.0, 2.0)


def test_a_velocity_ends_a_way_to_a_place_and_leaves_the_yaw_rate():
    going = gone_to(MOVING, [7.0, 8.0, 9.0])
    assert going.reference == Reference(0.0, 0.0, 0.0, 0.1, 7.0, 8.0, 9.0, 1.0)
    assert going[1:] == MOVING[1:]
    moving = commanded(going, [1.0, 0.0, -1.0])
    assert moving.reference == Reference(1.0, 0.0, -1.0, 0.1, 7.0, 8.0, 9.0, 0.0)
    assert commanded(MOVING, None, 0.3).reference == MOVING.reference._replace(yaw_rate=0.3)
    assert commanded(MOVING) == MOVING


@pytest.mark.parametrize("what", [Request.LAND, Request.STOP])
def test_landing_and_stopping_end_what_was_asked(what):
    asked = requested(MOVING, what, 0.0, FlightMode.CRUISING, 4.0)
    assert asked == Wish(AT_REST, float(what), 5.0, 0.0)


def test_a_request_in_the_air_leaves_the_command():
    asked = requested(MOVING, Request.TAKE_OFF, 3.0, FlightMode.TAKING_OFF, 4.0)
    assert asked == Wish(MOVING.reference, float(Request.TAKE_OFF), 5.0, 3.0)


@pytest.mark.parametrize("mode", [FlightMode.OFF, FlightMode.ARMED])
def test_on_the_ground_an_old_command_does_not_wait_for_the_take_off(mode):
    assert requested(MOVING, Request.TAKE_OFF, 3.0, mode, 4.0).reference == AT_REST


def test_of_two_requests_between_updates_the_more_urgent_one_stays():
    stop = requested(MOVING, Request.STOP, 0.0, FlightMode.HOVERING, 4.0)
    assert requested(stop, Request.ARM, 0.0, FlightMode.HOVERING, 4.0).request == Request.STOP
    assert requested(stop, Request.ARM, 0.0, FlightMode.HOVERING, 5.0).request == Request.ARM


def test_a_hold_outranks_the_take_off_before_it_and_not_the_one_after():
    """A new holder's first take-off comes right after the hold of the change of hands."""
    rising = requested(Wish(), Request.TAKE_OFF, 2.0, FlightMode.OFF, 0.0)
    held = requested(rising, Request.HOLD, 0.0, FlightMode.OFF, 0.0)
    assert held.request == Request.HOLD
    assert requested(held, Request.TAKE_OFF, 2.0, FlightMode.OFF, 0.0).request == Request.TAKE_OFF
    assert requested(held, Request.LAND, 0.0, FlightMode.OFF, 0.0).request == Request.LAND


def test_the_system_shows_and_keeps_the_wish():
    pilot = Pilot()
    context = pilot.CreateDefaultContext()
    assert pilot.wish(context) == Wish()
    pilot.set_wish(context, MOVING)
    assert pilot.wish(context) == MOVING
    assert pilot.GetOutputPort("reference").Eval(context).tolist() == list(MOVING.reference)
    assert pilot.GetOutputPort("request").Eval(context).tolist() == [1.0, 4.0, 2.0]
    other = pilot.CreateDefaultContext()
    assert pilot.wish(other) == Wish()
