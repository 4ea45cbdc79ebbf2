"""Commands that come in while a session flies: when they act, and that a script does the same."""

import dataclasses

import numpy as np
import pytest

from workbench.link.authority import SilenceEffect
from workbench.link.backplane import VelocityCommand
from workbench.scenario.scenario import Action, Rates, Scenario, ScenarioStart
from workbench.session.session import Session
from workbench.systems.bridge import MAX_WAITING_COMMANDS, Bridge

STEP = Rates().physics_step


class Flight:
    """A session with a bridge, and a client that holds the lease."""

    def __init__(self, scenario: Scenario | None = None) -> None:
        self.bridge = Bridge()
        self.session = Session(scenario or Scenario(), bridge=self.bridge)
        self.seq = 0
        self.done = []
        self.lease = self.bridge.authority.request(1, "one", 0.0)

    def send(self, *velocity: float, yaw_rate: float = 0.0, lease: int | None = None) -> None:
        self.seq += 1
        t_ns = round(self.session.time * 1e9)
        lease = self.lease if lease is None else lease
        command = VelocityCommand(1, self.seq, t_ns, lease, 15, velocity, yaw_rate)
        self.bridge.command(command, self.session.time)

    def fly(self, steps: int) -> None:
        self.session.tick(steps * self.session.scenario.rates.physics_step)
        self.done += self.bridge.applied()


