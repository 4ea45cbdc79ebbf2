"""A flight between obstacles with a lidar, and the scans that it recorded."""

import copy
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from time import perf_counter

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform, RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.design.obstacles import RayObstacle, world_obstacles
from workbench.dynamics.motion_between import motions_between, point_motion
from workbench.plant.loading import make_vehicle
from workbench.plant.sensors import Lidar
from workbench.scenario.configured import read_configured
from workbench.scenario.scenario import Scenario
from workbench.scenario.sensor_choice import SensorChoice, choose_sensors
from workbench.session.recording import Recording
from workbench.session.session import Session
from workbench.setup import Setup, make_setup
from workbench.systems.sensors.readings import LidarScan


@dataclass(frozen=True, eq=False)
class Scan:
    """A scan as delivered to its reader.

    Attributes:
        stamp: when it was taken, as the scan states [s].
        delivered: when it could first be read, at the control rate [s].
        ranges: (layers, steps) [m]; not finite without a return.
        X_WS: pose of the lidar, as the scan states.
    """

    stamp: float
    delivered: float
    ranges: np.ndarray
    X_WS: RigidTransform


@dataclass(frozen=True)
class TrialFlight:
    """The flight judged by a lidar trial.

    Attributes:
        recording: has a sample at the stamp of every punctual scan.
        lidar: as described; without noise if the flight was.
        asked_rate: requested scans per second [1/s].
        period: between scans, in whole physics steps [s].
        latency: requested, from a scan to its delivery [s].
        control_period: period between checks for a new scan [s].
        obstacles: all that its rays can hit.
        scans: in the order of their delivery.
        computing_time: median wall-clock time per scan on this machine [s]; NaN if unknown.
    """

    recording: Recording
    lidar: Lidar
    asked_rate: float
    period: float
    latency: float
    control_period: float
    obstacles: tuple[RayObstacle, ...]
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
        """Return the pose of the lidar at a time [s], see `motions_between`.

        Over the physics step between two samples of the recording, its error is below 1 µm.
        """
        record = self.recording
        after = int(np.clip(np.searchsorted(record.time, time), 1, len(record.time) - 1))
        near = 1.0 if record.q_WB[after - 1] @ record.q_WB[after] > 0.0 else -1.0
        before, now = (
            point_motion(
                [*sign * record.q_WB[k], *record.p_WB[k], *record.w_WB[k], *record.v_WB[k]],
                self.lidar.p_BS,
            )
            for k, sign in ((after - 1, near), (after, 1.0))
        )
        span = record.time[after] - record.time[after - 1]
        share = float(np.clip((time - record.time[after - 1]) / span, 0.0, 1.0))
        motion = motions_between(before, now, span, 1, share)[0, 0]
        R_WB = RotationMatrix(Quaternion(motion[:4] / np.linalg.norm(motion[:4])))
        return RigidTransform(R_WB, motion[4:7]) @ RigidTransform(self.X_BS.rotation())


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
    """Fly a scenario with the lidar of its vehicle, and check for a scan every control period.

    Args:
        scenario: what to fly; its lidar is switched on if necessary.
        settings: parameter values.
        progress: called with the flown share, 0 .. 1.
        meshcat: where to draw, if anywhere.

    Raises:
        WorkbenchError: if it cannot be flown, the vehicle has no lidar, or no scan was delivered.
    """
    scenario = copy.deepcopy(scenario)
    scenario.rates.record_period = scenario.rates.physics_step
    setup, choice = _choose(scenario, settings)
    session, scenario = Session(setup, meshcat=meshcat), setup.scenario
    control_period = setup.rates.control_period
    scans: list[Scan] = []
    busy: list[float] = []
    slices = math.ceil(scenario.duration / control_period - 1e-9)
    for index in range(slices):
        begun = perf_counter()
        session.tick(min(control_period, scenario.duration - index * control_period))
        reading = session.reading(choice.sensor.name)
        busy.append(perf_counter() - begun)
        if isinstance(reading, LidarScan) and (not scans or reading.stamp != scans[-1].stamp):
            X_WS = RigidTransform(RotationMatrix(reading.R_WS), reading.p_WS)
            scans.append(Scan(reading.stamp, session.time, np.array(reading.ranges), X_WS))
        if progress:
            progress((index + 1) / slices)
    recording = session.recording()
    if not scans:
        least = choice.period + choice.latency + control_period
        raise WorkbenchError(
            f"no scan was delivered in the flight: with a period of {choice.period:.3g} s and "
            f"a latency of {choice.latency:g} s fly longer than {least:.3g} s, with a lidar that "
            "works"
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


def _choose(scenario: Scenario, settings: Mapping[str, float] | None) -> tuple[Setup, SensorChoice]:
    """Return the lidar to try, switched on: the first one in use, or else the first one."""
    description = read_configured(scenario.vehicle)
    vehicle = make_vehicle(description)
    lidars = [sensor for sensor in vehicle.sensors if isinstance(sensor, Lidar)]
    if not lidars:
        raise WorkbenchError(f"{vehicle.source}: it has no lidar: add one")
    if not any(isinstance(each.sensor, Lidar) for each in choose_sensors(vehicle, scenario)):
        scenario.sensors.use.append(lidars[0].name)
    setup = make_setup(scenario, settings, description=description, vehicle=vehicle)
    return setup, next(each for each in setup.sensors if isinstance(each.sensor, Lidar))


def _computing_time(busy: list[float], scans: list[Scan], slice_time: float) -> float:
    """Return the additional time that slices of flight with a scan take [s]."""
    taken = {int(scan.stamp / slice_time + 1e-6) for scan in scans}
    with_scan = [spent for index, spent in enumerate(busy) if index in taken]
    without = [spent for index, spent in enumerate(busy) if index not in taken]
    if not with_scan or not without:
        return math.nan
    return float(np.median(with_scan) - np.median(without))
