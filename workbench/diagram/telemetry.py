"""Telemetry in the diagram: the topics of a drone and their sources."""

import math

import numpy as np
from pydrake.systems.framework import DiagramBuilder, OutputPort

from workbench.diagram.sensing import MountedSensor, Sensing
from workbench.link.drone_topics import drone_signals, drone_topics
from workbench.link.picture import PictureLayout, picture_stride
from workbench.link.signal import TopicOptions
from workbench.link.topics import Topic
from workbench.plant.sensors import DepthCamera, Lidar
from workbench.plant.vehicle import Vehicle
from workbench.setup import Setup
from workbench.systems.bridge import Bridge
from workbench.systems.frame_poses import FramePoses
from workbench.systems.recorder import SignalRecorder
from workbench.systems.sensors.noisy_sensor import NoisySensor
from workbench.systems.sensors.readings import make_pinhole
from workbench.systems.sensors.sampled_sensor import SampledSensor
from workbench.systems.sensors.scan_pattern import ScanPattern, make_scan_pattern
from workbench.systems.telemetry import SLOW_TOPIC_DIVIDER, Telemetry, TopicValues

MAX_STATE_RATE_HZ = 200.0
"""Largest rate of the published state [1/s]; 128 in whole control periods."""
MAX_PICTURE_RATE_HZ = 5.0
"""Largest rate of published pictures [1/s]: 0.5 MB a second of depth and colour."""
MAX_CLOUD_RAYS = 16_000
"""Largest number of rays of a published cloud, so that it fits into a frame; larger scans are
thinned out."""


def add_telemetry(
    builder: DiagramBuilder,
    setup: Setup,
    bridge: Bridge,
    recorder: SignalRecorder,
    frames: FramePoses,
    sensing: Sensing,
    terminals: OutputPort | None,
) -> tuple[Telemetry, tuple[Topic, ...]]:
    """Add the system that publishes, and return it with its topics.

    Samples come at some of the control updates, as any other time would end a step of the
    integrator, and what is published must not change the flight.

    Args:
        builder: of the diagram.
        setup: what flies.
        bridge: keeps the samples.
        recorder: its stacked signals are published.
        frames: the tree of frames.
        sensing: the active sensors.
        terminals: voltage [V] and current [A] of the battery, None if it has no model.
    """
    vehicle, values, home = setup.vehicle, setup.values, setup.home
    control_period = setup.rates.control_period
    period = control_period * max(1, round(1.0 / (MAX_STATE_RATE_HZ * control_period)))
    kinds = dict.fromkeys(row.rate for row in drone_signals())
    sensors = {kind: found[0] for kind in kinds if (found := sensing.of_kind(kind))}
    rates = {kind: 1.0 / mounted.choice.period for kind, mounted in sensors.items()}
    pattern, sent, scan = None, (), {}
    if "lidar" in sensors:
        lidar = sensors["lidar"].choice.sensor
        assert isinstance(lidar, Lidar)
        pattern = make_scan_pattern(lidar)
        stride = math.ceil(len(pattern.directions_S) / MAX_CLOUD_RAYS)
        sent = thinned_columns(pattern, stride)
        scan = _scan(lidar, pattern, stride)
    layout = None
    if DepthCamera.kind in sensors:
        layout = _picture_layout(sensors[DepthCamera.kind], vehicle, frames)
        # whole periods of the camera
        rates[DepthCamera.kind] /= math.ceil(rates[DepthCamera.kind] / MAX_PICTURE_RATE_HZ)
    topics = drone_topics(
        TopicOptions(
            rotors=len(vehicle.rotors),
            fast=1.0 / period,
            slow=1.0 / (SLOW_TOPIC_DIVIDER * period),
            rates=rates | ({"estimate": 1.0 / period} if "estimate" in recorder.places else {}),
            rays=len(sent),
            scan=scan,
            frames=frames.pairs,
            limits=(values["max_speed"], values["max_climb_rate"], values["max_yaw_rate"]),
            mounts={kind: mounted.choice.sensor.frame for kind, mounted in sensors.items()},
            deviations={
                kind: [noise.stddev for noise in mounted.system.instrument.noises]
                for kind, mounted in sensors.items()
                if isinstance(mounted.system, NoisySensor)
            },
            moving=frames.moving,
            joints=list(vehicle.published_joints),
            setpoints=sorted({each.servo.kind for each in vehicle.servos}),
            contacts=vehicle.contact_links,
            cables=vehicle.cables,
            home=(home.latitude, home.longitude, home.altitude),
            picture=layout,
        )
    )
    measured = {
        kind: _measurement(mounted) for kind, mounted in sensors.items() if kind != DepthCamera.kind
    }
    telemetry = builder.AddNamedSystem(
        "telemetry",
        Telemetry(
            bridge,
            TopicValues(vehicle, topics, pattern, sent),
            recorder.places,
            period=period,
            quick={
                kind: each.choice.period
                for kind, each in sensors.items()
                if each.choice.period < period and kind != DepthCamera.kind
            },
            sizes={kind: port.size() for kind, port in measured.items()},
            picture_period=1.0 / rates[DepthCamera.kind] if layout else None,
        ),
    )
    stack = builder.GetSubsystemByName("recorded_signals")
    builder.Connect(stack.get_output_port(), telemetry.GetInputPort("signals"))
    builder.Connect(frames.frames_output, telemetry.GetInputPort("frames"))
    if terminals is not None:
        builder.Connect(terminals, telemetry.GetInputPort("battery"))
    for kind, port in measured.items():
        builder.Connect(port, telemetry.GetInputPort(kind))
    if layout is not None:
        pictures = sensors[DepthCamera.kind].system.GetOutputPort("image")
        builder.Connect(pictures, telemetry.GetInputPort(DepthCamera.kind))
    return telemetry, topics


def _measurement(mounted: MountedSensor) -> OutputPort:
    """Return the port with stamp and values of a sensor's last delivered sample."""
    assert isinstance(mounted.system, SampledSensor)
    return mounted.system.measurement_output


def _picture_layout(mounted: MountedSensor, vehicle: Vehicle, frames: FramePoses) -> PictureLayout:
    """Return the layout of a camera's published pictures, which have every n-th of its pixels."""
    sensor = mounted.choice.sensor
    assert isinstance(sensor, DepthCamera)
    cameras = [each.name for each in vehicle.sensors if isinstance(each, DepthCamera)]
    pinhole = make_pinhole(sensor.width, sensor.height, sensor.horizontal_fov)
    return PictureLayout(
        pinhole.thinned(picture_stride(sensor.width, sensor.height)),
        frame=frames.optical[cameras.index(sensor.name)],
        has_colour=sensor.has_colour,
    )


def thinned_columns(pattern: ScanPattern, stride: int) -> np.ndarray:
    """Return the indices of every n-th column of a scan (n is `stride`), layer by layer."""
    layers, columns = pattern.shape
    return np.arange(layers * columns).reshape(layers, columns)[:, ::stride].reshape(-1)


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
