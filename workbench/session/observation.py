"""Look at a flying workbench: everything that a screen shows, read off its ports."""

import math
from collections.abc import Iterable, Sequence
from functools import partial
from typing import TypeVar

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RollPitchYaw
from pydrake.systems.framework import Context

from workbench.control.flight_mode import REASON
from workbench.control.mode import FlightMode, Reason
from workbench.diagram.sensing import Mounted
from workbench.diagram.workbench import Workbench
from workbench.session.snapshot import Clearance, LidarSummary, SensorStatus, Snapshot, Triple
from workbench.systems.sensors.faults import Fault
from workbench.systems.sensors.readings import (
    BarometerReading,
    GpsReading,
    ImuReading,
    LidarScan,
    MagnetometerReading,
    RangeReading,
    Reading,
)

R = TypeVar("R", bound=Reading)


def observe(bench: Workbench, root_context: Context, start: Sequence[float]) -> Snapshot:
    """Return the present of a flight.

    Args:
        bench: what flies.
        root_context: its Context.
        start: where the flight began, in W [m].
    """
    signals = bench.recorder.now(root_context)
    state = signals["state"]
    q_WB = state[0:4] / np.linalg.norm(state[0:4])
    mounted = bench.sensing.mounted
    readings = [each.reading(root_context) for each in mounted]
    scan = _first(readings, LidarScan)
    height = _first(readings, RangeReading)
    w, x, y, z = q_WB.tolist()
    return Snapshot(
        time=root_context.get_time(),
        p_WB=_triple(state[4:7]),
        q_WB=(w, x, y, z),
        v_WB=_triple(state[10:13]),
        w_WB=_triple(state[7:10]),
        vdot_WB=_triple(signals["acceleration"][3:6]),
        displacement=_triple(state[4:7] - np.array(start)),
        roll_pitch_yaw=_triple(RollPitchYaw(Quaternion(q_WB)).vector()),
        thrusts=tuple(signals["thrusts"].tolist()),
        reference=tuple(signals["reference"].tolist()),
        mode=FlightMode(int(signals["mode"][0])),
        charge=float(signals["charge"][0]),
        wind=_triple(signals["wind"]),
        imu=_first(readings, ImuReading),
        gps=_first(readings, GpsReading),
        barometer=_first(readings, BarometerReading),
        lidar=_summary(scan) if scan else None,
        height=height.distance if height else None,
        clearance=_clearance(signals["obstacle"]) if "obstacle" in signals else None,
        sensors=tuple(map(partial(_status, root_context), mounted, readings)),
        voltage=_voltage(bench, root_context),
        magnetometer=_first(readings, MagnetometerReading),
        reason=Reason(int(signals["mode"][REASON])),
    )


def _voltage(bench: Workbench, root_context: Context) -> float:
    """Return that under load over that of the full battery, 1 where no battery is stated."""
    dynamics = bench.airframe.dynamics
    if not dynamics.HasOutputPort("voltage"):
        return 1.0
    port = dynamics.GetOutputPort("voltage")
    return float(port.Eval(dynamics.GetMyContextFromRoot(root_context))[0])


def _first(readings: Iterable[Reading | None], wanted: type[R]) -> R | None:
    """Return the first reading of a type, None without any."""
    return next((reading for reading in readings if isinstance(reading, wanted)), None)


def _summary(scan: LidarScan) -> LidarSummary:
    return LidarSummary(
        stamp=scan.stamp,
        returns=scan.returns,
        rays=scan.ranges.size,
        nearest=scan.nearest,
        direction=scan.nearest_direction if scan.returns else None,
    )


def _clearance(obstacle: np.ndarray) -> Clearance:
    distance, *direction, warning = obstacle.tolist()
    return Clearance(distance, _triple(np.array(direction)), bool(warning))


def _status(root_context: Context, mounted: Mounted, reading: Reading | None) -> SensorStatus:
    sensor, period = mounted.choice.sensor, mounted.choice.period
    time, taken = root_context.get_time(), mounted.samples_taken(root_context)
    periods = math.ceil(time / period - 1e-6)  # begun so far; a sample comes with each
    context = mounted.system.GetMyContextFromRoot(root_context)
    return SensorStatus(
        name=sensor.name,
        kind=sensor.kind,
        asked_rate=mounted.choice.asked_rate,
        rate=taken / (periods * period) if periods else 0.0,
        age=time - reading.stamp if reading else math.inf,
        fault=Fault(int(context.get_numeric_parameter(0).GetAtIndex(0))),
    )


def _triple(vector: np.ndarray) -> Triple:
    x, y, z = (float(number) for number in vector)
    return (x, y, z)
