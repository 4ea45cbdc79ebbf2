"""The delivered samples of sensors in a flight, as files for other tools."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.common.series import Series


@dataclass(frozen=True, eq=False)
class SampleTable:
    """All samples of a sensor of a few numbers.

    Attributes:
        sensor: its name.
        columns: names and units of the numbers.
        stamps: times of the samples (N) [s].
        values: (N, columns).
        latency: from a stamp to the delivery of its sample [s].
    """

    sensor: str
    columns: tuple[str, ...]
    stamps: np.ndarray
    values: np.ndarray
    latency: float

    suffix = ".csv"

    @property
    def channels(self) -> tuple[Series, ...]:
        """The columns."""
        heads = [column.removesuffix("]").split(" [") for column in self.columns]
        columns = zip(heads, self.values.T, strict=True)
        return tuple(Series(name, unit, self.stamps, values) for (name, unit), values in columns)

    def write(self, path: Path) -> None:
        """Write one row a sample, with units in the header."""
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(("stamp [s]", *self.columns))
            writer.writerows(np.column_stack([self.stamps, self.values]).tolist())


@dataclass(frozen=True, eq=False)
class ScanStack:
    """All scans of a lidar.

    Attributes:
        sensor: its name.
        azimuths: of the columns (columns) [rad].
        elevations: of the layers (layers) [rad].
        stamps: times of the scans (N) [s].
        ranges: (N, layers, columns) [m]; not finite without a return.
        p_WS: position of the sensor (N, 3) [m].
        q_WS: its orientation, unit quaternions w, x, y, z (N, 4).
        latency: from a stamp to the delivery of its scan [s].
    """

    sensor: str
    azimuths: np.ndarray
    elevations: np.ndarray
    stamps: np.ndarray
    ranges: np.ndarray
    p_WS: np.ndarray
    q_WS: np.ndarray
    latency: float

    suffix = ".npz"

    @property
    def channels(self) -> tuple[Series, ...]:
        """A summary of the scans.

        The shortest range, the range of the ray nearest to the sensor's x (both infinite without a
        return), and the number of returns.
        """
        rays = self.ranges.reshape(len(self.stamps), self.elevations.size * self.azimuths.size)
        seen = np.isfinite(rays)
        ahead = np.outer(np.cos(self.elevations), np.cos(self.azimuths)).argmax()
        return (
            Series("nearest", "m", self.stamps, np.where(seen, rays, np.inf).min(axis=1)),
            Series("ahead", "m", self.stamps, rays[:, ahead]),
            Series("returns", "1", self.stamps, seen.sum(axis=1).astype(float)),
        )

    def write(self, path: Path) -> None:
        """Write all arrays by their names, for `numpy.load`."""
        with path.open("wb") as file:
            np.savez_compressed(
                file,
                azimuths=self.azimuths,
                elevations=self.elevations,
                stamps=self.stamps,
                ranges=self.ranges,
                p_WS=self.p_WS,
                q_WS=self.q_WS,
            )


RecordedSamples = SampleTable | ScanStack
