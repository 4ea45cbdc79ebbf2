"""Read the sensors that a description declares."""

import dataclasses
import math
from collections.abc import Callable

from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.common.vectors import float_triple
from workbench.plant.formats.block import XmlBlock
from workbench.plant.formats.values import shortened_text
from workbench.plant.frame_tree import WORLD_FRAME_NAME
from workbench.plant.model import DeclaredSensor, Model
from workbench.plant.noise_reader import read_axes, read_noise, read_noise_of_many
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.mount import body_pose
from workbench.plant.sensors import (
    MAX_LIDAR_RAYS,
    Barometer,
    DepthCamera,
    Gps,
    Imu,
    Lidar,
    Magnetometer,
    RangeFinder,
    ScanAxis,
    Sensor,
    added_sensors,
    free_name,
    sensor_frames,
)

_MAX_CAMERA_SIDE_PX = 16_384
_SENSOR_FRAME_ID_TAGS = ("gz_frame_id", "ignition_frame_id", "frame_id")
_MAX_SENSORS = 1000
_MAX_SAMPLE_RATE_HZ = 1e6
_MIN_EARTH_FIELD_T = 2e-5
"""The earth's field is always stronger than this [T], and the noise of magnetometers is weaker."""
_TESLA_IN_GAUSS = 1e-4


def _read_imu_block(common: Sensor, sensor: XmlBlock, remarks: Remarks) -> Imu:
    imu = sensor.block("imu")
    return Imu(
        **vars(common),
        angular_velocity=read_axes(imu, "angular_velocity", "rate", remarks),
        linear_acceleration=read_axes(imu, "linear_acceleration", "accel", remarks),
    )


def _read_gps(common: Sensor, sensor: XmlBlock, remarks: Remarks) -> Gps:
    gps = sensor.first("navsat", "gps")
    position, velocity = gps.block("position_sensing"), gps.block("velocity_sensing")
    return Gps(
        **vars(common),
        horizontal_position=read_noise(position.block("horizontal"), remarks),
        vertical_position=read_noise(position.block("vertical"), remarks),
        horizontal_velocity=read_noise(velocity.block("horizontal"), remarks),
        vertical_velocity=read_noise(velocity.block("vertical"), remarks),
    )


def _read_barometer(common: Sensor, sensor: XmlBlock, remarks: Remarks) -> Barometer:
    block = sensor.block("air_pressure")
    given = block.has("reference_altitude")
    return Barometer(
        **vars(common),
        reference_altitude=block.number("reference_altitude", 0.0) if given else None,
        noise=read_noise(block.block("pressure"), remarks),
    )


def _read_magnetometer(common: Sensor, sensor: XmlBlock, remarks: Remarks) -> Magnetometer:
    """Return a magnetometer; its noise may be in gauss, the unit of Gazebo up to Harmonic."""
    block = sensor.block("magnetometer")
    x, y, z = (read_noise(block.block(axis), remarks) for axis in "xyz")
    if max(noise.stddev for noise in (x, y, z)) >= _MIN_EARTH_FIELD_T:
        text = "noise as strong as the earth's field; it is probably in gauss, and read as gauss"
        remarks.add("repaired", sensor.file, sensor.what, text)
        x, y, z = (noise.in_unit(_TESLA_IN_GAUSS) for noise in (x, y, z))
    return Magnetometer(**vars(common), magnetic_field=(x, y, z))


def _read_sonar(common: Sensor, sensor: XmlBlock, remarks: Remarks) -> RangeFinder:
    """Return a sonar; the defaults are those of SDF's sonar.sdf."""
    sonar = sensor.block("sonar")
    min_range, max_range = _read_range(sonar, 0.0, 1.0)
    text = "a sonar measures along its axis only, not in a cone"
    remarks.add("assumed", sensor.file, sensor.what, text)
    return RangeFinder(**vars(common), min_range=min_range, max_range=max_range)


def _read_range(block: XmlBlock, least: float, most: float) -> tuple[float, float]:
    """Return the limits of a range, or these defaults if they are missing."""
    near, far = block.non_negative("min", least), block.non_negative("max", most)
    if near >= far:
        raise block.wrong(f"ranges from {near:g} m to {far:g} m: give max above min")
    return near, far