def test_a_command_acts_just_before_the_next_control_update():
    flight = Flight()
    flight.fly(9)  # the grant's HOLD came with the first update
    assert [(each.at / STEP, each.what) for each in flight.done] == [(0, SilenceEffect.HOLD)]
    flight.send(0.0, 0.0, 0.0)
    flight.send(1.0, 0.0, 0.0)
    flight.fly(6)  # the session stands at the update at step 8 until a whole period is due
    assert len(flight.done) == 1
    flight.fly(1)
    (applied,) = flight.done[1:]
    assert (applied.at / STEP, applied.by) == (8, "one")
    assert applied.what.velocity == (1.0, 0.0, 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("phase", range(8))
def test_silence_of_half_a_second_holds(phase):
    """From the step at which the last command came into force, whenever it was sent."""
    flight = Flight()
    flight.fly(16 + phase)
    flight.send(0.0, 0.0, 0.0)
    flight.fly(8)
    flight.send(1.0, 0.0, 0.0)
    flight.fly(8)
    last = flight.done[-1]
    assert last.what.velocity == (1.0, 0.0, 0.0)
    flight.fly(1024)
    held = flight.done[-1]
    assert held.what is SilenceEffect.HOLD
    assert held.at - last.at == 0.5


def test_a_repeated_command_renews_and_is_no_news():
    flight = Flight()
    for _ in range(40):
        flight.send(0.0, 0.0, 0.0)
        flight.fly(64)
    assert [each.what for each in flight.done] == [SilenceEffect.HOLD]
    assert flight.bridge.authority.state(flight.session.time).age < 0.1


def test_what_is_refused_is_told_and_changes_nothing():
    flight = Flight()
    flight.send(0.0, 0.0, 0.0)
    flight.send(float("nan"), 0.0, 0.0)
    flight.send(1.0, 0.0, 0.0, lease=5)
    flight.send(9.0, 0.0, 0.0)
    flight.fly(8)
    refused = flight.bridge.refused()
    assert [(each.seq, each.code) for each in refused] == [
        (3, "not_holder"),  # before it waits, the others at the update
        (2, "not_finite"),
        (4, "scaled"),
    ]
    assert flight.bridge.refused() == []
    assert flight.done[-1].what.velocity == (8.0, 0.0, 0.0)


def test_limits_are_those_of_the_flight_as_it_is_now():
    flight = Flight()
    flight.session.set("max_speed", 2.0)
    flight.send(0.0, 0.0, 0.0)
    flight.send(3.0, 0.0, 0.0)
    flight.send(4.5, 0.0, 0.0)
    flight.fly(8)
    assert [each.code for each in flight.bridge.refused()] == ["scaled", "too_fast"]
    assert flight.done[-1].what.velocity == (2.0, 0.0, 0.0)


def test_a_flood_leaves_the_neutral_command_and_the_newest():
    """In the mailbox: the first is the one without which a new holder may not fly."""
    flight = Flight()
    flight.send(0.0, 0.0, 0.0)
    for number in range(1, 10 * MAX_WAITING_COMMANDS + 1):
        flight.send(number / 512, 0.0, 0.0)
    flight.fly(8)
    assert flight.session.time == 8 * STEP
    assert flight.bridge.refused() == []
    assert flight.done[-1].what.velocity == (10 * MAX_WAITING_COMMANDS / 512, 0.0, 0.0)
    for _ in range(10 * MAX_WAITING_COMMANDS):
        flight.send(9.0, 0.0, 0.0)  # above the limit, so that each is told
    flight.fly(8)
    assert len(flight.bridge.refused()) == MAX_WAITING_COMMANDS


@pytest.mark.slow
@pytest.mark.parametrize(
    "rates",
    [
        Rates(),
        pytest.param(Rates(control_period=1 / 1024, record_period=1 / 128), marks=pytest.mark.slow),
        pytest.param(
            Rates(physics_step=1e-3, control_period=4e-3, mode_period=0.05, record_period=1e-3),
            marks=pytest.mark.slow,
        ),
    ],
    ids=["usual", "every step", "decimal, modes between"],
)
def test_a_script_flies_the_same_to_the_bit(rates):
    """Commands, silence, HOLD and LAND: what came into force, as actions of a scenario."""
    scenario = Scenario(rates=rates, start=ScenarioStart(position=[0.0, 0.0, 2.0]))
    flight = Flight(scenario)
    random = np.random.default_rng(5)
    flight.fly(3)
    flight.send(0.0, 0.0, 0.0)
    for _ in range(12):
        flight.fly(int(random.integers(1, 90)))
        flight.send(*random.uniform(-2.0, 2.0, 3), yaw_rate=float(random.uniform(-0.3, 0.3)))
    flight.fly(round(9.0 / rates.physics_step))
    effects = [each.what for each in flight.done if isinstance(each.what, SilenceEffect)]
    assert effects == [SilenceEffect.HOLD, SilenceEffect.HOLD, SilenceEffect.LAND]
    script = [
        Action(each.at, velocity=[0.0, 0.0, 0.0], yaw_rate=0.0)
        if each.what is SilenceEffect.HOLD
        else Action(each.at, velocity=[0.0, 0.0, 0.0], yaw_rate=0.0, request="land")
        if each.what is SilenceEffect.LAND
        else Action(each.at, velocity=list(each.what.velocity), yaw_rate=each.what.yaw_rate)
        for each in flight.done
    ]
    again = Session(dataclasses.replace(scenario, script=script))
    again.tick(flight.session.time)
    flown, repeated = flight.session.recording(), again.recording()
    for name in ("p_WB", "q_WB", "v_WB", "w_WB", "thrusts", "mode"):
        assert np.array_equal(getattr(flown, name), getattr(repeated, name)), name


def test_a_bridge_changes_no_bit_of_a_flight():
    script = [Action(0.5, velocity=[1.0, 0.0, 0.5]), Action(1.0, request="land")]
    flights = [
        Session(Scenario(duration=2.0, script=script), bridge=bridge) for bridge in (None, Bridge())
    ]
    for session in flights:
        session.run()
    plain, bridged = (session.recording() for session in flights)
    assert np.array_equal(plain.p_WB, bridged.p_WB)
    assert np.array_equal(plain.reference, bridged.reference)


def test_a_reset_forgets_what_waits():
    flight = Flight()
    flight.fly(9)
    flight.done.clear()
    flight.send(0.0, 0.0, 0.0)  # into the mailbox, until the next update
    flight.send(1.0, 0.0, 0.0, lease=flight.lease + 1)
    flight.bridge.reset()
    assert flight.bridge.drain() == [] and flight.bridge.refused() == []
    flight.fly(16)
    assert flight.done == [] and flight.bridge.refused() == []


def test_a_reset_leaves_nobody_in_control():
    flight = Flight()
    flight.send(0.0, 0.0, 0.0)
    flight.send(2.0, 0.0, 0.0)
    flight.session.reset()
    flight.fly(1024)
    assert flight.done == []
    assert flight.session.snapshot().v_WB == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
