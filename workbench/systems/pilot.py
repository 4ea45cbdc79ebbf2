"""The pilot: the present command, held until the next one."""

from collections.abc import Sequence
from typing import NamedTuple

from pydrake.systems.framework import Context, DiscreteValues

from workbench.control.guidance import Reference
from workbench.control.mode import FlightMode, Request
from workbench.systems.discrete_system import DiscreteSystem

AT_REST = Reference(*[0.0] * len(Reference._fields))
"""No command, so that the flight mode holds the position."""


class Wish(NamedTuple):
    """A pilot's command.

    `request` is a `flight_mode.Request`, `serial` counts requests, `height` is that of a take-off
    [m].
    """

    reference: Reference = AT_REST
    request: float = 0.0
    serial: float = 0.0
    height: float = 0.0


def commanded(
    wish: Wish, velocity: Sequence[float] | None = None, yaw_rate: float | None = None
) -> Wish:
    """Return the wish with a velocity in W [m/s] and a yaw rate [rad/s]; None leaves it."""
    reference = wish.reference
    if velocity is not None:
        v_x, v_y, v_z = velocity
        reference = reference._replace(v_x=v_x, v_y=v_y, v_z=v_z, follow=0.0)
    if yaw_rate is not None:
        reference = reference._replace(yaw_rate=yaw_rate)
    return wish._replace(reference=reference)


def gone_to(wish: Wish, p_WB: Sequence[float]) -> Wish:
    """Return the wish with a position in W to go to [m]."""
    x, y, z = p_WB
    there = AT_REST._replace(yaw_rate=wish.reference.yaw_rate, p_x=x, p_y=y, p_z=z, follow=1.0)
    return wish._replace(reference=there)


def urgency(code: float) -> float:
    """Return the urgency of a request: of two unseen ones, the more urgent stays."""
    return float(Request.HOLD) if code == Request.ABORT_LANDING else code


def requested(wish: Wish, what: Request, height: float, mode: FlightMode, seen: float) -> Wish:
    """Return the wish with a request to the flight mode.

    Args:
        wish: until now.
        what: the request.
        height: of a take-off [m].
        mode: the present one.
        seen: serial number of the request that the flight mode saw last.
    """
    reference = wish.reference
    if what in (Request.LAND, Request.STOP) or mode in (FlightMode.OFF, FlightMode.ARMED):
        reference = AT_REST  # an old command must not take effect later
    code = float(what)
    if seen < wish.serial and wish.request != Request.HOLD:
        code = max(code, wish.request, key=urgency)  # the flight mode has not seen the last one
    return Wish(reference, code, wish.serial + 1.0, height)


class Pilot(DiscreteSystem):
    """Holds a `Wish` as state; it is written between steps, see `live_context`.

    Output ports:
        reference (8): see `guidance.Reference`.
        request (3): request (`flight_mode.Request`), its serial number, take-off height [m].
    """

    def __init__(self) -> None:
        super().__init__()
        self._reference = self.DeclareDiscreteState(len(Reference._fields))
        self._request = self.DeclareDiscreteState(3)
        self.DeclareStateOutputPort("reference", self._reference)
        self.DeclareStateOutputPort("request", self._request)

    def wish(self, context: Context) -> Wish:
        """Return the present wish."""
        reference = context.get_discrete_state(self._reference).CopyToVector().tolist()
        request = context.get_discrete_state(self._request).CopyToVector().tolist()
        return Wish(Reference(*reference), *request)

    def set_wish(self, context: Context, wish: Wish) -> None:
        """Set the wish."""
        self.write(context.get_mutable_discrete_state(), wish)

    def write(self, discrete_state: DiscreteValues, wish: Wish) -> None:
        """Write a wish to values of the state."""
        discrete_state.set_value(self._reference, list(wish.reference))
        discrete_state.set_value(self._request, list(wish[1:]))
