"""The sensors of a flight, with their rates and noise."""

import dataclasses
import logging
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.estimation.settings import AIDING_SENSORS
from workbench.plant.sensors import NO_NOISE, DepthCamera, Lidar, Sensor, sensor_kinds
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Scenario
from workbench.scenario.sensors_config import MIN_SENSOR_RATE_HZ, SensorsConfig

MAX_UNDELIVERED_NUMBERS = 20_000_000
"""Largest number of undelivered numbers of a sensor: 160 MB."""
ALL_SENSORS = "all"


@dataclass(frozen=True)
class SensorChoice:
    """An active sensor.

    Attributes:
        sensor: as declared, or without noise.
        asked_rate: requested samples a second, from description or scenario [1/s].
        period: between samples [s].
        latency: from a sample to its delivery [s].
        kept: whether every sample is kept, to be written to a file.
    """

    sensor: Sensor
    asked_rate: float
    period: float
    latency: float
    kept: bool = False


def choose_sensors(vehicle: Vehicle, scenario: Scenario) -> tuple[SensorChoice, ...]:
    """Return the sensors that a scenario uses, or its estimator, in the vehicle's order.

    They sample at their own rates, at most once a physics step: a step of the integrator ends at
    each sample, so that a reading is that of its stamp.

    A rate or a latency of a kind that the vehicle does not have waits for another vehicle, see
    `log_absent_sensors`.

    Raises:
        WorkbenchError: if no sensor of the vehicle has a name, or a rate is too low.
    """
    config = scenario.sensors
    for key, names in (("use", config.use), ("rates", config.rates), ("latency", config.latency)):
        for name in names:
            if name in ((ALL_SENSORS,) if key == "use" else sensor_kinds()):
                continue  # all sensors, also if there are none
            _check_name(vehicle, name, f"sensors.{key}")
    step = scenario.rates.physics_step
    used = {*config.use, *(AIDING_SENSORS if scenario.is_estimated else ())}
    return tuple(
        _choice(sensor, config, step)
        for sensor in vehicle.sensors
        if not {ALL_SENSORS, sensor.name, sensor.kind}.isdisjoint(used)
    )


def for_other_vehicle(config: SensorsConfig) -> SensorsConfig:
    """Return the settings for another vehicle: those of kinds, and of all, hold for any.

    It logs which settings of sensors by name are left out.
    """
    kinds = (*sensor_kinds(), ALL_SENSORS)
    for key in ("use", "rates", "latency"):
        for name in getattr(config, key):
            if name not in kinds:
                logging.getLogger("workbench").info(
                    "sensors.%s of %s is left out: it names a sensor of the scenario's own model, "
                    "and a kind would hold for any model",
                    key,
                    name,
                )
    rates, latency = (
        {name: value for name, value in values.items() if name in kinds}
        for values in (config.rates, config.latency)
    )
    use = [name for name in config.use if name in kinds]
    return dataclasses.replace(config, use=use, rates=rates, latency=latency)


def log_absent_sensors(vehicle: Vehicle, config: SensorsConfig) -> None:
    """Log which rates and latencies do nothing, as the vehicle has no such sensors."""
    known = {name for sensor in vehicle.sensors for name in (sensor.name, sensor.kind)}
    settings: tuple[tuple[str, Iterable[str]], ...] = (
        ("rates", config.rates),
        ("latency", config.latency),
    )
    for key, names in settings:
        for name in names:
            if name not in known:
                logging.getLogger("workbench").info(
                    "sensors.%s of %s does nothing: %s has no such sensor", key, name, vehicle.name
                )


def _choice(sensor: Sensor, config: SensorsConfig, step: float) -> SensorChoice:
    declared = sensor.rate or sensor.usual_rate
    rate = config.rates.get(sensor.name, config.rates.get(sensor.kind, declared))
    if rate < MIN_SENSOR_RATE_HZ:
        raise WorkbenchError(
            f"sensor '{sensor.name}' takes {rate:g} samples a second: give it "
            f"{MIN_SENSOR_RATE_HZ:g} "
            "or more in its description, or under sensors.rates"
        )
    if rate * step > 1.0 and rate != declared:
        raise WorkbenchError(
            f"sensor '{sensor.name}' is asked for {rate:g} samples a second: a physics step of "
            f"{step:g} s allows {1.0 / step:g}"
        )
    latency = config.latency.get(sensor.name, config.latency.get(sensor.kind, 0.0))
    period = max(step, 1.0 / rate)
    if latency / period * _size(sensor) > MAX_UNDELIVERED_NUMBERS:
        raise WorkbenchError(
            f"sensor '{sensor.name}': {latency / period:.0f} samples would wait for delivery, more "
            "than memory should hold: give it less latency or a lower rate"
        )
    return SensorChoice(
        sensor=sensor if config.noise else without_noise(sensor),
        asked_rate=rate,
        period=period,
        latency=latency,
        kept=config.keep,
    )


def _size(sensor: Sensor) -> int:
    """Return the approximate number of numbers in a sample."""
    match sensor:
        case Lidar():
            return sensor.horizontal.samples * sensor.vertical.samples
        case DepthCamera():
            return sensor.width * sensor.height
    return 10


def without_noise(sensor: Sensor) -> Sensor:
    """Return the sensor without noise."""
    quiet: dict[str, Any] = {
        name: (NO_NOISE,) * len(values) if isinstance(getattr(sensor, name), tuple) else NO_NOISE
        for name, values in sensor.stated_noises.items()
    }
    return dataclasses.replace(sensor, **quiet)


def _check_name(vehicle: Vehicle, name: str, where: str) -> None:
    """Refuse a name without a sensor."""
    names = [sensor.name for sensor in vehicle.sensors]
    kinds = [sensor.kind for sensor in vehicle.sensors]
    if not names:
        raise WorkbenchError(
            f"{where} names '{name}', and {vehicle.name} has no sensors: add some to "
            f"{vehicle.source} (docs/descriptions.md)"
        )
    known = dict.fromkeys([*names, *kinds, ALL_SENSORS])
    if name not in known:
        raise WorkbenchError(f"{where}: {unknown_name('sensor', name, known)}")
