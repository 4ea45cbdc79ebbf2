"""Oracle: the table of transitions, written out here by hand."""

import math

import pytest

from workbench.control.flight_mode import (
    MAX_HOVERING_SPEED,
    MAX_TOUCH_DOWN_SPEED,
    MIN_TOUCH_DOWN_TIME_S,
    SPOOL_UP_TIME_S,
    STOPPING_TIME_S,
    EstimateHealth,
    FlightModeInputs,
    FlightModeSettings,
    ModeState,
    guidance,
    initial_state,
    next_state,
    with_walls,
)
from workbench.control.guidance import Guidance, Reference
from workbench.control.mode import FlightMode, ModeRequest, Reason

OFF, ARMED, TAKING_OFF, HOVERING, ASCENDING, DESCENDING, CRUISING, LANDING = FlightMode
FLYING = (HOVERING, ASCENDING, DESCENDING, CRUISING)
SETTINGS = FlightModeSettings(take_off_speed=1.0, landing_speed=0.4, battery_reserve=0.2)
NOTHING = Reference(0, 0, 0, 0, 0, 0, 0, 0)
P = [1.0, 2.0, 3.0]
WELL = EstimateHealth(deviation=0.5, gps_age=0.2, imu_age=0.0, heading_age=0.1)
NO_DEVIATION = WELL._replace(deviation=math.nan)


def in_mode(mode: FlightMode, **changes) -> ModeState:
    """In a mode since 10 s, moving until just now, holding nothing, one request seen so far."""
    state = ModeState(float(mode), 1.0, 10.0, 19.9, 0.0, 0.0, 7.0, 8.0, 9.0)
    return state._replace(**changes)


def seen(**changes) -> FlightModeInputs:
    """At 20 s, at P and at rest, with nothing new."""
    calm = FlightModeInputs(
        20.0, P, [0.0, 0.0, 0.0], NOTHING, 0, 1.0, 1.5, 1.0, standing_height=P[2]
    )
    return calm._replace(**changes)


def asked(request: ModeRequest, **changes) -> FlightModeInputs:
    return seen(request=int(request), serial=2.0, **changes)


def after(state: ModeState, now: FlightModeInputs) -> ModeState:
    return next_state(state, now, SETTINGS)


def mode_after(state: ModeState, now: FlightModeInputs) -> FlightMode:
    return FlightMode(int(after(state, now).mode))


@pytest.mark.parametrize("mode", FlightMode)
def test_stop_always_stops(mode):
    assert mode_after(in_mode(mode), asked(ModeRequest.STOP)) is OFF


@pytest.mark.parametrize("mode", FlightMode)
def test_an_empty_battery_always_stops(mode):
    assert mode_after(in_mode(mode), seen(charge=0.0)) is OFF


@pytest.mark.parametrize("request_", [ModeRequest.ARM, ModeRequest.TAKE_OFF])
@pytest.mark.parametrize(
    ("mode", "expected"),
    [
        (OFF, ARMED),
        (ARMED, ARMED),
        (TAKING_OFF, TAKING_OFF),
        (HOVERING, HOVERING),
        (LANDING, LANDING),
    ],
)
def test_arm_and_take_off(request_, mode, expected):
    assert mode_after(in_mode(mode), asked(request_)) is expected


@pytest.mark.parametrize(
    ("mode", "expected"),
    [(OFF, OFF), (ARMED, OFF), (TAKING_OFF, LANDING), *[(m, LANDING) for m in FLYING]],
)
def test_land(mode, expected):
    assert mode_after(in_mode(mode), asked(ModeRequest.LAND)) is expected


@pytest.mark.parametrize(
    ("mode", "expected"),
    [(OFF, OFF), (ARMED, ARMED), (TAKING_OFF, HOVERING), (HOVERING, HOVERING), (LANDING, LANDING)],
)
def test_hold(mode, expected):
    assert mode_after(in_mode(mode), asked(ModeRequest.HOLD)) is expected


