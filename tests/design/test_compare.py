"""The numbers of a comparison from flights that are made up: what they are is known by hand."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from workbench.control.mode import FlightMode
from workbench.design import comparison_bench
from workbench.design.compare import compare_controllers
from workbench.design.comparison_bench import COMPARED_VEHICLES
from workbench.design.rollout.rollouts import Rollouts
from workbench.session.recording import Recording
from workbench.setup import Setup

MOTIONS = ("p_WB", "v_WB", "w_WB", "vdot_WB", "wdot_WB", "wind_W")
STEP = 1 / 128


def made_up(vehicle, duration, place, q=None, v_z=None) -> Recording:
    """Return a flight at places (N, 3), with attitudes (N, 4) and climb rates (N), hovering."""
    time = STEP * np.arange(round(duration / STEP) + 1)
    nothing = {name: np.zeros((len(time), 3)) for name in MOTIONS}
    nothing["p_WB"] = place(time)
    if v_z is not None:
        nothing["v_WB"][:, 2] = v_z(time)
    rotors = np.zeros((len(time), len(vehicle.rotors)))
    return Recording(
        vehicle=vehicle,
        time=time,
        q_WB=np.tile([1.0, 0.0, 0.0, 0.0], (len(time), 1)) if q is None else q(time),
        commanded_speeds=rotors,
        rotor_speeds=rotors,
        thrusts=rotors,
        reference=np.zeros((len(time), 8)),
        mode=np.full(len(time), float(FlightMode.HOVERING)),
        charge=np.ones(len(time)),
        clearance=np.full(len(time), np.inf),
        **nothing,
    )


def off(time, height, away) -> np.ndarray:
    """Return places (N, 3) as far from a place at a height as in a table of times and distances."""
    place = np.tile([2.0, -1.0, height], (len(time), 1))
    for begin, end, distance in away:
        place[(time >= begin) & (time < end)] += distance * np.array([0.6, 0.0, 0.8])
    return place


def pushed(vehicle, duration):
    """0.3 m off half a second after the push at 1 s, then within 5 cm but for 0.1 s at 3 s."""
    away = ((1.5, 2.0, 0.3), (2.0, 3.0, 0.04), (3.0, 3.1, 0.06), (3.1, 99.0, 0.04))
    return made_up(vehicle, duration, lambda time: off(time, 5.0, away))


def blown(vehicle, duration):
    """A metre off in the wind until the last second, and 2 cm from then on."""
    away = ((1.0, 30.0, 1.0), (30.0, 99.0, 0.02))
    return made_up(vehicle, duration, lambda time: off(time, 5.0, away))


def turned_over(vehicle, duration):
    """On its back for 1 s, then upright; it falls by 7 m until 2 s, and climbs until 2.5 s."""

    def q(time):
        back = np.array([0.0, 1.0, 0.0, 0.0])
        return np.where((time < 1.0)[:, None], back, [1.0, 0.0, 0.0, 0.0])

    def v_z(time):
        return np.where(time < 2.5, 1.5, 0.5)

    def place(time):
        return off(time, 50.0, ()) - 7.0 * np.minimum(time / 2.0, 1.0)[:, None] * [0.0, 0.0, 1.0]

    return made_up(vehicle, duration, place, q, v_z)


def test_numbers_of_push_fall_and_wind_are_those_by_hand(monkeypatch, vehicle):
    forces = []

    class Flown:
        """Stands for what flies."""

        def __init__(self, setup: Setup) -> None:
            self._scenario = setup.scenario

        def fly(self, progress, programs) -> "Flown":
            return self

        @property
        def recording(self) -> Recording:
            script, start = self._scenario.script, self._scenario.start
            fly = turned_over if start.roll_pitch_yaw[0] else pushed if script[0].push else blown
            if script and script[0].push:
                forces.append(script[0].push.force)
            return fly(vehicle, self._scenario.duration)

    monkeypatch.setattr(comparison_bench, "Flier", Flown)
    (found,) = compare_controllers(["pd"], parts=("push", "upside_down", "wind")).controllers
    assert found.remarks == {}
    numbers = found.numbers
    assert numbers["push_distance"] == pytest.approx(0.3)
    assert numbers["push_recovery"] == pytest.approx(2.1, abs=STEP)
    assert numbers["over_recovery"] == pytest.approx(2.5, abs=STEP)
    assert numbers["over_height"] == pytest.approx(7.0)
    assert numbers["wind_error"] == pytest.approx(0.02)
    (force,) = forces
    assert force == pytest.approx([0.0, 0.5 * vehicle.mass * 9.81, 0.0])


def second_order(time, command, damping):
    """Return the step of 100 / (s² + 20 ζ s + 100), which overshoots by exp(-π ζ / √(1 - ζ²))."""
    w = 10.0 * math.sqrt(1.0 - damping**2)
    swing = np.cos(w * time) + 10.0 * damping / w * np.sin(w * time)
    return command * (1.0 - np.exp(-10.0 * damping * time) * swing)


@pytest.mark.parametrize("unsteady", [{}, {5: "the air is turbulent"}])
def test_the_worst_overshoot_is_that_of_the_vehicles_that_are_not_lost(monkeypatch, unsteady):
    """Of eight one is lost in the step along y, and another overshoots by 25.4 % along z."""
    time = STEP * np.arange(1500)

    class Engine:
        """Stands for compiled flights."""

        def __init__(self, *args, **more) -> None:
            pass

        def fly(self, gains, axis, amplitude, *, duration, variations) -> Rollouts:
            assert len(gains) == 8 and tuple(variations) == COMPARED_VEHICLES
            dampings = [0.7] * 7 + [0.4 if axis == "z" else 0.7]
            steps = np.array([second_order(time, amplitude, each) for each in dampings])
            lost = np.full(8, math.nan)
            if axis == "y":
                lost[2], steps[2] = 1.0, 1e3
            motions = np.repeat((steps - 0.1)[:, :, None], 3, axis=2)
            none = np.zeros(8)
            return Rollouts(axis, time, motions, motions, none, lost, none, unsteady)

    decay = SimpleNamespace(of=lambda *of: 0.5)
    monkeypatch.setattr(comparison_bench, "RolloutEngine", Engine)
    monkeypatch.setattr(comparison_bench, "DecayTimes", lambda *of: decay)
    (found,) = compare_controllers(["pd"], parts=("vehicles",)).controllers
    assert found.numbers["lost"] == 1.0
    if unsteady:
        assert math.isnan(found.numbers["worst_overshoot"])
        assert "does not settle" in found.remarks["worst_overshoot"]
        return
    worst = 100.0 * math.exp(-math.pi * 0.4 / math.sqrt(1.0 - 0.16))
    assert found.numbers["worst_overshoot"] == pytest.approx(worst, rel=0.01)
    assert found.remarks["worst_overshoot"] == "of those that are not lost"
