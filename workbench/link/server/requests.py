"""What a client asks of the flight, as the record that goes there."""

from workbench.link.backplane import (
    Asked,
    FlightOperation,
    GetParameters,
    ReleaseControl,
    RequestControl,
    SetParameters,
)
from workbench.link.operations import (
    FlightOp,
    GetParametersOp,
    Operation,
    ReleaseControlOp,
    RequestControlOp,
    SetParametersOp,
)


def for_flight(operation: Operation, peer: int, name: str) -> Asked:
    """Return what the flight is asked.

    Args:
        operation: of a client; one that the server does not answer itself.
        peer: the client's number.
        name: what it calls itself, or nothing.
    """
    match operation:
        case RequestControlOp(id):
            return RequestControl(peer, id, name or f"client {peer}")
        case ReleaseControlOp(id, lease):
            return ReleaseControl(peer, id, lease)
        case FlightOp(id, what, height, lease):
            return FlightOperation(peer, id, lease, what, height)
        case GetParametersOp(id, names):
            return GetParameters(peer, id, names)
        case SetParametersOp(id, values, lease):
            return SetParameters(peer, id, lease, values)
    raise TypeError(f"{operation} is nothing to ask a flight")
