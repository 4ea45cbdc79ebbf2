"""The pilot: the present command, held until the next one."""

from collections.abc import Sequence
from typing import NamedTuple

from pydrake.systems.framework import Context, DiscreteValues

from workbench.control.guidance import Reference
from workbench.control.mode import FlightMode, ModeRequest
from workbench.systems.discrete_system import DiscreteSystem

ZERO_REFERENCE = Reference(*[0.0] * len(Reference._fields))
"""No command, so that the flight mode holds the position."""


class PilotCommand(NamedTuple):
    """A pilot's command.

    `request` is a `mode.ModeRequest`, `serial` counts requests, `height` is that of a take-off
    [m].
    """

    reference: Reference = ZERO_REFERENCE
    request: float = 0.0
    serial: float = 0.0
    height: float = 0.0


def with_velocity_command(
    command: PilotCommand, velocity: Sequence[float] | None = None, yaw_rate: float | None = None
) -> PilotCommand:
    """Return the command with a velocity in W [m/s] and a yaw rate [rad/s]; None leaves it."""
    reference = command.reference
    if velocity is not None:
        v_x, v_y, v_z = velocity
        reference = reference._replace(v_x=v_x, v_y=v_y, v_z=v_z, follow=0.0)
    if yaw_rate is not None:
        reference = reference._replace(yaw_rate=yaw_rate)
    return command._replace(reference=reference)


def with_position_command(command: PilotCommand, p_WB: Sequence[float]) -> PilotCommand:
    """Return the command with a position in W to go to [m]."""
    x, y, z = p_WB
    there = ZERO_REFERENCE._replace(
        yaw_rate=command.reference.yaw_rate, p_x=x, p_y=y, p_z=z, follow=1.0
    )
    return command._replace(reference=there)


def urgency(code: float) -> float:
    """Return the urgency of a request: of two unseen ones, the more urgent stays."""
    return float(ModeRequest.HOLD) if code == ModeRequest.ABORT_LANDING else code


def with_mode_request(
    command: PilotCommand, what: ModeRequest, height: float, mode: FlightMode, seen: float
) -> PilotCommand:
    """Return the command with a request to the flight mode.

    Args:
        command: until now.
        what: the request.
        height: of a take-off [m].
        mode: the present one.
        seen: serial number of the request that the flight mode saw last.
    """
    reference = command.reference
    if what in (ModeRequest.LAND, ModeRequest.STOP) or mode in (FlightMode.OFF, FlightMode.ARMED):
        reference = ZERO_REFERENCE  # an old command must not take effect later
    code = float(what)
    if seen < command.serial and command.request != ModeRequest.HOLD:
        code = max(code, command.request, key=urgency)  # the flight mode has not seen the last one
    return PilotCommand(reference, code, command.serial + 1.0, height)


class PilotSystem(DiscreteSystem):
    """Holds a `PilotCommand` as state; it is written between steps, see `live_context`.

    Output ports:
        reference (8): see `guidance.Reference`.
        request (3): request (`mode.ModeRequest`), its serial number, take-off height [m].
    """

    def __init__(self) -> None:
        super().__init__()
        self._reference = self.DeclareDiscreteState(len(Reference._fields))
        self._request = self.DeclareDiscreteState(3)
        self.DeclareStateOutputPort("reference", self._reference)
        self.DeclareStateOutputPort("request", self._request)

    def command(self, context: Context) -> PilotCommand:
        """Return the present command."""
        reference = context.get_discrete_state(self._reference).CopyToVector().tolist()
        request = context.get_discrete_state(self._request).CopyToVector().tolist()
        return PilotCommand(Reference(*reference), *request)

    def set_command(self, context: Context, command: PilotCommand) -> None:
        """Set the command."""
        self.write(context.get_mutable_discrete_state(), command)

    def write(self, discrete_state: DiscreteValues, command: PilotCommand) -> None:
        """Write a command to values of the state."""
        discrete_state.set_value(self._reference, list(command.reference))
        discrete_state.set_value(self._request, list(command[1:]))