def test_a_hold_ends_a_take_off_before_it_leaves_the_ground():
    spooling = in_mode(ARMED, target=2.0)
    held = after(spooling, asked(ModeRequest.HOLD))
    assert (FlightMode(int(held.mode)), held.target) == (ARMED, 0.0)
    assert mode_after(held, seen(time=100.0, serial=2.0)) is ARMED


@pytest.mark.parametrize("mode", [TAKING_OFF, *FLYING])
def test_a_battery_at_its_reserve_lands(mode):
    assert mode_after(in_mode(mode), seen(charge=0.21)) is not LANDING
    assert mode_after(in_mode(mode), seen(charge=0.2)) is LANDING


@pytest.mark.parametrize("mode", [OFF, ARMED])
def test_a_battery_at_its_reserve_stays_on_the_ground(mode):
    assert mode_after(in_mode(mode), seen(charge=0.1)) is mode


@pytest.mark.parametrize(
    "request_", [ModeRequest.ARM, ModeRequest.TAKE_OFF, ModeRequest.LAND, ModeRequest.STOP]
)
def test_a_request_counts_once(request_):
    """Its serial number has been seen, so it is an old one."""
    assert mode_after(in_mode(OFF), seen(request=int(request_))) is OFF
    assert mode_after(in_mode(HOVERING), seen(request=int(request_))) is HOVERING
    assert after(in_mode(HOVERING), asked(request_)).serial == 2.0


def test_a_take_off_spools_up_on_the_ground_first():
    armed = after(in_mode(OFF), asked(ModeRequest.TAKE_OFF, height=2.5))
    assert (armed.mode, armed.since, armed.target) == (ARMED, 20.0, 2.5)
    soon = seen(serial=2.0, time=20.0 + SPOOL_UP_TIME_S - 0.01)
    assert mode_after(armed, soon) is ARMED
    up = after(armed, seen(serial=2.0, time=20.0 + SPOOL_UP_TIME_S))
    assert (up.mode, up.target, up.x, up.y) == (TAKING_OFF, 2.5, P[0], P[1])


def test_armed_without_a_take_off_it_waits():
    assert mode_after(in_mode(ARMED), seen(time=1000.0)) is ARMED


def test_a_drone_armed_for_long_takes_off_at_the_next_update():
    ready = after(in_mode(ARMED), asked(ModeRequest.TAKE_OFF, height=2.0))
    assert mode_after(ready, seen(serial=2.0, time=20.1)) is TAKING_OFF


@pytest.mark.parametrize(
    ("z", "v_z", "expected"),
    [
        (2.0, 0.0, HOVERING),
        (1.96, 0.19, HOVERING),
        (2.04, -0.19, HOVERING),
        (1.94, 0.0, TAKING_OFF),
        (2.0, MAX_HOVERING_SPEED, TAKING_OFF),
        (0.0, 0.0, TAKING_OFF),
    ],
)
def test_a_take_off_ends_at_its_height_and_nearly_at_rest(z, v_z, expected):
    state = in_mode(TAKING_OFF, target=2.0)
    now = seen(p_WB=[1.0, 2.0, z], v_WB=[0.0, 0.0, v_z])
    assert mode_after(state, now) is expected


def test_a_take_off_ends_holding_where_it_was_meant_to_go():
    state = after(in_mode(TAKING_OFF, target=3.02), seen())
    assert (state.holding, state.x, state.y, state.z) == (1.0, 7.0, 8.0, 3.02)


@pytest.mark.parametrize("mode", FLYING)
@pytest.mark.parametrize(
    ("v_WB", "expected"),
    [
        ([0.0, 0.0, 0.0], HOVERING),
        ([0.19, 0.0, -0.19], HOVERING),
        ([0.15, 0.15, 0.0], CRUISING),  # 0.21 along the diagonal
        ([-3.0, 0.0, 2.0], CRUISING),
        ([1.0, 0.0, 1.0], CRUISING),
        ([1.0, 0.0, 1.1], ASCENDING),
        ([0.0, 0.0, 0.21], ASCENDING),
        ([0.0, 0.1, -0.21], DESCENDING),
    ],
)
def test_flying_is_named_by_where_it_goes(mode, v_WB, expected):
    assert mode_after(in_mode(mode), seen(v_WB=v_WB)) is expected


