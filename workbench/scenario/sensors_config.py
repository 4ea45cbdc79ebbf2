"""The sensors of a scenario, as a typed dataclass that defines a part of the YAML schema."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from numbers import Real

from workbench.common.errors import WorkbenchError
from workbench.common.yaml_files import Keys

MIN_SENSOR_RATE_HZ = 0.01
"""Lowest rate of a sensor [1/s]."""
MAX_SENSOR_LATENCY_S = 10.0
"""Largest latency of a sensor [s]."""


@dataclass
class SensorsConfig:
    """The sensors of the vehicle in use, and their settings; those not named are not built.

    Names or kinds, see `sensor_kinds`, or `all`; rates [1/s] and latencies [s] by name
    or kind that replace those of the description; the seed of all noise; whether there is noise;
    whether to record every sample for `workbench fly` to write.
    """

    use: list[str] = field(default_factory=list)
    rates: dict[str, float] = field(default_factory=dict)
    latency: dict[str, float] = field(default_factory=dict)
    seed: int = 0
    noise: bool = True
    keep: bool = False


def check_sensors(sensors: SensorsConfig, refuse: Callable[[Keys, str], WorkbenchError]) -> None:
    """Check types of values, and the limits of rates and latencies.

    Args:
        sensors: to check; from Python it may have any type.
        refuse: makes the error from keys and a reason.

    Raises:
        WorkbenchError: for the first invalid one.
    """
    _check_types(sensors, refuse)
    for name, rate in sensors.rates.items():
        if not isinstance(rate, Real) or not MIN_SENSOR_RATE_HZ <= rate < math.inf:
            reason = f"must be a finite number of samples a second, {MIN_SENSOR_RATE_HZ:g} or more"
            raise refuse(("sensors", "rates", name), reason)
    for name, latency in sensors.latency.items():
        if not isinstance(latency, Real) or not 0.0 <= latency <= MAX_SENSOR_LATENCY_S:
            reason = f"must be within 0 .. {MAX_SENSOR_LATENCY_S:g} s"
            raise refuse(("sensors", "latency", name), reason)
    if sensors.seed < 0:
        raise refuse(("sensors", "seed"), "must be 0 or more")


def _check_types(sensors: object, refuse: Callable[[Keys, str], WorkbenchError]) -> None:
    """Check the types, as the schema does for a file."""
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
