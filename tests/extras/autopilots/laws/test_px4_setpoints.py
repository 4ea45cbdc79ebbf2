"""Setpoints of PX4's law by geometry: a limited velocity, and a heading that goes round."""

import math

import numpy as np
import pytest

from workbench.control.controller_file import load_controller
from workbench.control.flight_law import flight_law
from workbench.control.guidance import Guidance, LawSetpoint, MeasuredMotion, Reference
from workbench.control.law_constants import known_body, known_vehicle, law_constants
from workbench.extras.autopilots.laws.px4 import constrained_velocity
from workbench.gains.gain_choice import flight_gains
from workbench.scenario.attitude_axes import find_attitude_axis
from workbench.scenario.scenario import Action, Scenario
from workbench.session.hover_attitude import hover_attitude
from workbench.session.session import Session

LIMIT = 5.0


def test_within_the_limit_a_velocity_keeps_what_the_place_asks_for():
    """The first is kept whole, and as much is added of the second as the circle has room for."""
    random = np.random.default_rng(3)
    for _ in range(200):
        first, second = random.uniform(-4.0, 4.0, (2, 2))
        first *= min(1.0, 0.99 * LIMIT / np.hypot(*first))
        found = np.array(constrained_velocity(*first, *second, LIMIT))
        whole = first + second
        if np.hypot(*whole) <= LIMIT:
            assert found == pytest.approx(whole)
            continue
        added = found - first
        assert np.hypot(*found) == pytest.approx(LIMIT)
        assert added[0] * second[1] - added[1] * second[0] == pytest.approx(0.0, abs=1e-9)
        assert 0.0 <= added @ second <= second @ second
    assert constrained_velocity(6.0, 8.0, -3.0, 1.0, LIMIT) == pytest.approx((3.0, 4.0))


@pytest.mark.parametrize("yaw_rate", [0.4, -0.4])
def test_a_heading_goes_on_beyond_half_a_turn(vehicle, yaw_rate):
    law = load_controller("px4")
    constants = law_constants(vehicle)
    values = flight_gains(vehicle, controller=law)
    functions, period = flight_law(law), law.period
    g = functions.gains(law.gains(values, known_vehicle(constants), period))
    names = [state.name for state in law.memory]
    zero = (0.0, 0.0, 0.0)
    elapsed = tuple(n * period for n in law.dividers)
    asked = LawSetpoint(
        Reference(0, 0, 0, yaw_rate, *[0.0] * 4), Guidance(*[1.0] * 3, *[0.0] * 6), zero
    )
    for before in (math.copysign(math.pi - 1e-5, yaw_rate), 1.0):
        memory = list(law.initial_memory)
        memory[names.index("runs")], memory[names.index("yaw_sp")] = 1.0, before
        q = (math.cos(0.5 * before), 0.0, 0.0, math.sin(0.5 * before))
        level = MeasuredMotion(zero, zero, zero, q, zero, zero, (0.0, *zero), elapsed=elapsed)
        _, after = law.update(
            level, asked, g, known_body(constants), functions.memory(memory), period, None
        )
        heading = after[names.index("yaw_sp")]
        assert heading == pytest.approx(math.remainder(before + yaw_rate * period, math.tau))
        assert heading != before


def present_signal(session, place):
    """Return the signal of the next update of a flight at a loop point."""
    computer = session._bench.computer
    return computer.probed(session._live.context_of(computer), place, 0.0)


def test_loop_signals_are_known_between_two_updates_of_the_velocity():
    """The velocity runs in every fifth update of the law: only there an update has its error."""
    session = Session(Scenario(controller="px4"))
    session.do(Action(velocity=(1.0, 0.0, 0.0)))
    session.tick(0.25)
    place, known, read = session.controller.point_names.index("velocity_x_error"), [], []
    for _ in range(5):
        session.tick(session.scenario.rates.control_period)
        known.append(session.loop_signals()[place])
        read.append(present_signal(session, place))
    assert read.count(0.0) == 4
    assert abs(sum(read)) > 1e-3
    assert known == pytest.approx([sum(read)] * 5, rel=0.2)


@pytest.mark.slow
def test_the_setpoint_of_a_hover_is_known_between_two_updates_of_the_attitude():
    """Which runs in every fifth one of the law: in wind it is not that of level between them."""
    session = Session(Scenario(controller="px4"), {"wind_x": 6.0})
    session.tick(4.0)
    row, found, read = find_attitude_axis("pitch"), [], []
    place = session.controller.point_names.index(row.point)
    for _ in range(5):
        session.tick(session.scenario.rates.control_period)
        found.append(hover_attitude(session, row, 0.1))
        read.append(present_signal(session, place))
    assert read.count(0.0) == 4
    assert min(read) < -0.05
    for each in found:
        assert each.setpoint == pytest.approx(math.atan(min(read)), abs=2e-3)
        assert each.angle == pytest.approx(each.setpoint, abs=0.01)
