"""What the frames of sensors are called, beside links and frames of the description."""

from collections.abc import Collection, Sequence
from typing import NamedTuple

from workbench.plant.sensors import DepthCamera, Sensor


class SensorFrames(NamedTuple):
    """Names of the frames that go with a sensor.

    Attributes:
        own: of the sensor's frame S.
        optical: of a depth camera's optical frame, None for other sensors.
        alias: another name for S, which its readings are labelled with; None if there is none.
    """

    own: str
    optical: str | None
    alias: str | None


def sensor_frames(sensors: Sequence[Sensor], others: Collection[str]) -> list[SensorFrames]:
    """Return the names for sensors, in their order: NAME where it is free, else NAME_sensor.

    Args:
        sensors: in the order of the description; a `frame` of "" asks for no alias.
        others: names that are taken.
    """
    taken = {*others, ""}
    found = []
    for sensor in sensors:
        own = free_name(taken, sensor.name, f"{sensor.name}_sensor")
        taken.add(own)
        optical = None
        if isinstance(sensor, DepthCamera):
            optical = free_name(taken, f"{sensor.name}_optical")
            taken.add(optical)
        alias = None if sensor.frame in taken else sensor.frame
        taken.add(sensor.frame)
        found.append(SensorFrames(own, optical, alias))
    return found


def free_name(taken: Collection[str], *wishes: str) -> str:
    """Return the first wish that is not taken, or the last one with a number."""
    *_, last = wishes
    numbered = (f"{last}_{number}" for number in range(2, len(taken) + 3))
    return next(name for name in (*wishes, *numbered) if name not in taken)
