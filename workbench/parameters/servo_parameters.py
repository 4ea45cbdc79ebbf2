"""The setpoints of servos as live parameters, for those that no law commands."""

from collections.abc import Collection

from workbench.common.parameter import Parameter, servo_parameter_name
from workbench.common.plain_text import plain_name
from workbench.plant.servo import SERVO_SYSTEM, setpoint_range
from workbench.plant.vehicle import Vehicle, VehicleServo


def servo_parameters(vehicle: Vehicle, commanded: Collection[str] = ()) -> tuple[Parameter, ...]:
    """Return a row for each of `Vehicle.free_servos`, in their order.

    Args:
        vehicle: with the servos.
        commanded: joints whose servos the law commands.
    """
    rows: list[Parameter] = []
    for each in vehicle.free_servos(commanded):
        rows.append(_row(each, {row.name for row in rows}))
    return tuple(rows)


def _row(each: VehicleServo, others: set[str]) -> Parameter:
    """Return the row of a servo."""
    name = servo_parameter_name(each.joint)
    while name in others:
        name += "_"
    lower, upper = setpoint_range(each.servo, each.slides)
    return Parameter(
        name,
        each.setpoint_unit,
        f"setpoint of the servo of {plain_name(each.joint)}: {each.servo.kind}",
        lower,
        upper,
        default=each.servo.start,
        system=SERVO_SYSTEM,
        group="Servos",
    )