def _read_lidar(common: Sensor, sensor: XmlBlock, remarks: Remarks) -> Lidar | RangeFinder | None:
    """Return a lidar, or for a single ray a range finder along its x axis."""
    lidar = sensor.first("lidar", "ray", "gpu_lidar", "gpu_ray")
    if not lidar.there:
        text = f"of type {common.type} without a block for its scan and range; not used"
        remarks.add("ignored", sensor.file, sensor.what, text)
        return None
    scan, limits = lidar.block("scan"), lidar.block("range")
    if not scan.has("horizontal"):
        raise scan.fault("horizontal", "add it, with samples and angles")
    horizontal = _scan_axis(scan.block("horizontal"), 640)
    vertical = _scan_axis(scan.block("vertical"), 1)
    if horizontal.samples * vertical.samples > MAX_LIDAR_RAYS:
        raise scan.wrong(
            f"{horizontal.samples} x {vertical.samples} rays: give it up to {MAX_LIDAR_RAYS} in "
            "total"
        )
    min_range, max_range = _read_range(limits, 0.0, 0.0)
    resolution = limits.non_negative("resolution", 0.0)
    noise = read_noise_of_many(lidar, remarks)
    if horizontal.samples * vertical.samples == 1:
        return RangeFinder(
            **vars(common),
            min_range=min_range,
            max_range=max_range,
            resolution=resolution,
            noise=noise,
        )
    return Lidar(
        **vars(common),
        horizontal=horizontal,
        vertical=vertical,
        min_range=min_range,
        max_range=max_range,
        resolution=resolution,
        noise=noise,
    )


def _scan_axis(block: XmlBlock, samples: int) -> ScanAxis:
    """Return the rays along one axis; `samples` is SDF's default. Resolution multiplies them."""
    resolution = block.number("resolution", 1.0)
    if resolution <= 0.0:
        raise block.fault("resolution", "give it a positive number")
    rays = block.count("samples", samples, MAX_LIDAR_RAYS) * resolution
    if rays >= MAX_LIDAR_RAYS + 0.5:
        raise block.wrong(f"{rays:.0f} rays: give it up to {MAX_LIDAR_RAYS}")
    low, high = block.number("min_angle", 0.0), block.number("max_angle", 0.0)
    if low > high:
        raise block.wrong(f"angles from {low:g} to {high:g}: give max_angle above min_angle")
    return ScanAxis(max(1, round(rays)), low, high)


def _read_depth_camera(common: Sensor, sensor: XmlBlock, remarks: Remarks) -> DepthCamera:
    """Return a depth camera; the defaults are those of SDF's camera.sdf."""
    camera = sensor.block("camera")
    image, clip, own = camera.block("image"), camera.block("clip"), camera.block("depth_camera")
    own_clip = own.block("clip")
    settings = (
        (camera, "horizontal_fov", "1.047"),
        (image, "width", "320"),
        (image, "height", "240"),
        (own_clip if own_clip.has("near") else clip, "near", "0.1"),
        (own_clip if own_clip.has("far") else clip, "far", "100"),
    )
    missing = [f"{tag} {default}" for block, tag, default in settings if not block.has(tag)]
    if missing:
        text = f"{', '.join(missing)}: not given, SDF's defaults"
        remarks.add("assumed", sensor.file, sensor.what, text)
    fov = camera.number("horizontal_fov", 1.047)
    if not 0.0 < fov < 2.0 * math.pi:
        raise camera.fault("horizontal_fov", "give it an angle between 0 and 2 pi")
    near = own_clip.non_negative("near", clip.non_negative("near", 0.1))
    far = own_clip.non_negative("far", clip.non_negative("far", 100.0))
    if near >= far:
        raise camera.wrong(f"clips from {near:g} m to {far:g} m: give far above near")
    return DepthCamera(
        **vars(common),
        width=image.count("width", 320, _MAX_CAMERA_SIDE_PX),
        height=image.count("height", 240, _MAX_CAMERA_SIDE_PX),
        horizontal_fov=fov,
        near=near,
        far=far,
        noise=read_noise_of_many(camera, remarks),
    )


