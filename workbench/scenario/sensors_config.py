"""Which sensors a scenario has, as the typed dataclass that is its part of the YAML's schema."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from numbers import Real
from typing import Any

from workbench.common.errors import WorkbenchError
from workbench.common.yaml_files import Keys

SLOWEST_SENSOR = 0.01
"""Rate under which a sensor does not take part in any flight [1/s]."""
LONGEST_LATENCY = 10.0
"""Of a sensor [s]."""


@dataclass
class SensorsConfig:
    """Which of the vehicle's sensors measure, and how; those not named are not built.

    Names or kinds (imu, gps, lidar, range_finder, barometer, depth_camera, magnetometer), or `all`;
    rates [1/s] and latencies [s] by name or kind where the description's are not wanted; the seed
    of all noise; whether there is noise; whether every sample is kept, to be written by
    `workbench fly`.
    """

    use: list[str] = field(default_factory=list)
    rates: dict[str, float] = field(default_factory=dict)
    latency: dict[str, float] = field(default_factory=dict)
    seed: int = 0
    noise: bool = True
    keep: bool = False


def check_sensors(sensors: SensorsConfig, refuse: Callable[[Keys, str], WorkbenchError]) -> None:
    """Refuse values of other types, and rates and latencies that no sensor has.

    Args:
        sensors: what to check; from Python it may be anything.
        refuse: makes the error of keys and a reason.

    Raises:
        WorkbenchError: for the first that cannot be.
    """
    _check_types(sensors, refuse)
    for name, rate in sensors.rates.items():
        if not isinstance(rate, Real) or not SLOWEST_SENSOR <= rate < math.inf:
            reason = f"must be a finite number of samples a second, {SLOWEST_SENSOR:g} or more"
            raise refuse(("sensors", "rates", name), reason)
    for name, latency in sensors.latency.items():
        if not isinstance(latency, Real) or not 0.0 <= latency <= LONGEST_LATENCY:
            reason = f"must be within 0 .. {LONGEST_LATENCY:g} s"
            raise refuse(("sensors", "latency", name), reason)
    if sensors.seed < 0:
        raise refuse(("sensors", "seed"), "must be 0 or more")


def _check_types(sensors: Any, refuse: Callable[[Keys, str], WorkbenchError]) -> None:
    """Refuse what a file's schema would have refused."""
    if not isinstance(sensors, SensorsConfig):
        raise refuse(("sensors",), f"is {sensors!r:.60}, and should be a SensorsConfig")
    names = isinstance(sensors.use, list | tuple) and all(isinstance(n, str) for n in sensors.use)
    whole = isinstance(sensors.seed, int) and not isinstance(sensors.seed, bool)
    for key, good, name in (
        ("use", names, "a list of names"),
        ("rates", isinstance(sensors.rates, dict), "numbers by name"),
        ("latency", isinstance(sensors.latency, dict), "numbers by name"),
        ("seed", whole, "a whole number"),
        ("noise", isinstance(sensors.noise, bool), "true or false"),
        ("keep", isinstance(sensors.keep, bool), "true or false"),
    ):
        if not good:
            value = getattr(sensors, key)
            raise refuse(("sensors", key), f"is {value!r:.60}, and should be {name}")
