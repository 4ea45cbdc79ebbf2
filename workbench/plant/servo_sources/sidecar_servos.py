"""Read servos from the sidecar of a description."""

import math
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.plant.rotor_sources.sidecar import ServoEntry, load_sidecar
from workbench.plant.servo import SERVO_KINDS, Servo
from workbench.plant.servo_sources.declared import DeclaredServo

_NOT_NEGATIVE = (
    "stiffness",
    "damping",
    "damping_ratio",
    "max_effort",
    "max_rate",
    "time_constant",
    "delay",
)
_MAX_SERVO_NUMBER = 1e9


def sidecar_servos(path: Path) -> tuple[DeclaredServo, ...]:
    """Return the servos of a sidecar, in its order.

    Raises:
        WorkbenchError: with file and line, for a missing or invalid value.
    """
    file, sidecar = load_sidecar(path)
    found = []
    for number, row in enumerate(sidecar.servos):

        def fault(key: str, reason: str, at: int = number) -> WorkbenchError:
            return WorkbenchError(f"{file.where('servos', at, key)}servos[{at}].{key} {reason}")

        if not row.joint:
            raise fault("joint", "is missing: name the joint that it drives")
        if row.kind not in SERVO_KINDS:
            raise fault("kind", f"must be one of {', '.join(SERVO_KINDS)}")
        for key in _NOT_NEGATIVE:
            value = getattr(row, key)
            if value is not None and not 0.0 <= value <= _MAX_SERVO_NUMBER:
                raise fault(key, "should be a positive number, or 0")
        lower, upper = (
            default if value is None else value
            for value, default in ((row.lower, -math.inf), (row.upper, math.inf))
        )
        if not lower < upper or not math.isfinite(row.start):
            raise fault("lower", "should be below upper, and start a number")
        found.append(DeclaredServo(row.joint, row.axis, _servo(row, lower, upper), path, "servos"))
    return tuple(found)


def _servo(row: ServoEntry, lower: float, upper: float) -> Servo:
    return Servo(
        kind=row.kind,
        stiffness=row.stiffness,
        damping=row.damping,
        damping_ratio=row.damping_ratio,
        lower=lower,
        upper=upper,
        start=row.start,
        max_effort=row.max_effort or math.inf,
        max_rate=row.max_rate or math.inf,
        time_constant=row.time_constant,
        delay=row.delay,
    )