def test_a_mode_remembers_since_when_it_lasts():
    assert after(in_mode(HOVERING), seen()).since == 10.0
    assert after(in_mode(HOVERING), seen(v_WB=[1.0, 0.0, 0.0])).since == 20.0


@pytest.mark.parametrize("field", ["v_x", "v_y", "v_z", "follow"])
def test_who_is_asked_to_go_somewhere_holds_nothing(field):
    now = seen(reference=NOTHING._replace(**{field: -1.0}))
    assert after(in_mode(HOVERING, holding=1.0), now).holding == 0.0
    assert after(in_mode(HOVERING), now).holding == 0.0


def test_left_alone_it_holds_the_point_where_it_will_stop():
    state = after(in_mode(HOVERING), seen(v_WB=[0.1, -0.1, 0.05]))
    stop = [p + STOPPING_TIME_S * v for p, v in zip(P, [0.1, -0.1, 0.05], strict=True)]
    assert state.holding == 1.0
    assert [state.x, state.y, state.z] == pytest.approx(stop)


def test_a_held_point_stays_and_a_turn_on_the_spot_keeps_it():
    state = in_mode(HOVERING, holding=1.0)
    turning = seen(reference=NOTHING._replace(yaw_rate=0.3))
    for now in (seen(), turning, seen(v_WB=[0.1, 0.0, 0.0])):
        kept = after(state, now)
        assert (kept.holding, kept.x, kept.y, kept.z) == (1.0, 7.0, 8.0, 9.0)


def test_fast_and_left_alone_it_brakes_before_it_holds():
    assert after(in_mode(CRUISING), seen(v_WB=[2.0, 0.0, 0.0])).holding == 0.0


def test_a_landing_ends_when_it_has_stood_still_long_enough():
    state = in_mode(LANDING, since=15.0, still_since=20.0, holding=1.0)
    assert mode_after(state, seen(time=20.0 + MIN_TOUCH_DOWN_TIME_S - 0.01)) is LANDING
    assert mode_after(state, seen(time=20.0 + MIN_TOUCH_DOWN_TIME_S)) is OFF


def test_a_landing_that_stands_still_in_the_air_goes_on(case):
    """A drone that does not sink must not have its motors stopped up there.

    It may be tuned too weakly, or something pushes it up. An estimated height does not count.
    """
    state = in_mode(LANDING, since=10.0, still_since=10.0, holding=1.0)
    for above, health in ((0.2, None), (0.2, WELL), (0.0, WELL)):
        with case(above, health):
            assert mode_after(state, seen(standing_height=P[2] - above, health=health)) is LANDING


def test_a_landing_that_something_carries_ends_after_two_seconds():
    state = in_mode(LANDING, since=10.0, still_since=18.0, holding=1.0)
    above = seen(standing_height=P[2] - 0.2, contact_force=(0.0, 0.0, 0.1))
    assert mode_after(state, above) is OFF
    assert mode_after(state, above._replace(time=19.9)) is LANDING
    assert mode_after(state, above._replace(v_WB=[0.0, 0.0, -0.1])) is LANDING


def test_only_a_contact_force_that_points_up_carries(case):
    """Neither a ceiling nor the friction at a wall, whose coefficient is 0.9 here."""
    state = in_mode(LANDING, since=10.0, still_since=10.0, holding=1.0)
    for force, mode in (
        ((0.9, 0.0, 1.0), OFF),
        ((0.0, -0.9, 1.0), OFF),
        ((1.0, 0.0, 0.9), LANDING),
        ((0.0, -1.0, 0.9), LANDING),
        ((0.0, 0.0, -1.0), LANDING),
        ((0.0, 0.0, 0.0), LANDING),
    ):
        with case(force):
            now = seen(standing_height=P[2] - 0.2, contact_force=force)
            assert mode_after(state, now) is mode


