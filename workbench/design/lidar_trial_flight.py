"""The flight of a lidar trial: the scans as they are delivered, and where the lidar really was."""

import copy
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform, RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.design.lidar_trial_world import Obstacle, world_obstacles
from workbench.diagram.sensor_choice import SensorChoice, choose_sensors
from workbench.plant.sensors import Lidar
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Scenario
from workbench.session.recording import Recording
from workbench.session.session import Session
from workbench.systems.sensors.readings import LidarScan


@dataclass(frozen=True, eq=False)
class Scan:
    """A scan as its reader got it.

    Attributes:
        stamp: when it was taken, by its own word [s].
        delivered: when it could first be read, at the control rate [s].
        ranges: (layers, steps) [m]; what is not finite is no return.
        X_WS: where the lidar was, by the scan's own word.
    """

    stamp: float
    delivered: float
    ranges: np.ndarray
    X_WS: RigidTransform


@dataclass(frozen=True)
class TrialFlight:
    """What a lidar trial is judged from.

    Attributes:
        recording: with a sample at the stamp of every scan that is on time.
        lidar: as described; exact if the flight was without noise.
        asked_rate: scans a second that are asked for [1/s].
        period: between scans, in whole physics steps [s].
        latency: from a scan to its delivery, as asked for [s].
        control_period: at which scans are looked for [s].
        obstacles: what its rays can meet.
        scans: in the order of their delivery.
        computing_time: median wall clock time for a scan on this machine [s]; NaN if unknown.
    """

    recording: Recording
    lidar: Lidar
    asked_rate: float
    period: float
    latency: float
    control_period: float
    obstacles: tuple[Obstacle, ...]
    scans: tuple[Scan, ...]
    computing_time: float

    @cached_property
    def directions(self) -> np.ndarray:
        """Rays in the sensor's frame, layer by layer (layers · steps, 3)."""
        return ray_directions(self.lidar)

    @cached_property
    def X_BS(self) -> RigidTransform:
        """Return the lidar's mounting."""
        lidar = self.lidar
        return RigidTransform(RotationMatrix(np.array(lidar.R_BS)), np.array(lidar.p_BS))

    def X_WS(self, time: float) -> RigidTransform:
        """Return where the lidar was at a time [s]: exact where there is a sample.

        Between samples it goes straight and evenly; in the 6 ms of a usual trial that is off by
        5 µm for each m/s² of acceleration.
        """
        record = self.recording
        after = int(np.clip(np.searchsorted(record.time, time - 1e-9), 1, len(record.time) - 1))
        span = record.time[after] - record.time[after - 1]
        share = float(np.clip((time - record.time[after - 1]) / span, 0.0, 1.0))
        if share > 1.0 - 1e-6:
            share = 1.0
        p_WB = (1.0 - share) * record.p_WB[after - 1] + share * record.p_WB[after]
        one, other = record.q_WB[after - 1], record.q_WB[after]
        q_WB = (1.0 - share) * one + share * (other if one @ other > 0.0 else -other)
        X_WB = RigidTransform(Quaternion(q_WB / np.linalg.norm(q_WB)), p_WB)
        return X_WB @ self.X_BS


def ray_directions(lidar: Lidar) -> np.ndarray:
    """Return unit vectors in S, layer by layer from the lowest (layers · steps, 3).

    Azimuth turns from x towards y, elevation rises from the x-y plane towards z.
    """
    azimuth, elevation = (
        np.linspace(axis.min_angle, axis.max_angle, axis.samples)
        for axis in (lidar.horizontal, lidar.vertical)
    )
    up, around = np.meshgrid(elevation, azimuth, indexing="ij")
    return np.stack(
        [np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)], axis=-1
    ).reshape(-1, 3)


def fly_between(
    scenario: Scenario,
    settings: Mapping[str, float] | None = None,
    progress: Callable[[float], None] | None = None,
    meshcat: Meshcat | None = None,
) -> TrialFlight:
    """Fly a scenario with its vehicle's lidar, and look for a scan every control period.

    Args:
        scenario: what to fly; its lidar is switched on if it is not.
        settings: parameter values.
        progress: called with the flown share, 0 .. 1.
        meshcat: where to draw, if anywhere.

    Raises:
        WorkbenchError: if it cannot be flown, the vehicle has no lidar, or no scan was delivered.
    """
    scenario = copy.deepcopy(scenario)
    choice = _choose(Session(Scenario(vehicle=scenario.vehicle)).vehicle, scenario)
    scenario.rates.record_period = _record_period(scenario, choice.period)
    session = Session(scenario, settings, meshcat)
    control_period = scenario.rates.control_period
    scans: list[Scan] = []
    busy: list[float] = []
    slices = math.ceil(scenario.duration / control_period - 1e-9)
    for index in range(slices):
        begun = time.perf_counter()
        session.tick(min(control_period, scenario.duration - index * control_period))
        reading = session.reading(choice.sensor.name)
        busy.append(time.perf_counter() - begun)
        if isinstance(reading, LidarScan) and (not scans or reading.stamp != scans[-1].stamp):
            X_WS = RigidTransform(RotationMatrix(reading.R_WS), reading.p_WS)
            scans.append(Scan(reading.stamp, session.time, np.array(reading.ranges), X_WS))
        if progress:
            progress((index + 1) / slices)
    recording = session.recording()
    if not scans or len(recording.time) < 2:
        least = choice.period + choice.latency + control_period
        raise WorkbenchError(
            f"the flight of {session.time:.3g} s is too short to judge a scan: fly longer than "
            f"{least:.3g} s"
            if scans
            else f"no scan was delivered in the flight: with a period of {choice.period:.3g} s and "
            f"a latency of {choice.latency:g} s fly longer than {least:.3g} s, with a lidar "
            "that is not silent"
        )
    lidar = choice.sensor
    assert isinstance(lidar, Lidar)
    return TrialFlight(
        recording=recording,
        lidar=lidar,
        asked_rate=choice.asked_rate,
        period=choice.period,
        latency=choice.latency,
        control_period=control_period,
        obstacles=world_obstacles(session.world),
        scans=tuple(scans),
        computing_time=_computing_time(busy, scans, control_period),
    )


def _choose(vehicle: Vehicle, scenario: Scenario) -> SensorChoice:
    """Return the lidar to try: the first one in use, or else the first one, which then is."""
    lidars = [sensor for sensor in vehicle.sensors if isinstance(sensor, Lidar)]
    if not lidars:
        raise WorkbenchError(f"{vehicle.source}: there is no lidar in it to try: add one")
    for choice in choose_sensors(vehicle, scenario):
        if choice.sensor.kind == Lidar.kind:
            return choice
    scenario.sensors.use.append(lidars[0].name)
    return _choose(vehicle, scenario)


def _record_period(scenario: Scenario, scan_period: float) -> float:
    """Return a period for the recording that gives it a sample at every scan [s].

    It is the largest whole part of a scan period that is not longer than the scenario's.
    """
    step = scenario.rates.physics_step
    steps, most = round(scan_period / step), round(scenario.rates.record_period / step)
    return step * max(part for part in range(1, min(steps, most) + 1) if steps % part == 0)


def _computing_time(busy: list[float], scans: list[Scan], slice_time: float) -> float:
    """Return how much longer the slices of flight take in which a scan is taken [s]."""
    taken = {int(scan.stamp / slice_time + 1e-6) for scan in scans}
    with_scan = [spent for index, spent in enumerate(busy) if index in taken]
    without = [spent for index, spent in enumerate(busy) if index not in taken]
    if not with_scan or not without:
        return math.nan
    return float(np.median(with_scan) - np.median(without))