SENSOR_READERS: dict[str, Callable[[Sensor, XmlBlock, Remarks], Sensor | None]] = {
    "imu": _read_imu_block,
    "gps": _read_gps,
    "navsat": _read_gps,
    "air_pressure": _read_barometer,
    "magnetometer": _read_magnetometer,
    "sonar": _read_sonar,
    "lidar": _read_lidar,
    "ray": _read_lidar,
    "gpu_lidar": _read_lidar,
    "gpu_ray": _read_lidar,
    "depth": _read_depth_camera,
    "depth_camera": _read_depth_camera,
    "rgbd": _read_depth_camera,
    "rgbd_camera": _read_depth_camera,
}
"""Readers of the core's kinds by the declared type of a sensor; a result of None is not used."""


def read_sensors(model: Model, base_link: str, remarks: Remarks) -> tuple[Sensor, ...]:
    """Return the sensors of a description, in file order.

    Args:
        model: what the description says.
        base_link: its frame is the body frame B.
        remarks: receives remarks on assumptions, and on sensors that are not used.

    Raises:
        WorkbenchError: with file and line, for an impossible number.
    """
    if len(model.sensors) > _MAX_SENSORS:
        raise WorkbenchError(
            f"{model.source}: it declares {len(model.sensors)} sensors: up to {_MAX_SENSORS} are "
            "read"
        )
    readers = dict(SENSOR_READERS)
    types = {declared.element.get("type", "").strip() for declared in model.sensors}
    if not types <= readers.keys():  # what packages add takes some time to find
        added = {type_: each.read for each in added_sensors() for type_ in each.types}
        readers = added | readers
    X_BM = body_pose(model, base_link)
    taken: set[str] = set()
    sensors: list[Sensor] = []
    for declared in model.sensors:
        kind = declared.element.get("type", "").strip()
        name = declared.element.get("name", "").strip() or kind
        element = f"sensor '{shortened_text(name)}'"
        link = model.link(declared.link)
        if kind not in readers or link is None:
            where = "" if link else ", which is not there"
            text = (
                f"of type {shortened_text(kind)} on link "
                f"'{shortened_text(declared.link)}'{where}; not used"
            )
            remarks.add("ignored", declared.element.file, element, text)
            continue
        block = XmlBlock(element, declared.element)
        X_BS = X_BM @ link.X_ML @ declared.X_LS
        x, y, z = (float_triple(row) for row in X_BS.rotation().matrix())
        name = free_name(taken, name, f"{link.name}/{name}")
        taken.add(name)
        common = Sensor(
            name=name,
            type=kind,
            frame=_declared_frame(block, declared),
            link=link.name,
            rate=_read_rate(block, declared, element, remarks),
            p_BS=float_triple(X_BS.translation()),
            R_BS=(x, y, z),
        )
        sensor = readers[kind](common, block, remarks)
        if sensor:
            sensors.append(sensor)
    # A sensor frame has the sensor's name if that is free, as in the tree of frames.
    others = {
        WORLD_FRAME_NAME,
        *(link.name for link in model.links),
        *(frame.name for frame in model.frames),
    }
    return tuple(
        sensor if sensor.frame else dataclasses.replace(sensor, frame=own)
        for sensor, (own, _, _) in zip(sensors, sensor_frames(sensors, others), strict=True)
    )


def _declared_frame(block: XmlBlock, declared: DeclaredSensor) -> str:
    """Return the label of readings in the file, else the link if S is its frame, else ""."""
    asked = next((text for tag in _SENSOR_FRAME_ID_TAGS if (text := block.text(tag))), "")
    in_link = declared.X_LS.IsNearlyEqualTo(RigidTransform(), 1e-12)
    return asked or (declared.link if in_link else "")


def _read_rate(block: XmlBlock, declared: DeclaredSensor, element: str, remarks: Remarks) -> float:
    """Return samples per second; the default of SDF and Gazebo is 0, every step."""
    if not block.has("update_rate"):
        text = "update_rate: not given, the usual one of its kind"
        remarks.add("assumed", declared.element.file, element, text)
    rate = block.non_negative("update_rate", 0.0)
    if rate > _MAX_SAMPLE_RATE_HZ:
        raise block.fault("update_rate", f"give it at most {_MAX_SAMPLE_RATE_HZ:g} per second")
    return rate
