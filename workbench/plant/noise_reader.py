"""Read the noise of sensors, as SDF has it."""

import dataclasses

from workbench.plant.formats.block import XmlBlock
from workbench.plant.remarks import Remarks
from workbench.plant.sensors import NO_NOISE, Noise

Noises = tuple[Noise, Noise, Noise]


def read_noise(block: XmlBlock, remarks: Remarks) -> Noise:
    """Return the noise in the `<noise>` of a block; zero without one.

    Its type is an attribute; up to SDF 1.4, and still in lidars and cameras, it is a child.
    """
    return _read_typed_noise(block.block("noise"), block.block("noise"), remarks)


def read_noise_of_many(block: XmlBlock, remarks: Remarks) -> Noise:
    """Return the noise of the rays of a lidar or pixels of a camera; their biases do not drift."""
    read = read_noise(block, remarks)
    if read.dynamic_bias_stddev:
        noise = block.block("noise")
        text = "drift of a bias (dynamic_bias_...) of rays and pixels is not used"
        remarks.add("ignored", noise.file, noise.what, text)
    return dataclasses.replace(read, dynamic_bias_stddev=0.0, dynamic_bias_correlation_time=0.0)


def read_axes(imu: XmlBlock, quantity: str, old: str, remarks: Remarks) -> Noises:
    """Return the noise of a quantity of an IMU along x, y, z.

    Args:
        imu: the `<imu>` block.
        quantity: the name of its block: `angular_velocity` or `linear_acceleration`.
        old: its name up to SDF 1.4, inside `<noise>` and for all axes together: `rate` or `accel`.
        remarks: receives remarks on what is not used.
    """
    together = _read_typed_noise(imu.block("noise"), imu.block("noise", old), remarks)

    def along(axis: str) -> Noise:
        block = imu.block(quantity, axis)
        return read_noise(block, remarks) if block.has("noise") else together

    return (along("x"), along("y"), along("z"))


def _read_typed_noise(typed: XmlBlock, figures: XmlBlock, remarks: Remarks) -> Noise:
    """Return the noise of a block of figures; its type is in that block or in one above."""
    element = typed.what
    kind = (typed.attribute("type") or typed.text("type")).lower()
    if typed.there and not kind:
        remarks.add("assumed", typed.file, element, "noise without a type is taken as gaussian")
    kind = kind or "gaussian"
    if kind == "none":
        return NO_NOISE
    if kind not in ("gaussian", "gaussian_quantized"):
        text = f"noise of the type {kind[:40]} is not known; taken as none"
        remarks.add("ignored", typed.file, element, text)
        return NO_NOISE
    noise = Noise(
        mean=figures.number("mean", 0.0),
        stddev=figures.non_negative("stddev", 0.0),
        bias_mean=figures.number("bias_mean", 0.0),
        bias_stddev=figures.non_negative("bias_stddev", 0.0),
        dynamic_bias_stddev=figures.non_negative("dynamic_bias_stddev", 0.0),
        dynamic_bias_correlation_time=figures.non_negative("dynamic_bias_correlation_time", 0.0),
        precision=figures.non_negative("precision", 0.0),
    )
    if noise.dynamic_bias_stddev and not noise.dynamic_bias_correlation_time:
        text = "dynamic_bias_stddev without dynamic_bias_correlation_time: no drift, as in Gazebo"
        remarks.add("ignored", typed.file, element, text)
    return noise
