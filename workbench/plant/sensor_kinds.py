"""What the description says of each kind of sensor."""

import math
from collections.abc import Callable

from workbench.plant.remarks import Remarks
from workbench.plant.sensor_block import Block
from workbench.plant.sensor_noise import read_axes, read_noise, read_noise_of_many
from workbench.plant.sensors import (
    Barometer,
    DepthCamera,
    Gps,
    Imu,
    Lidar,
    RangeFinder,
    ScanAxis,
    Sensor,
)

_MOST_RAYS = 1_000_000
_MOST_PIXELS = 16_384


def _imu(common: Sensor, sensor: Block, remarks: Remarks) -> Imu:
    imu = sensor.block("imu")
    return Imu(
        **vars(common),
        angular_velocity=read_axes(imu, "angular_velocity", "rate", remarks),
        linear_acceleration=read_axes(imu, "linear_acceleration", "accel", remarks),
    )


def _gps(common: Sensor, sensor: Block, remarks: Remarks) -> Gps:
    gps = sensor.first("navsat", "gps")
    position, velocity = gps.block("position_sensing"), gps.block("velocity_sensing")
    return Gps(
        **vars(common),
        horizontal_position=read_noise(position.block("horizontal"), remarks),
        vertical_position=read_noise(position.block("vertical"), remarks),
        horizontal_velocity=read_noise(velocity.block("horizontal"), remarks),
        vertical_velocity=read_noise(velocity.block("vertical"), remarks),
    )


def _barometer(common: Sensor, sensor: Block, remarks: Remarks) -> Barometer:
    block = sensor.block("air_pressure")
    given = block.has("reference_altitude")
    return Barometer(
        **vars(common),
        reference_altitude=block.number("reference_altitude", 0.0) if given else None,
        noise=read_noise(block.block("pressure"), remarks),
    )


def _sonar(common: Sensor, sensor: Block, remarks: Remarks) -> RangeFinder:
    """Return a sonar; the defaults are those of SDF's sonar.sdf."""
    sonar = sensor.block("sonar")
    min_range, max_range = _range(sonar, 0.0, 1.0)
    text = "a sonar measures along its axis only, not in a cone"
    remarks.add("assumed", sensor.file, f"sensor '{sensor.sensor}'", text)
    return RangeFinder(**vars(common), min_range=min_range, max_range=max_range)


def _range(block: Block, least: float, most: float) -> tuple[float, float]:
    """Return the ends of a range, or these defaults where they are not there."""
    near, far = block.non_negative("min", least), block.non_negative("max", most)
    if near >= far:
        raise block.wrong(f"ranges from {near:g} m to {far:g} m: give max above min")
    return near, far


def _lidar(common: Sensor, sensor: Block, remarks: Remarks) -> Lidar | RangeFinder | None:
    """Return a lidar, or a range finder where it has a single ray, which then is along its x."""
    lidar = sensor.first("lidar", "ray", "gpu_lidar", "gpu_ray")
    if not lidar.there:
        text = f"of type {common.type} without a block of its scan and range; not used"
        remarks.add("ignored", sensor.file, f"sensor '{sensor.sensor}'", text)
        return None
    scan, limits = lidar.block("scan"), lidar.block("range")
    if not scan.has("horizontal"):
        raise scan.fault("horizontal", "add it, with samples and angles")
    horizontal = _scan_axis(scan.block("horizontal"), 640)
    vertical = _scan_axis(scan.block("vertical"), 1)
    if horizontal.samples * vertical.samples > _MOST_RAYS:
        raise scan.wrong(
            f"{horizontal.samples} x {vertical.samples} rays: give it up to {_MOST_RAYS} in total"
        )
    min_range, max_range = _range(limits, 0.0, 0.0)
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


def _scan_axis(block: Block, samples: int) -> ScanAxis:
    """Return the rays along one axis; `samples` is SDF's default. Resolution multiplies them."""
    resolution = block.number("resolution", 1.0)
    if resolution <= 0.0:
        raise block.fault("resolution", "give it a positive number")
    rays = block.count("samples", samples, _MOST_RAYS) * resolution
    if rays >= _MOST_RAYS + 0.5:
        raise block.wrong(f"{rays:.0f} rays: give it up to {_MOST_RAYS}")
    low, high = block.number("min_angle", 0.0), block.number("max_angle", 0.0)
    if low > high:
        raise block.wrong(f"angles from {low:g} to {high:g}: give max_angle above min_angle")
    return ScanAxis(max(1, round(rays)), low, high)


def _depth_camera(common: Sensor, sensor: Block, remarks: Remarks) -> DepthCamera:
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
        remarks.add("assumed", sensor.file, f"sensor '{sensor.sensor}'", text)
    fov = camera.number("horizontal_fov", 1.047)
    if not 0.0 < fov < 2.0 * math.pi:
        raise camera.fault("horizontal_fov", "give it an angle between 0 and 2 pi")
    near = own_clip.non_negative("near", clip.non_negative("near", 0.1))
    far = own_clip.non_negative("far", clip.non_negative("far", 100.0))
    if near >= far:
        raise camera.wrong(f"clips from {near:g} m to {far:g} m: give far above near")
    return DepthCamera(
        **vars(common),
        width=image.count("width", 320, _MOST_PIXELS),
        height=image.count("height", 240, _MOST_PIXELS),
        horizontal_fov=fov,
        near=near,
        far=far,
        noise=read_noise_of_many(camera, remarks),
    )


READERS: dict[str, Callable[[Sensor, Block, Remarks], Sensor | None]] = {
    "imu": _imu,
    "gps": _gps,
    "navsat": _gps,
    "air_pressure": _barometer,
    "sonar": _sonar,
    "lidar": _lidar,
    "ray": _lidar,
    "gpu_lidar": _lidar,
    "gpu_ray": _lidar,
    "depth": _depth_camera,
    "depth_camera": _depth_camera,
    "rgbd": _depth_camera,
    "rgbd_camera": _depth_camera,
}
"""By the type that a sensor is declared with; all others are not used, nor those that give None."""