def test_a_landing_at_speed_brakes_before_it_sinks():
    state = after(in_mode(CRUISING), asked(ModeRequest.LAND, v_WB=[8.0, 0.0, 0.0]))
    assert guidance(state, P, SETTINGS).climb == 0.0
    braked = after(state, seen(serial=2.0, time=22.0, v_WB=[0.1, 0.0, 0.0]))
    assert (braked.holding, braked.x) == (1.0, pytest.approx(P[0] + 0.025))
    assert guidance(braked, P, SETTINGS).climb < 0.0


def test_a_take_off_that_no_longer_climbs_becomes_a_hover_where_it_is():
    state = in_mode(TAKING_OFF, target=200.0, still_since=16.0)
    stuck = after(state, seen())
    assert (stuck.mode, stuck.z) == (HOVERING, P[2])
    assert mode_after(state, seen(v_WB=[0.0, 0.0, 0.5])) is TAKING_OFF


def test_a_take_off_takes_a_new_height():
    assert after(in_mode(TAKING_OFF, target=9.0), asked(ModeRequest.TAKE_OFF)).target == 1.5


def test_a_landing_that_moves_goes_on():
    state = in_mode(LANDING, still_since=10.0, holding=1.0)
    moving = seen(v_WB=[0.0, 0.0, -2.0 * MAX_TOUCH_DOWN_SPEED])
    assert after(state, moving) == state._replace(still_since=20.0)


def test_a_landing_from_hover_is_not_over_before_it_sinks():
    """At its beginning it stands still in the air."""
    state = after(in_mode(HOVERING), asked(ModeRequest.LAND))
    assert (state.mode, state.since, state.still_since) == (LANDING, 20.0, 20.0)
    now = seen(serial=2.0, time=20.0 + MIN_TOUCH_DOWN_TIME_S)
    assert mode_after(after(state, now), seen(serial=2.0, time=20.6)) is LANDING


def test_nothing_is_changed_in_place():
    state, now = in_mode(HOVERING), asked(ModeRequest.LAND)
    before = (tuple(state), repr(now))
    assert after(state, now) == after(state, now)
    assert (tuple(state), repr(now)) == before


def outcome(state: ModeState, now: FlightModeInputs) -> tuple[FlightMode, Reason]:
    found = after(state, now)
    return FlightMode(int(found.mode)), Reason(int(found.reason))


def test_what_an_estimate_lacks_decides_and_is_said(case):
    """Limits: 5 m, or 5 s without GPS; 0.1 s of one reading; it is said after 1 s and 2 s."""
    for health, mode, reason in (
        (WELL, HOVERING, Reason.NONE),
        (WELL._replace(deviation=5.0), HOVERING, Reason.NONE),
        (WELL._replace(deviation=5.1), LANDING, Reason.POSITION_LOST),
        (WELL._replace(gps_age=60.0), HOVERING, Reason.DEAD_RECKONING),  # 0.5 m are known
        (NO_DEVIATION._replace(gps_age=5.0), HOVERING, Reason.DEAD_RECKONING),
        (NO_DEVIATION._replace(gps_age=5.1), LANDING, Reason.POSITION_LOST),
        (WELL._replace(gps_age=1.0, heading_age=2.0), HOVERING, Reason.NONE),
        (WELL._replace(gps_age=1.1, heading_age=2.1), HOVERING, Reason.DEAD_RECKONING),
        (WELL._replace(heading_age=2.1), HOVERING, Reason.HEADING_DRIFTS),
        (WELL._replace(imu_age=0.1), HOVERING, Reason.NONE),
        (WELL._replace(imu_age=0.11), OFF, Reason.IMU_FAILED),
    ):
        with case(health):
            assert outcome(in_mode(HOVERING), seen(health=health)) == (mode, reason)
    assert outcome(in_mode(HOVERING, reason=3.0), seen(health=WELL)) == (HOVERING, Reason.NONE)


def test_a_frozen_imu_stops_each_mode_but_that_without_rotors(case):
    for mode in FlightMode:
        with case(mode):
            reason = Reason.NONE if mode is OFF else Reason.IMU_FAILED
            now = seen(health=WELL._replace(imu_age=0.2))
            assert outcome(in_mode(mode), now) == (OFF, reason)


