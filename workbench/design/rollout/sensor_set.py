"""An estimator and its sensors in compiled flights."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.diagram.mounting import (
    deviations_at_start,
    find_imu,
    magnetometer_turn,
    mounting_of,
)
from workbench.estimation import imu
from workbench.estimation.ekf import START_ERRORS_SOURCE, InitialDeviations, start_errors
from workbench.estimation.estimators import Estimator
from workbench.estimation.samples import Mounting
from workbench.estimation.settings import AIDING_SENSORS
from workbench.plant.formats.values import listed_names
from workbench.plant.home import DEFAULT_HOME
from workbench.plant.sensors import Barometer, RangeFinder
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Scenario
from workbench.scenario.sensor_choice import SensorChoice
from workbench.setup import Setup
from workbench.systems.noise import noise_seed, noise_source_name, sensor_system_name
from workbench.systems.sensors.noisy_sensor import noise_model
from workbench.systems.sensors.sampled_sensor import LATENCY_TOLERANCE_S

NOISE_CHANNELS = (6, 1, 3, 1)
"""Numbers that have noise of each of `AIDING_SENSORS`."""
MAX_NOISE_CHANNELS = max(NOISE_CHANNELS)
UNSUPPORTED_SENSORS = ("gps", "barometer", "magnetometer", "range_finder", "imu")
"""Systems of parameters that compiled flights know at their defaults alone: faults, and what
disturbs sensors."""


class EstimatorInputs(NamedTuple):
    """Sensors for compiled code; what is of four is that of `AIDING_SENSORS`.

    Tuples where that can be: to count who holds an array takes longer than to read it.

    Attributes:
        p_BS: place of the IMU (3) [m].
        R_BS: its orientation, row by row (9).
        imu_noise: see `imu.ImuNoise`.
        mounting: see `Mounting.packed` (18).
        R_BM: of the magnetometer, row by row (9).
        periods: between samples (4) [s], 0 of what is not there.
        latencies: from a sample to its delivery (4) [s].
        depth: samples that wait at most.
        noise: of each channel mean, deviation, mean and deviation of the bias, share of the drift
            that is left after a sample, deviation of what it adds, precision (4, 6, 7).
        reference: altitude of the world's origin above the sea [m].
        nearest: that the range finder sees [m].
        farthest: likewise.
    """

    p_BS: tuple[float, ...]
    R_BS: tuple[float, ...]
    imu_noise: imu.ImuNoise
    mounting: tuple[float, ...]
    R_BM: tuple[float, ...]
    periods: tuple[float, ...]
    latencies: tuple[float, ...]
    depth: int
    noise: np.ndarray
    reference: float
    nearest: float
    farthest: float


@dataclass(frozen=True)
class SensorSet:
    """What tells the law of its motion in compiled flights.

    Attributes:
        estimator: that runs.
        inputs: what its sensors have in common.
        names: of the sources of noise: of the IMU, and of each of `AIDING_SENSORS`.
        mounting: of the sensors.
        known: how far the estimate may be off at the start.
        noise: whether there is any.
    """

    estimator: Estimator
    inputs: EstimatorInputs
    names: tuple[str, ...]
    mounting: Mounting
    known: InitialDeviations
    noise: bool

    @property
    def settings(self) -> tuple[str, ...]:
        """Names of the estimator's live numbers."""
        names: tuple[str, ...] = self.estimator.settings._fields
        return names

    @property
    def memory_size(self) -> int:
        """Of the estimator."""
        return len(self.memory(np.array([1.0, *[0.0] * 12]), 0))

    def seeds(self, seed: int) -> np.ndarray:
        """Return what the noise of IMU and other sensors starts from (5), for a flight's seed."""
        return np.array([float(noise_seed(seed, name)) for name in self.names])

    def memory(self, state: np.ndarray, seed: int) -> np.ndarray:
        """Return what the estimator remembers at the start of a flight at a motion (13)."""
        drawn = start_errors(noise_seed(seed, START_ERRORS_SOURCE) if self.noise else None)
        return self.estimator.begin(state, self.mounting, drawn, self.known)


def moving_joints(vehicle: Vehicle) -> str:
    """Return a clause on the joints of a vehicle that move."""
    names = listed_names([joint.name for joint in vehicle.joints])
    return f"{names} {'moves' if len(vehicle.joints) == 1 else 'move'} in flight"


