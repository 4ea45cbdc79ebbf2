"""Noise of sensors, in the forms that SDF has had for it."""

import dataclasses

from workbench.plant.remarks import Remarks
from workbench.plant.sensor_block import Block
from workbench.plant.sensors import QUIET, Noise

Noises = tuple[Noise, Noise, Noise]


def read_noise(block: Block, remarks: Remarks) -> Noise:
    """Return what the `<noise>` in a block says; none is quiet.

    Its type stands in an attribute, or up to SDF 1.4, and in lidars and cameras still, in a child.
    """
    return _noise(block.block("noise"), block.block("noise"), remarks)


def read_noise_of_many(block: Block, remarks: Remarks) -> Noise:
    """Return the noise of a lidar's rays or a camera's pixels, whose biases do not drift."""
    read = read_noise(block, remarks)
    if read.dynamic_bias_stddev:
        noise = block.block("noise")
        text = "drift of a bias (dynamic_bias_...) of rays and pixels is not used"
        remarks.add("ignored", noise.file, f"sensor '{noise.sensor}'", text)
    return dataclasses.replace(read, dynamic_bias_stddev=0.0, dynamic_bias_correlation_time=0.0)


def read_axes(imu: Block, quantity: str, old: str, remarks: Remarks) -> Noises:
    """Return the noise of a quantity of an IMU along x, y, z.

    Args:
        imu: the `<imu>` block.
        quantity: the name of its block: `angular_velocity` or `linear_acceleration`.
        old: that which SDF 1.4 had for all axes together, inside `<noise>`: `rate` or `accel`.
        remarks: where to note what is not used.
    """
    together = _noise(imu.block("noise"), imu.block("noise", old), remarks)

    def along(axis: str) -> Noise:
        block = imu.block(quantity, axis)
        return read_noise(block, remarks) if block.has("noise") else together

    return (along("x"), along("y"), along("z"))


def _noise(typed: Block, figures: Block, remarks: Remarks) -> Noise:
    """Return the noise of a block of figures whose type stands in that block or one above."""
    element = f"sensor '{typed.sensor}'"
    kind = (typed.attribute("type") or typed.text("type")).lower()
    if typed.there and not kind:
        remarks.add("assumed", typed.file, element, "noise of no type is taken as gaussian")
    kind = kind or "gaussian"
    if kind == "none":
        return QUIET
    if kind not in ("gaussian", "gaussian_quantized"):
        text = f"noise of the type {kind[:40]} is not known; taken as none"
        remarks.add("ignored", typed.file, element, text)
        return QUIET
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
