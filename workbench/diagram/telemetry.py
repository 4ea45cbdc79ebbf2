"""Telemetry in the diagram: the topics of a drone and their sources."""

import dataclasses
import math

import numpy as np
from pydrake.systems.framework import DiagramBuilder, OutputPort

from workbench.diagram.sensing import Mounted, Sensing
from workbench.link.drone_topics import Outfit, drone_topics
from workbench.link.topics import Topic
from workbench.plant.sensors import Lidar
from workbench.plant.vehicle import Vehicle
from workbench.systems.bridge import Bridge
from workbench.systems.frame_poses import FramePoses
from workbench.systems.recorder import Recorder
from workbench.systems.sensors.sampled_sensor import SampledSensor
from workbench.systems.sensors.scan_pattern import ScanPattern, make_scan_pattern
from workbench.systems.telemetry import SLOW_SHARE, Telemetry, TopicValues

RATE = 200.0
"""Largest rate of the published state [1/s]; 128 in whole control periods."""
MOST_RAYS = 16_000
"""Largest number of rays of a published cloud, so that it fits into a frame; larger scans are
thinned out."""
PUBLISHED = ("imu", "gps", "lidar", "magnetometer")
"""Kinds of published sensors; only the first one of each kind is published."""


def add_telemetry(
    builder: DiagramBuilder,
    bridge: Bridge,
    vehicle: Vehicle,
    recorder: Recorder,
    frames: FramePoses,
    sensing: Sensing,
    limits: tuple[float, float, float],
    control_period: float,
) -> tuple[Telemetry, tuple[Topic, ...]]:
    """Add the system that publishes, and return it with its topics.

    Args:
        builder: of the diagram.
        bridge: keeps the samples.
        vehicle: the flying vehicle.
        recorder: its stacked signals are published.
        frames: the tree of frames.
        sensing: the active sensors.
        limits: initial maximum horizontal speed, climb rate [m/s] and yaw rate [rad/s].
        control_period: between control updates [s]; samples come at some of them, as any other time
            would end a step of the integrator, and what is published must not change the flight.
    """
    period = control_period * max(1, round(1.0 / (RATE * control_period)))
    sensors = {kind: found[0] for kind in PUBLISHED if (found := sensing.of_kind(kind))}
    outfit = Outfit(
        rotors=len(vehicle.rotors),
        fast=1.0 / period,
        slow=1.0 / (SLOW_SHARE * period),
        imu=_rate(sensors.get("imu")),
        gps=_rate(sensors.get("gps")),
        lidar=_rate(sensors.get("lidar")),
        magnetometer=_rate(sensors.get("magnetometer")),
        mounts={kind: mounted.choice.sensor.frame for kind, mounted in sensors.items()},
        frames=frames.pairs,
        limits=limits,
        estimate="estimate" in recorder.places,
    )
    pattern, sent = None, None
    if "lidar" in sensors:
        lidar = sensors["lidar"].choice.sensor
        assert isinstance(lidar, Lidar)
        pattern = make_scan_pattern(lidar)
        stride = math.ceil(len(pattern.directions_S) / MOST_RAYS)
        sent = thinned(pattern, stride)
        outfit = dataclasses.replace(outfit, rays=len(sent), scan=_scan(lidar, pattern, stride))
    topics = drone_topics(outfit)
    ports = {kind: _measurement(mounted) for kind, mounted in sensors.items()}
    telemetry = builder.AddNamedSystem(
        "telemetry",
        Telemetry(
            bridge,
            TopicValues(vehicle, topics),
            recorder.places,
            period=period,
            quick={
                kind: each.choice.period
                for kind, each in sensors.items()
                if each.choice.period < period
            },
            sizes={kind: port.size() for kind, port in ports.items()},
            pattern=pattern,
            sent=sent,
        ),
    )
    stack = builder.GetSubsystemByName("recorded_signals")
    builder.Connect(stack.get_output_port(), telemetry.GetInputPort("signals"))
    builder.Connect(frames.frames_output, telemetry.GetInputPort("frames"))
    for kind, port in ports.items():
        builder.Connect(port, telemetry.GetInputPort(kind))
    return telemetry, topics


def _measurement(mounted: Mounted) -> OutputPort:
    """Return the port with stamp and values of a sensor's last delivered sample."""
    assert isinstance(mounted.system, SampledSensor)
    return mounted.system.measurement_output


def thinned(pattern: ScanPattern, stride: int) -> np.ndarray:
    """Return the indices of every n-th column of a scan (n is `stride`), layer by layer."""
    layers, columns = pattern.shape
    return np.arange(layers * columns).reshape(layers, columns)[:, ::stride].reshape(-1)


def _rate(mounted: Mounted | None) -> float:
    """Return the rate at which a sensor is published."""
    return 1.0 / mounted.choice.period if mounted else 0.0


def _scan(lidar: Lidar, pattern: ScanPattern, stride: int) -> dict[str, object]:
    """Return the description of a cloud's rays for clients; first angle, step and count [rad]."""
    return {
        "frame": lidar.frame,
        "p_BS": list(lidar.p_BS),
        "R_BS": [list(row) for row in lidar.R_BS],
        "azimuths": _evenly(pattern.azimuths[::stride]),
        "elevations": _evenly(pattern.elevations),
        "order": "layer by layer; angles are first, step and count; inf is no return",
        "range": [lidar.min_range, lidar.max_range],
    }


def _evenly(angles: np.ndarray) -> list[float | int]:
    """Return first angle, step and number of evenly spaced angles."""
    step = float(angles[1] - angles[0]) if len(angles) > 1 else 0.0
    return [float(angles[0]), step, len(angles)]