def refuse_joints(vehicle: Vehicle) -> None:
    """Refuse a vehicle that compiled flights do not have.

    Raises:
        WorkbenchError: if its joints move.
    """
    if vehicle.joints:
        raise WorkbenchError(
            f"{moving_joints(vehicle)}, and compiled flights have one rigid body: "
            f"{vehicle.name} flies only on the diagram (the app, workbench fly, step, sweep)"
        )


def why_not_compiled(setup: Setup) -> str:
    """Return why flights of a setup are not compiled; "" if they are.

    Compiled flights have one rigid body, and cannot know its motion as every law does.
    """
    if setup.vehicle.joints:
        return f"{moving_joints(setup.vehicle)}, which is not compiled"
    if setup.estimator is None:
        return ""
    name = setup.scenario.estimator
    if setup.vehicle.battery is not None:
        return f"the charge of the battery, which flights on {name} estimate, is not compiled"
    if setup.scenario.world != Scenario.world:
        return f"what sensors see of a world, which flights on {name} hear, is not compiled"
    for row in setup.table:
        if row.system in UNSUPPORTED_SENSORS and setup.values[row.name] != row.default:
            return f"{row.name}, which flights on {name} feel, is not compiled"
    return ""


def make_sensor_set(setup: Setup) -> SensorSet | None:
    """Return what tells the law its motion in compiled flights; None for the truth.

    Raises:
        WorkbenchError: if the vehicle has no IMU.
    """
    estimator, choices, noise = setup.estimator, setup.sensors, setup.scenario.sensors.noise
    if estimator is None:
        return None
    heard = [_first_of_kind(choices, kind) for kind in AIDING_SENSORS]
    step, period = setup.rates.physics_step, setup.rates.control_period
    inertial = find_imu(setup.vehicle, noise)
    mounting = mounting_of(inertial, choices, DEFAULT_HOME)
    _, barometer, _, finder = (each.sensor if each else None for each in heard)
    reference, nearest, farthest = DEFAULT_HOME.altitude, 0.0, math.inf
    if isinstance(barometer, Barometer) and barometer.reference_altitude is not None:
        reference = barometer.reference_altitude
    if isinstance(finder, RangeFinder):
        nearest, farthest = finder.min_range, finder.max_range
    return SensorSet(
        estimator=estimator,
        inputs=EstimatorInputs(
            p_BS=tuple(map(float, inertial.p_BS)),
            R_BS=tuple(np.array(inertial.R_BS, dtype=float).ravel().tolist()),
            imu_noise=imu.ImuNoise(
                *(tuple(map(float, row)) for row in imu.imu_noise(inertial, step, period))
            ),
            mounting=tuple(mounting.packed().tolist()),
            R_BM=tuple(magnetometer_turn(choices).ravel().tolist()),
            periods=tuple(each.period if each else 0.0 for each in heard),
            latencies=tuple(each.latency - LATENCY_TOLERANCE_S if each else 0.0 for each in heard),
            depth=max([1 + math.ceil(each.latency / each.period) for each in heard if each] or [1]),
            noise=np.array([_channel_noise(each) for each in heard]),
            reference=float(reference),
            nearest=float(nearest),
            farthest=float(farthest),
        ),
        names=(imu.IMU_NOISE_SOURCE, *(_source(each) for each in heard)),
        mounting=mounting,
        known=deviations_at_start(inertial),
        noise=noise,
    )


def _first_of_kind(choices: Sequence[SensorChoice], kind: str) -> SensorChoice | None:
    return next((each for each in choices if each.sensor.kind == kind), None)


def _source(choice: SensorChoice | None) -> str:
    """Return the name of the system that makes a sensor's noise, see `diagram.sensing`."""
    return noise_source_name(sensor_system_name(choice.sensor.name)) if choice else "nothing"


def _channel_noise(choice: SensorChoice | None) -> np.ndarray:
    """Return the noise of a sensor's channels (6, 7)."""
    found = np.zeros((MAX_NOISE_CHANNELS, 7))
    if choice is None:
        return found
    noises = choice.sensor.noises
    model = noise_model(noises, [1.0] * len(noises), choice.period)
    rows = (
        model.mean,
        model.stddev,
        model.bias_mean,
        model.bias_stddev,
        model.kept,
        model.driven,
        model.precision,
    )
    found[: len(noises)] = np.transpose(rows)
    return found
