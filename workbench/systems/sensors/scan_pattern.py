"""The directions of a lidar's rays."""

from dataclasses import dataclass

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.plant.sensors import MAX_LIDAR_RAYS, Lidar, ScanAxis


@dataclass(frozen=True, eq=False)
class ScanPattern:
    """Rays in layers of equal elevation; its arrays cannot be written to.

    Attributes:
        azimuths: of the columns, about the sensor's z from its x (columns) [rad].
        elevations: of the layers, above its x-y plane (layers) [rad].
        directions_S: unit vectors in the sensor's frame, layer by layer (layers * columns, 3).
    """

    azimuths: np.ndarray
    elevations: np.ndarray
    directions_S: np.ndarray

    @property
    def shape(self) -> tuple[int, int]:
        """Layers and columns."""
        return len(self.elevations), len(self.azimuths)


def make_scan_pattern(sensor: Lidar) -> ScanPattern:
    """Return the rays of a lidar, from the first angle to the last, including both.

    So a full turn measures its first direction twice, as in SDF.

    Raises:
        WorkbenchError: if there are too many rays, or the angles are not valid.
    """
    layers, columns = sensor.vertical.samples, sensor.horizontal.samples
    if layers * columns > MAX_LIDAR_RAYS:
        raise WorkbenchError(
            f"sensor '{sensor.name}': {layers} x {columns} rays: let there be {MAX_LIDAR_RAYS} at "
            "most"
        )
    azimuths = _angles(sensor, "horizontal", sensor.horizontal)
    elevations = _angles(sensor, "vertical", sensor.vertical)
    layer, column = np.meshgrid(elevations, azimuths, indexing="ij")
    level = np.cos(layer)
    directions_S = np.stack([level * np.cos(column), level * np.sin(column), np.sin(layer)], axis=2)
    arrays = azimuths, elevations, directions_S.reshape(-1, 3)
    for array in arrays:
        array.flags.writeable = False
    return ScanPattern(*arrays)


def _angles(sensor: Lidar, name: str, axis: ScanAxis) -> np.ndarray:
    if axis.samples < 1 or not np.isfinite([axis.min_angle, axis.max_angle]).all():
        raise WorkbenchError(
            f"sensor '{sensor.name}': its {name} scan has {axis.samples} samples from "
            f"{axis.min_angle:g} to {axis.max_angle:g} rad: give it one or more, and finite angles"
        )
    return np.linspace(axis.min_angle, axis.max_angle, axis.samples)
