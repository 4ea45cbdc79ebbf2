"""Take a snapshot of a flight from its diagram."""

import math
from collections.abc import Iterable, Sequence
from functools import partial
from typing import TypeVar

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RollPitchYaw
from pydrake.systems.framework import Context

from workbench.common.vectors import float_triple
from workbench.control.flight_mode import REASON_INDEX
from workbench.control.mode import FlightMode, Reason
from workbench.diagram.sensing import MountedSensor
from workbench.diagram.workbench import Workbench
from workbench.plant.faults import Fault
from workbench.session.snapshot import (
    CableStatus,
    LidarSummary,
    NearestClearance,
    SensorStatus,
    Snapshot,
)
from workbench.systems.sensors.measuring import MeasuringSensor
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


def flight_snapshot(bench: Workbench, root_context: Context, start: Sequence[float]) -> Snapshot:
    """Return everything that a screen shows of a flight."""
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
        p_WB=float_triple(state[4:7]),
        q_WB=(w, x, y, z),
        v_WB=float_triple(state[10:13]),
        w_WB=float_triple(state[7:10]),
        vdot_WB=float_triple(signals["acceleration"][3:6]),
        displacement=float_triple(state[4:7] - np.array(start)),
        roll_pitch_yaw=float_triple(RollPitchYaw(Quaternion(q_WB)).vector()),
        thrusts=tuple(signals["thrusts"].tolist()),
        reference=tuple(signals["reference"].tolist()),
        mode=FlightMode(int(signals["mode"][0])),
        charge=float(signals["charge"][0]),
        wind=float_triple(signals["wind"]),
        imu=_first(readings, ImuReading),
        gps=_first(readings, GpsReading),
        barometer=_first(readings, BarometerReading),
        lidar=_summary(scan) if scan else None,
        height=height.distance if height else None,
        clearance=_clearance(signals["obstacle"]) if "obstacle" in signals else None,
        sensors=tuple(map(partial(_status, root_context), mounted, readings)),
        voltage=_voltage(bench, root_context),
        magnetometer=_first(readings, MagnetometerReading),
        reason=Reason(int(signals["mode"][REASON_INDEX])),
        others=tuple(
            reading
            for each, reading in zip(mounted, readings, strict=True)
            if reading and isinstance(each.choice.sensor, MeasuringSensor)
        ),
        joints=tuple(signals["joints"].tolist()) if "joints" in signals else (),
        cables=_cables(bench, root_context),
    )


def _cables(bench: Workbench, root_context: Context) -> tuple[CableStatus, ...]:
    """Return the cables, while hooks are open without those that end in one."""
    cables = bench.airframe.cables
    if cables is None:
        return ()
    context = cables.GetMyContextFromRoot(root_context)
    opened = cables.hooks_are_open(context)
    ends = cables.GetOutputPort("ends").Eval(context).reshape(-1, 2, 3)
    tensions = cables.GetOutputPort("tensions").Eval(context).tolist()
    return tuple(
        CableStatus(row.name, float_triple(upper), float_triple(lower), row.length, tension)
        for row, (upper, lower), tension in zip(cables.rows, ends, tensions, strict=True)
        if not (opened and row.hooked)
    )


def _voltage(bench: Workbench, root_context: Context) -> float:
    """Return the voltage under load over that of a full battery, 1 without a stated battery."""
    rotors = bench.airframe.rotors
    port = rotors.GetOutputPort("voltage")
    return float(port.Eval(rotors.GetMyContextFromRoot(root_context))[0])


def _first(readings: Iterable[Reading | None], wanted: type[R]) -> R | None:
    """Return the first reading of a type, None without one."""
    return next((reading for reading in readings if isinstance(reading, wanted)), None)


def _summary(scan: LidarScan) -> LidarSummary:
    return LidarSummary(
        stamp=scan.stamp,
        returns=scan.returns,
        rays=scan.ranges.size,
        nearest=scan.nearest,
        direction=scan.nearest_direction if scan.returns else None,
    )


def _clearance(obstacle: np.ndarray) -> NearestClearance:
    distance, *direction, warning = obstacle.tolist()
    return NearestClearance(distance, float_triple(np.array(direction)), bool(warning))


def _status(root_context: Context, mounted: MountedSensor, reading: Reading | None) -> SensorStatus:
    sensor, period = mounted.choice.sensor, mounted.choice.period
    time, taken = root_context.get_time(), mounted.samples_taken(root_context)
    periods = math.ceil(time / period - 1e-6)  # periods begun so far; each has a sample
    context = mounted.system.GetMyContextFromRoot(root_context)
    return SensorStatus(
        name=sensor.name,
        kind=sensor.kind,
        asked_rate=mounted.choice.asked_rate,
        rate=taken / (periods * period) if periods else 0.0,
        age=time - reading.stamp if reading else math.inf,
        fault=Fault(int(context.get_numeric_parameter(0).GetAtIndex(0))),
    )