def test_the_known_charge_lands_and_the_true_one_stops_the_rotors(case):
    for charge, known, mode, reason in (
        (0.1, 0.9, HOVERING, Reason.NONE),
        (0.9, 0.2, LANDING, Reason.BATTERY_LOW),
        (0.0, 0.9, OFF, Reason.BATTERY_EMPTY),
        (0.1, None, LANDING, Reason.BATTERY_LOW),
    ):
        with case(charge, known):
            now = seen(charge=charge, known_charge=known)
            assert outcome(in_mode(HOVERING), now) == (mode, reason)


def test_a_program_that_has_ended_holds_the_mode_until_it_is_stopped():
    ended = (HOVERING, Reason.AUTOPILOT_ENDED)
    assert outcome(in_mode(HOVERING), seen(ended=True, charge=0.0)) == ended
    assert outcome(in_mode(HOVERING), asked(ModeRequest.LAND, ended=True)) == ended
    assert mode_after(in_mode(HOVERING), asked(ModeRequest.STOP, ended=True)) is OFF


def test_a_landing_that_loses_its_position_sinks_at_once_and_holds_no_point():
    """Also one that was braking, which it cannot do any more."""
    lost = seen(health=WELL._replace(deviation=9.0), v_WB=[3.0, 0.0, 0.0])
    for mode in (HOVERING, LANDING):
        state = after(in_mode(mode), lost)
        assert (state.mode, state.reason) == (LANDING, Reason.POSITION_LOST)
        found = guidance(state, P, SETTINGS)
        assert (found.climb, found.hold_xy) == (
            -0.5,
            0.0,
        )  # half a metre a second a metre above 2 m


def test_a_landing_without_a_position_ends_where_the_ground_arrests_it(case):
    """It sinks at 0.4 m/s: within half a metre of standing, half of that for 0.2 s is the ground.

    Higher up, something carries it for 2 s: the estimate of the height is doubted, too.
    """
    still_since = 20.0
    for above, v_z, held, mode in (
        (0.4, 0.0, 0.21, OFF),
        (0.4, 0.0, 0.19, LANDING),
        (0.4, -0.19, 0.21, OFF),
        (0.4, 0.3, 0.21, OFF),
        (0.4, -0.21, 9.0, LANDING),
        (0.4, -0.4, 9.0, LANDING),
        (0.6, 0.0, 1.99, LANDING),
        (0.6, 0.0, 2.01, OFF),
        (0.6, -0.19, 9.0, LANDING),
        (0.6, 0.3, 9.0, LANDING),
    ):
        force = (0.0, 0.0, 1.0 if above > 0.5 else 0.0)
        with case(above, v_z, held):
            reason = float(Reason.POSITION_LOST)
            state = in_mode(LANDING, still_since=still_since, holding=1.0, reason=reason)
            now = seen(
                time=still_since + held,
                v_WB=[0.0, 0.0, v_z],
                standing_height=P[2] - above,
                health=WELL._replace(deviation=9.0),
                contact_force=force,
            )
            assert outcome(state, now) == (mode, Reason.POSITION_LOST)


def test_a_landing_on_an_estimate_stands_for_longer_where_it_seems_to_be_in_the_air(case):
    for above, held, mode in ((0.0, 0.51, OFF), (0.2, 1.99, LANDING), (0.2, 2.01, OFF)):
        with case(above, held):
            state = in_mode(LANDING, still_since=20.0, holding=1.0)
            now = seen(
                time=20.0 + held,
                standing_height=P[2] - above,
                health=WELL,
                contact_force=(0.0, 0.0, 1.0),
            )
            assert mode_after(state, now) is mode


def test_a_landing_is_aborted_in_the_air_alone(case):
    for height, above, mode in (
        (5.0, 1.0, TAKING_OFF),
        (0.01, 1.0, HOVERING),
        (5.0, 0.05, LANDING),
    ):
        with case(height, above):
            now = asked(ModeRequest.ABORT_LANDING, height=height, standing_height=P[2] - above)
            state = after(in_mode(LANDING), now)
            assert FlightMode(int(state.mode)) is mode
            assert state.target == (height if mode is TAKING_OFF else 0.0)


