"""Pacing, tried with a wall clock and a machine that are made up."""

import pytest

from workbench.live.flight_clock import FLIGHT_SLICE_S, MAX_FLIGHT_LAG_S, PACE_WINDOW_S, FlightClock

STEP = 1 / 1024


class Machine:
    """Flies what is due, where every step takes its time on a made-up wall clock."""

    def __init__(self, cost: float, speed: float = 1.0, step: float = STEP) -> None:
        self.now = 100.0
        self.cost = cost
        self.step = step
        self.steps = 0
        self.clock = FlightClock(step, self.now)
        self.clock.set_speed(speed, self.now)

    def run(self, seconds: float) -> None:
        end = self.now + seconds
        while self.now < end:
            due = self.clock.due(self.now)
            if not due:
                self.now += min(self.clock.wait(self.now), end - self.now) + 1e-9
                continue
            self.now += due * self.cost
            self.steps += due
            self.clock.flown(due, self.now)

    @property
    def flown(self) -> float:
        return self.steps * self.step


@pytest.mark.parametrize("speed", [0.01, 0.25, 1.0, 3.0, 20.0])
def test_a_quick_machine_flies_as_many_seconds_as_are_asked_for(speed):
    machine = Machine(cost=STEP / 50.0, speed=speed)
    machine.run(10.0)
    slice_ = machine.clock.slice * STEP
    assert 10.0 * speed - 2 * slice_ <= machine.flown <= 10.0 * speed + 1e-9
    pace = machine.clock.pace(machine.now)
    assert pace.achieved == pytest.approx(speed, rel=0.15)  # a window of few slices is coarse
    assert (pace.asked, pace.given_up, pace.slow) == (speed, 0.0, False)


@pytest.mark.parametrize("step", [1 / 256, 0.01])
def test_a_slow_flight_of_long_steps_moves(step):
    """A step takes up to a second of wall time here, more than a flight may fall behind else."""
    machine = Machine(cost=step / 50.0, speed=0.01, step=step)
    machine.run(20.0)
    assert machine.flown == pytest.approx(0.2, abs=2 * step)
    assert machine.clock.pace(machine.now).given_up == 0.0


def test_nothing_is_due_early():
    clock = FlightClock(STEP, 5.0)
    assert clock.slice == 8
    assert clock.due(5.0) == 0
    assert clock.wait(5.0) == FLIGHT_SLICE_S
    assert clock.due(5.0 + 0.9 * FLIGHT_SLICE_S) == 0
    assert clock.due(5.0 + FLIGHT_SLICE_S) == 8
    clock.flown(8, 5.0 + FLIGHT_SLICE_S)
    assert clock.due(5.0 + 1.5 * FLIGHT_SLICE_S) == 0
    assert clock.wait(5.0 + 1.5 * FLIGHT_SLICE_S) == pytest.approx(0.5 * FLIGHT_SLICE_S)


def test_a_slow_machine_falls_behind_by_a_bound_and_says_so():
    """Each step takes twice its time: half of the wall time is flown, the rest is given up."""
    machine = Machine(cost=2.0 * STEP)
    machine.run(10.0)
    assert machine.flown == pytest.approx(5.0, abs=0.1)
    pace = machine.clock.pace(machine.now)
    assert pace.achieved == pytest.approx(0.5, abs=0.02)
    assert pace.lag <= MAX_FLIGHT_LAG_S + 2.0 * FLIGHT_SLICE_S + 1e-9
    assert pace.given_up == pytest.approx(5.0 - MAX_FLIGHT_LAG_S, abs=0.05)
    assert pace.slow
    said = str(pace)
    assert "0.50 times real time instead of 1" in said
    assert "slower" in said


def test_a_machine_that_is_quick_again_is_on_time_again_and_says_so():
    machine = Machine(cost=2.0 * STEP)
    machine.run(5.0)
    machine.cost = STEP / 50.0
    before = machine.flown
    machine.run(5.0)
    # the bound it was behind by, and no more, is caught up
    assert machine.flown - before == pytest.approx(5.0 + MAX_FLIGHT_LAG_S, abs=0.03)
    pace = machine.clock.pace(machine.now)
    assert not pace.slow
    assert pace.achieved == pytest.approx(1.0, abs=0.02)
    assert str(pace).endswith(" times real time")
    assert machine.clock.pace(machine.now).lag == 0.0  # since the pace before


def test_a_machine_that_slept_does_not_run_after_the_clock():
    machine = Machine(cost=STEP / 50.0)
    machine.run(2.0)
    machine.now += 60.0
    machine.run(2.0)
    assert machine.flown == pytest.approx(4.0 + MAX_FLIGHT_LAG_S, abs=2 * FLIGHT_SLICE_S)
    assert machine.clock.pace(machine.now).given_up == pytest.approx(
        60.0 - MAX_FLIGHT_LAG_S, abs=0.02
    )


def test_in_a_pause_nothing_is_due_and_nothing_is_owed_after_it():
    machine = Machine(cost=STEP / 50.0)
    machine.run(1.0)
    machine.clock.pause()
    assert machine.clock.paused
    assert machine.clock.wait(machine.now) == float("inf")
    machine.now += 30.0
    assert machine.clock.due(machine.now) == 0
    assert machine.clock.pace(machine.now).achieved == 0.0
    machine.clock.resume(machine.now)
    machine.run(1.0)
    assert machine.flown == pytest.approx(2.0, abs=2 * FLIGHT_SLICE_S)
    pace = machine.clock.pace(machine.now)
    assert (pace.given_up, pace.slow) == (0.0, False)


def test_resuming_a_flight_that_goes_on_changes_nothing():
    machine = Machine(cost=STEP / 50.0)
    machine.run(0.5 * FLIGHT_SLICE_S)
    machine.clock.resume(machine.now)
    machine.run(0.6 * FLIGHT_SLICE_S)
    assert machine.steps == 8


def test_the_achieved_factor_is_that_of_the_last_second():
    machine = Machine(cost=2.0 * STEP)
    machine.run(30.0)
    machine.cost = STEP / 50.0
    machine.run(3.0 * PACE_WINDOW_S)
    assert machine.clock.pace(machine.now).achieved == pytest.approx(1.0, abs=0.02)


def test_a_new_speed_holds_from_then_on():
    machine = Machine(cost=STEP / 100.0)
    machine.run(2.0)
    machine.clock.set_speed(4.0, machine.now)
    machine.run(2.0)
    assert machine.flown == pytest.approx(10.0, abs=0.1)


def test_a_machine_whose_slices_take_longer_than_the_window_is_told_its_own_pace():
    machine = Machine(cost=1.5 * PACE_WINDOW_S / 8)
    machine.run(6.0 * PACE_WINDOW_S)
    assert machine.clock.slice == 8
    assert machine.clock.pace(machine.now).achieved == pytest.approx(STEP / machine.cost, rel=1e-6)
