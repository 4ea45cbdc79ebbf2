"""What a sensor of a few numbers measures; a package adds its own kind of sensor with it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from workbench.plant.home import Home
from workbench.plant.sensors import Noise, Sensor
from workbench.systems.sensors.readings import Reading

if TYPE_CHECKING:
    from workbench.systems.casting.caster import Caster  # slow to load


def unchanged(values: np.ndarray) -> np.ndarray:
    """Return the values."""
    return values


@dataclass(frozen=True)
class SensorInstrument:
    """What a sensor measures.

    Attributes:
        columns: names and units of a sample's numbers (size).
        usual: standard deviations of a common sensor of the kind (n), for a fault.
        noises: of the first n exact values; the others have none.
        inputs: names and sizes of its input ports; 0 for the scene's `geometry_query`.
        exact: returns the exact values, from the inputs by name and the settings.
        reading: returns the record of a sample, from stamp [s] and values (size).
        shown: returns a sample (size) from exact or noisy values.
        settings: initial values of its live parameters, other than the fault.
    """

    columns: tuple[str, ...]
    usual: tuple[float, ...]
    noises: Sequence[Noise]
    inputs: Mapping[str, int]
    exact: Callable[[Mapping[str, Any], Sequence[float]], np.ndarray]
    reading: Callable[[float, list[float]], Reading]
    shown: Callable[[np.ndarray], np.ndarray] = unchanged
    settings: tuple[float, ...] = ()


class SensorSite(NamedTuple):
    """What a sensor is built into.

    Attributes:
        home: location of the world's origin.
        period: between samples [s].
        rotors: number of rotors.
        weight: of the vehicle [N].
        caster: of rays against everything but the vehicle; None unless `Sensor.casts_rays`.
    """

    home: Home
    period: float
    rotors: int
    weight: float
    caster: "Caster | None"


class MeasuringSensor(Sensor):
    """A sensor that states what it measures, as of another package; see docs/extending.md.

    Its module imports Drake only when its functions are called, as screens without Drake load it.
    """

    def instrument(self, site: SensorSite) -> SensorInstrument:
        """Return what it measures."""
        raise NotImplementedError