def test_a_landing_sinks_fast_from_high_up_and_slowly_at_last(case):
    for z, sink in ((100.0, 2.0), (4.0, 1.0), (2.8, 0.4), (1.0, 0.4), (-3.0, 0.4)):
        with case(z):
            found = guidance(in_mode(LANDING, holding=1.0), [0.0, 0.0, z], SETTINGS)
            assert found.climb == pytest.approx(-sink)


@pytest.mark.parametrize(
    ("state", "expected"),
    [
        (in_mode(OFF), Guidance(0, 0, 0, 0, 0, 0, 7, 8, 9)),
        (in_mode(ARMED), Guidance(1, 0, 0, 0, 0, 0, 7, 8, 9)),
        (in_mode(TAKING_OFF, target=30.0), Guidance(1, 1, 0, 1.0, 1, 0, 7, 8, 9)),
        (in_mode(TAKING_OFF, target=3.2), Guidance(1, 1, 0, 0.3, 1, 0, 7, 8, 9)),  # 1.5 * 0.2
        (in_mode(LANDING), Guidance(1, 1, 0, 0, 0, 0, 7, 8, 9)),
        # a metre above the 2 m from which a landing is slow, at half a metre a second a metre
        (in_mode(LANDING, holding=1.0), Guidance(1, 1, 0, -0.5, 1, 0, 7, 8, 9)),
        *[(in_mode(m), Guidance(1, 1, 1, 0, 0, 0, 7, 8, 9)) for m in FLYING],
        (in_mode(HOVERING, holding=1.0), Guidance(1, 1, 1, 0, 1, 1, 7, 8, 9)),
    ],
)
def test_guidance_of_each_mode(state, expected):
    assert guidance(state, P, SETTINGS) == pytest.approx(expected)


AHEAD = [1.0, 0.0, 0.0, 2.0]
BELOW = [0.0, 0.0, -1.0, 3.0]
NO_WALL = [0.0, 0.0, 0.0, math.inf]
BRAKING = SETTINGS._replace(obstacle_brake=1.2, stop_distance=0.5)


def walled(walls, mode=HOVERING, settings=BRAKING) -> list[float]:
    """Return what `with_walls` adds to a guidance, the rest of which stays as it was."""
    plain = guidance(in_mode(mode), P, settings)
    found = with_walls(plain, [x for wall in walls for x in wall], P, mode, settings)
    assert found[:9] == plain[:9]
    return list(found[9:])


def test_walls_are_places_to_stop_at_along_their_directions():
    found = walled([AHEAD, BELOW, NO_WALL])
    ahead = [1.0, 0.0, 0.0, P[0] + 2.0 - 0.5]
    below = [0.0, 0.0, -1.0, -P[2] + 3.0 - 0.5]
    assert found == pytest.approx([1.2, *ahead, *below, 0, 0, 0, 0])


def test_without_a_brake_there_are_no_walls():
    assert walled([AHEAD, BELOW, NO_WALL], settings=SETTINGS) == [0.0] * 13


def test_a_landing_comes_down_on_what_is_below():
    ahead = [1.0, 0.0, 0.0, P[0] + 2.0 - 0.5]
    assert walled([BELOW, AHEAD, NO_WALL], LANDING) == pytest.approx(
        [1.2, 0, 0, 0, 0, *ahead, 0, 0, 0, 0]
    )


def test_a_flight_begins_on_the_ground_or_holding_its_place():
    assert initial_state(OFF, P) == (OFF, 0, 0, 0, 0, 0, *P, 0)
    assert initial_state(HOVERING, P) == (HOVERING, 0, 0, 0, 0, 1, *P, 0)


def test_modes_have_names_to_show():
    assert TAKING_OFF.label == "taking off"
    assert [mode.value for mode in FlightMode] == list(range(8))
