"""Read a flight's kept samples as records."""

import numpy as np

from workbench.diagram.sample_logs import SampleLog
from workbench.systems.sensors.samples import Samples, SampleTable, ScanStack


def read_samples(log: SampleLog, rows: np.ndarray) -> Samples:
    """Return what a sensor delivered, in rows of its log, see `SampleLog.rows`."""
    # What is logged is loaded; see `diagram.sensing`.
    from workbench.systems.sensors import barometer, gps, imu, magnetometer, range_finder
    from workbench.systems.sensors.lidar import Lidar

    name, system = log.mounted.choice.sensor.name, log.mounted.system
    stamps, values = rows[:, 0], rows[:, 1:]
    columns: tuple[str, ...]
    match system:
        case Lidar():
            pattern = system.pattern
            ranges, p_WS, q_WS = np.split(
                values, [values.shape[1] - 7, values.shape[1] - 4], axis=1
            )
            return ScanStack(
                sensor=name,
                azimuths=pattern.azimuths,
                elevations=pattern.elevations,
                stamps=stamps,
                ranges=ranges.reshape(-1, *pattern.shape),
                p_WS=p_WS,
                q_WS=q_WS,
                latency=system.latency,
            )
        case imu.Imu():
            columns = imu.COLUMNS
        case gps.Gps():
            columns = gps.COLUMNS
        case barometer.Barometer():
            columns = barometer.COLUMNS
        case magnetometer.Magnetometer():
            columns = magnetometer.COLUMNS
        case _:
            columns = range_finder.COLUMNS
    return SampleTable(name, columns, stamps, values, system.latency)
