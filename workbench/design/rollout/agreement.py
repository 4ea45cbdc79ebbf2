"""How far compiled flights are from those of the full diagram, for any vehicle.

Flights that are hard to agree on: random gains, commands that saturate rotors and tilt, and drones
that are thrown, turning and at any attitude.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from workbench.common.errors import FlightBrokenError
from workbench.control.controller import COMMON, Controller
from workbench.design.rollout.candidates import start_state
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.rollout.senses import make_senses
from workbench.gains.gains import flight_gains
from workbench.plant.vehicle import Vehicle
from workbench.scenario.parameters import parameter_table
from workbench.scenario.scenario import Scenario, Start, at_own_period
from workbench.session.recording import Recording
from workbench.session.session import Session

HEIGHT = 50.0
"""At which trials begin, with the ceiling far above: nothing ends them early [m]."""
CEILING = 100.0
SPREAD = 2.0
"""Gains are between this part of the vehicle's own and this many times as much."""
FASTEST, CLIMB, TURN = 8.0, 4.0, 1.0
"""Of commands: level and vertical speed [m/s] and yaw rate [rad/s]."""
THROWN_SPEED, THROWN_RATE = 5.0, 6.0
"""Of what is thrown, on each axis [m/s, rad/s]."""
SATURATED = 0.995
"""Share of its speed limit from which a rotor counts as saturated."""


@dataclass(frozen=True)
class Trial:
    """A flight for both.

    Attributes:
        gains: parameter values by name.
        start: motion at the beginning.
        command: velocity in W [m/s] and yaw rate [rad/s] (4).
    """

    gains: Mapping[str, float]
    start: Start
    command: tuple[float, float, float, float]


@dataclass(frozen=True)
class Agreement:
    """Largest differences of N flights, each (N), up to where the compiled one is lost.

    Attributes:
        position: of the base link's origin, length of the difference [m].
        attitude: angle of the rotation between the two [rad].
        velocity: of that origin, length of the difference [m/s].
        angular_velocity: the same [rad/s].
        saturated: whether a rotor ran at its limit.
        lost: whether the flight was lost.
    """

    position: np.ndarray
    attitude: np.ndarray
    velocity: np.ndarray
    angular_velocity: np.ndarray
    saturated: np.ndarray
    lost: np.ndarray


def random_trials(
    vehicle: Vehicle,
    own: Mapping[str, float],
    count: int,
    seed: int,
    controller: Controller | None = None,
) -> list[Trial]:
    """Return trials of which every other is thrown.

    Args:
        vehicle: that flies.
        own: values by name of the gains that are drawn, around which they are.
        count: how many.
        seed: of what is drawn.
        controller: whose gains they are; the default one where none is given.
    """
    table = parameter_table(controller)
    rng = np.random.default_rng(seed)
    rows = table.controller.parameters
    common = {row.name for row in COMMON}
    tuned = [row.name for row in rows if row.name in own and row.name not in common]
    trials = []
    for number in range(count):
        gains = {"max_height": CEILING}
        for name in tuned:
            row = table.find(name)
            value = own[name] * SPREAD ** rng.uniform(-1.0, 1.0)
            gains[name] = float(np.clip(value, row.minimum, row.maximum))
        start = Start(position=[0.0, 0.0, HEIGHT])
        if number % 2:
            start.roll_pitch_yaw = rng.uniform(-np.pi, np.pi, 3).tolist()
            start.velocity = rng.uniform(-THROWN_SPEED, THROWN_SPEED, 3).tolist()
            start.angular_velocity = rng.uniform(-THROWN_RATE, THROWN_RATE, 3).tolist()
        most = np.array([FASTEST, FASTEST, CLIMB, TURN])
        v_x, v_y, v_z, turn = (most * rng.uniform(-1.0, 1.0, 4)).tolist()
        trials.append(Trial(gains, start, (v_x, v_y, v_z, turn)))
    return trials


def agreement(
    scenario: Scenario,
    trials: Sequence[Trial],
    *,
    duration: float = 5.0,
    progress: Callable[[float], None] | None = None,
) -> Agreement:
    """Fly trials on the full diagram and on the compiled engine, and compare them.

    Args:
        scenario: its vehicle, estimator, sensors and rates fly; start and script are the trials'.
        trials: N of them.
        duration: of each [s].
        progress: called with the share done.

    Raises:
        WorkbenchError: if the vehicle cannot be flown.
    """
    scenario = at_own_period(scenario)
    rates = replace(scenario.rates, record_period=scenario.rates.control_period)
    session = Session(
        Scenario(
            vehicle=scenario.vehicle,
            controller=scenario.controller,
            estimator=scenario.estimator,
            sensors=scenario.sensors,
            rates=rates,
            duration=duration,
        )
    )
    law = session.controller
    own = flight_gains(session.vehicle, scenario.vehicle.gains, controller=law)
    variation = scenario.vehicle.variation
    engine = RolloutEngine(
        session.vehicle,
        rates,
        variation,
        seed=scenario.sensors.seed,
        own=own,
        controller=law,
        senses=make_senses(session.vehicle, scenario),
    )
    flights = engine.fly_from(
        [each.gains for each in trials],
        np.array([start_state(session.vehicle, each.start) for each in trials]),
        np.array([each.command for each in trials]),
        duration=duration,
    )
    count = len(trials)
    found = Agreement(
        *np.zeros((4, count)),
        saturated=flights.peak_rotor_use >= SATURATED,
        lost=np.isfinite(flights.diverged_at),
    )
    for number, trial in enumerate(trials):
        flown = _flown(session, trial, duration)
        states = flights.states[number, : len(flown.time)]
        turned = 2.0 * np.abs(_between(states[:, 0:4], flown.q_WB))
        for differences, apart in (
            (found.position, states[:, 4:7] - flown.p_WB),
            (found.attitude, turned),
            (found.velocity, states[:, 10:13] - flown.v_WB),
            (found.angular_velocity, states[:, 7:10] - flown.w_WB),
        ):
            lengths = np.linalg.norm(apart, axis=1)
            differences[number] = np.nanmax(lengths, initial=0.0) if len(apart) else np.inf
        if progress:
            progress((number + 1) / count)
    return found


def _flown(session: Session, trial: Trial, duration: float) -> Recording:
    """Return a flight on the diagram, recorded at each control period."""
    session.scenario.start = trial.start
    session.reset()
    for name, value in trial.gains.items():
        session.set(name, value)
    session.command(trial.command[:3], trial.command[3])
    with suppress(FlightBrokenError):  # what was flown until then is compared
        session.tick(duration)
    return session.recording()


def _between(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Return the vector parts of the small rotations between attitudes (M, 3), half their angle."""
    one = one / np.linalg.norm(one, axis=1, keepdims=True)
    two = two / np.linalg.norm(two, axis=1, keepdims=True)
    w, v = one[:, :1], one[:, 1:]
    vector: np.ndarray = w * two[:, 1:] - two[:, :1] * v - np.cross(v, two[:, 1:])
    return vector
