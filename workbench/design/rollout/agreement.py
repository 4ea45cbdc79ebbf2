"""How far compiled flights are from those of the full diagram, for any vehicle.

Flights that are hard to agree on: random gains, commands that saturate rotors and tilt, and drones
that are thrown, turning and at any attitude.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from workbench.common.errors import FlightBrokenError
from workbench.control.controller import COMMON_PARAMETERS, Controller
from workbench.control.controller_file import controller_or_default
from workbench.design.rollout.candidates import start_state
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.step_response import recorded_each_update
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Scenario, ScenarioStart
from workbench.session.recording import Recording
from workbench.session.session import Session
from workbench.setup import make_setup

TRIAL_HEIGHT_M = 50.0
"""At which trials begin, with the ceiling far above: nothing ends them early [m]."""
TRIAL_CEILING_M = 100.0
GAIN_SPREAD_FACTOR = 2.0
"""Gains are between this part of the vehicle's own and this many times as much."""
MAX_TRIAL_SPEED_M_S, MAX_TRIAL_CLIMB_M_S, MAX_TRIAL_TURN_RAD_S = 8.0, 4.0, 1.0
"""Of commands: level and vertical speed [m/s] and yaw rate [rad/s]."""
MAX_THROWN_SPEED_M_S, MAX_THROWN_RATE_RAD_S = 5.0, 6.0
"""Of what is thrown, on each axis [m/s, rad/s]."""
SATURATED_USE = 0.995
"""Share of its speed limit from which a rotor counts as saturated."""


@dataclass(frozen=True)
class AgreementTrial:
    """A flight for both.

    Attributes:
        gains: parameter values by name.
        start: motion at the beginning.
        command: velocity in W [m/s] and yaw rate [rad/s] (4).
    """

    gains: Mapping[str, float]
    start: ScenarioStart
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
) -> list[AgreementTrial]:
    """Return trials of which every other is thrown.

    Args:
        vehicle: that flies.
        own: values by name of the gains that are drawn, around which they are.
        count: how many.
        seed: of what is drawn.
        controller: whose gains they are; the default one where none is given.
    """
    law = controller_or_default(controller)
    table = law.table
    rng = np.random.default_rng(seed)
    rows = law.parameters
    common = {row.name for row in COMMON_PARAMETERS}
    tuned = [row.name for row in rows if row.name in own and row.name not in common]
    trials = []
    for number in range(count):
        gains = {"max_height": TRIAL_CEILING_M}
        for name in tuned:
            row = table.find(name)
            value = own[name] * GAIN_SPREAD_FACTOR ** rng.uniform(-1.0, 1.0)
            gains[name] = float(np.clip(value, row.minimum, row.maximum))
        start = ScenarioStart(position=[0.0, 0.0, TRIAL_HEIGHT_M])
        if number % 2:
            start.roll_pitch_yaw = rng.uniform(-np.pi, np.pi, 3).tolist()
            start.velocity = rng.uniform(-MAX_THROWN_SPEED_M_S, MAX_THROWN_SPEED_M_S, 3).tolist()
            start.angular_velocity = rng.uniform(
                -MAX_THROWN_RATE_RAD_S, MAX_THROWN_RATE_RAD_S, 3
            ).tolist()
        most = np.array(
            [MAX_TRIAL_SPEED_M_S, MAX_TRIAL_SPEED_M_S, MAX_TRIAL_CLIMB_M_S, MAX_TRIAL_TURN_RAD_S]
        )
        v_x, v_y, v_z, turn = (most * rng.uniform(-1.0, 1.0, 4)).tolist()
        trials.append(AgreementTrial(gains, start, (v_x, v_y, v_z, turn)))
    return trials


def agreement(
    scenario: Scenario,
    trials: Sequence[AgreementTrial],
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
    setup = make_setup(
        Scenario(
            vehicle=scenario.vehicle,
            controller=scenario.controller,
            estimator=scenario.estimator,
            sensors=scenario.sensors,
            rates=recorded_each_update(scenario).rates,
            duration=duration,
        )
    )
    rates = replace(setup.rates, record_period=setup.rates.control_period)
    setup = setup.with_scenario(replace(setup.scenario, rates=rates))
    session, engine = Session(setup), RolloutEngine.of(setup)
    flights = engine.fly_from(
        [each.gains for each in trials],
        np.array([start_state(session.vehicle, each.start) for each in trials]),
        np.array([each.command for each in trials]),
        duration=duration,
    )
    count = len(trials)
    found = Agreement(
        *np.zeros((4, count)),
        saturated=flights.peak_rotor_use >= SATURATED_USE,
        lost=np.isfinite(flights.diverged_at),
    )
    for number, trial in enumerate(trials):
        flown = _diagram_flight(session, trial, duration)
        states = flights.states[number, : len(flown.time)]
        turned = 2.0 * np.abs(_rotation_vectors(states[:, 0:4], flown.q_WB))
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


def _diagram_flight(session: Session, trial: AgreementTrial, duration: float) -> Recording:
    """Return a flight on the diagram, recorded at each control period."""
    session.scenario.start = trial.start
    session.reset()
    for name, value in trial.gains.items():
        session.set(name, value)
    session.command(trial.command[:3], trial.command[3])
    with suppress(FlightBrokenError):  # what was flown until then is compared
        session.tick(duration)
    return session.recording()


def _rotation_vectors(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Return the vector parts of the small rotations between attitudes (M, 3), half their angle."""
    one = one / np.linalg.norm(one, axis=1, keepdims=True)
    two = two / np.linalg.norm(two, axis=1, keepdims=True)
    w, v = one[:, :1], one[:, 1:]
    vector: np.ndarray = w * two[:, 1:] - two[:, :1] * v - np.cross(v, two[:, 1:])
    return vector
