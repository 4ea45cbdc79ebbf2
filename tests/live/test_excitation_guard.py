"""What an excitation needs, and what ends it: a tilt beyond the limit, a swing to both sides."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from workbench.live.excitation_guard import ExcitationGuard
from workbench.plant.gravity import GRAVITY
from workbench.scenario.excitation import Excitation, Shape
from workbench.scenario.scenario import Rates

MAX_TILT = 0.5


class MadeUpFlight:
    """A flight at rest in its place, whose attitude and rates a test sets."""

    def __init__(self) -> None:
        self.time, self.tilt, self.turn = 0.0, (0.0, 0.0), (0.0, 0.0)
        self.vehicle = SimpleNamespace(thrust_to_weight=2.0)
        self.scenario = SimpleNamespace(rates=Rates())
        self.heading, self.ways = 0.3, []

    def snapshot(self) -> SimpleNamespace:
        return SimpleNamespace(roll_pitch_yaw=(0.0, 0.0, self.heading))

    def free_way(self, direction: list[float], needed: float) -> tuple[float, str]:
        self.ways.append((direction, needed))
        return math.inf, ""

    def get(self, name: str) -> float:
        return {"max_tilt": MAX_TILT}[name]

    def state(self) -> np.ndarray:
        angle, direction = self.tilt
        sine = math.sin(0.5 * angle)
        q = [math.cos(0.5 * angle), sine * math.cos(direction), sine * math.sin(direction), 0.0]
        return np.array([*q, 0.0, 0.0, 5.0, *self.turn, 0.0, 0.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("name", "angle", "bearing"),
    [("pitch", 0.2, 0.0), ("pitch", -0.2, math.pi), ("roll", 0.2, -1.5708), ("roll", -0.2, 1.5708)],
)
def test_a_held_tilt_needs_room_where_it_leads(name, angle, bearing):
    """For a second at g tan(0.2); then half a second at that speed, 4 m/s² to a stop, and 0.1 m."""
    flight = MadeUpFlight()
    ExcitationGuard(flight, Excitation(name, Shape.STEP, angle, 1.0)).check_room()
    ((way, needed),) = flight.ways
    bearing += flight.heading
    assert way == pytest.approx([math.cos(bearing), math.sin(bearing), 0.0], abs=1e-4)
    speed = GRAVITY * math.tan(0.2)
    assert needed == pytest.approx(0.5 * speed + 0.5 * speed + speed**2 / 8.0 + 0.1, rel=0.01)


@pytest.mark.parametrize("direction", [0.0, 1.0, -2.0])
def test_a_tilt_may_go_20_degrees_beyond_the_limit(direction):
    flight = MadeUpFlight()
    guard = ExcitationGuard(flight)
    for beyond, told in ((19.0, False), (21.0, True)):
        flight.tilt = MAX_TILT + math.radians(beyond), direction
        assert ("it tilts by" in guard.trouble()) is told


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize(
    ("rates", "told"),
    [((1.5, -1.5), True), ((1.5, 1.5), False), ((-1.5, -1.5), False), ((1.5, -0.9), False)],
)
def test_after_a_second_from_the_step_only_rates_to_both_sides_are_a_swing(axis, rates, told):
    """Of 1 rad/s and more: a turn to one side is a drone on its way back."""
    flight = MadeUpFlight()
    guard = ExcitationGuard(flight)
    guard.step()
    for number in range(40):  # 2.5 s at 2 Hz
        flight.time = number / 16
        turn = [0.0, 0.0]
        turn[axis] = rates[number // 4 % 2]
        flight.turn = tuple(turn)
        trouble = guard.trouble()
        if flight.time < 1.0:
            assert trouble == ""
    assert ("86°/s to both sides" in trouble) is told
