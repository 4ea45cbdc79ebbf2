"""Noise of sensors, in the forms that SDF has had for it."""

from workbench.plant.remarks import Remarks
from workbench.plant.sensor_block import Block
from workbench.plant.sensors import QUIET, Noise

Noises = tuple[Noise, Noise, Noise]

_NOT_USED = ("dynamic_bias_stddev", "dynamic_bias_correlation_time", "precision")


def read_noise(block: Block, remarks: Remarks) -> Noise:
    """Return what the `<noise>` in a block says; none is quiet.

    Its type stands in an attribute, or up to SDF 1.4, and in lidars and cameras still, in a child.
    """
    return _noise(block.block("noise"), block.block("noise"), remarks)


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
    if any(figures.has(tag) for tag in _NOT_USED):
        text = "drift of a bias and rounding (dynamic_bias_..., precision) are not used"
        remarks.add("ignored", typed.file, element, text)
    return Noise(
        mean=figures.number("mean", 0.0),
        stddev=figures.non_negative("stddev", 0.0),
        bias_mean=figures.number("bias_mean", 0.0),
        bias_stddev=figures.non_negative("bias_stddev", 0.0),
    )
