"""What an estimator hears in compiled flights: IMU, GPS, barometer, magnetometer, range finder."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.diagram.mounting import (
    deviations_at_start,
    find_imu,
    magnetometer_turn,
    mounting_of,
)
from workbench.diagram.sensor_choice import SensorChoice, choose_sensors
from workbench.estimation import imu
from workbench.estimation.ekf import START, InitialDeviations, start_errors
from workbench.estimation.estimators import Estimator, find_estimator
from workbench.estimation.samples import Mounting
from workbench.estimation.settings import HEARD, TRUTH
from workbench.plant.home import DEFAULT_HOME
from workbench.plant.sensors import Barometer, RangeFinder
from workbench.plant.vehicle import Vehicle
from workbench.scenario.parameters import parameter_table
from workbench.scenario.scenario import Scenario
from workbench.systems.noise import noise_seed
from workbench.systems.sensors.noisy_sensor import noise_model
from workbench.systems.sensors.sampled_sensor import LATE

CHANNELS = (6, 1, 3, 1)
"""Numbers that have noise of each of `HEARD`."""
MOST = max(CHANNELS)
UNHEARD = ("gps", "barometer", "magnetometer", "range_finder", "imu")
"""Systems of parameters that compiled flights know at their defaults alone: faults, and what
disturbs sensors."""


class Hearing(NamedTuple):
    """Sensors for compiled code; what is of four is that of `HEARD`.

    Tuples where that can be: to count who holds an array takes longer than to read it.

    Attributes:
        p_BS: place of the IMU (3) [m].
        R_BS: its orientation, row by row (9).
        imu_noise: see `imu.ImuNoise`.
        mounting: see `Mounting.packed` (18).
        R_BM: of the magnetometer, row by row (9).
        periods: between samples (4) [s], 0 of what is not there.
        late: from a sample to its delivery (4) [s].
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
    late: tuple[float, ...]
    depth: int
    noise: np.ndarray
    reference: float
    nearest: float
    farthest: float


@dataclass(frozen=True)
class Senses:
    """What tells the law of its motion in compiled flights.

    Attributes:
        estimator: that runs.
        hearing: its sensors.
        names: of the sources of noise: of the IMU, and of each of `HEARD`.
        mounting: of the sensors.
        known: how far the estimate may be off at the start.
        noise: whether there is any.
    """

    estimator: Estimator
    hearing: Hearing
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
        drawn = start_errors(noise_seed(seed, START) if self.noise else None)
        return self.estimator.begin(state, self.mounting, drawn, self.known)


def why_not(vehicle: Vehicle, scenario: Scenario, values: Mapping[str, float]) -> str:
    """Return why compiled flights cannot know the motion as a scenario's law does; "" if they can.

    Args:
        vehicle: as the law knows it.
        scenario: its estimator and world count.
        values: of parameters by name, those that differ from the table's defaults or all.
    """
    name = scenario.estimator
    if name == TRUTH:
        return ""
    if vehicle.battery is not None:
        return f"the charge of the battery, which flights on {name} estimate, is not compiled"
    if scenario.world != Scenario.world:
        return f"what sensors see of a world, which flights on {name} hear, is not compiled"
    for row in parameter_table():
        if row.system in UNHEARD and values.get(row.name, row.default) != row.default:
            return f"{row.name}, which flights on {name} feel, is not compiled"
    return ""


def make_senses(vehicle: Vehicle, scenario: Scenario) -> Senses | None:
    """Return what tells the law of a scenario's flights their motion; None for the truth.

    Args:
        vehicle: as the law knows it.
        scenario: its estimator, sensors and rates count.

    Raises:
        WorkbenchError: if the vehicle has no IMU.
    """
    estimator = find_estimator(scenario.estimator)
    if estimator is None:
        return None
    config = scenario.sensors
    choices = choose_sensors(vehicle, scenario)
    heard = [_first(choices, kind) for kind in HEARD]
    step, period = scenario.rates.physics_step, scenario.rates.control_period
    inertial = find_imu(vehicle, config.noise)
    mounting = mounting_of(inertial, choices, DEFAULT_HOME)
    _, barometer, _, finder = (each.sensor if each else None for each in heard)
    reference, nearest, farthest = DEFAULT_HOME.altitude, 0.0, math.inf
    if isinstance(barometer, Barometer) and barometer.reference_altitude is not None:
        reference = barometer.reference_altitude
    if isinstance(finder, RangeFinder):
        nearest, farthest = finder.min_range, finder.max_range
    return Senses(
        estimator=estimator,
        hearing=Hearing(
            p_BS=tuple(map(float, inertial.p_BS)),
            R_BS=tuple(np.array(inertial.R_BS, dtype=float).ravel().tolist()),
            imu_noise=imu.ImuNoise(
                *(tuple(map(float, row)) for row in imu.imu_noise(inertial, step, period))
            ),
            mounting=tuple(mounting.packed().tolist()),
            R_BM=tuple(magnetometer_turn(choices).ravel().tolist()),
            periods=tuple(each.period if each else 0.0 for each in heard),
            late=tuple(each.latency - LATE if each else 0.0 for each in heard),
            depth=max([1 + math.ceil(each.latency / each.period) for each in heard if each] or [1]),
            noise=np.array([_noise(each) for each in heard]),
            reference=float(reference),
            nearest=float(nearest),
            farthest=float(farthest),
        ),
        names=(imu.SOURCE, *(_source(each) for each in heard)),
        mounting=mounting,
        known=deviations_at_start(inertial),
        noise=config.noise,
    )


def _first(choices: Sequence[SensorChoice], kind: str) -> SensorChoice | None:
    return next((each for each in choices if each.sensor.kind == kind), None)


def _source(choice: SensorChoice | None) -> str:
    """Return the name of the system that makes a sensor's noise, see `diagram.sensing`."""
    return f"{choice.sensor.name.replace('::', '/')}_sensor_noise" if choice else "nothing"


def _noise(choice: SensorChoice | None) -> np.ndarray:
    """Return the noise of a sensor's channels (6, 7)."""
    found = np.zeros((MOST, 7))
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
