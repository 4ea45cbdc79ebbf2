"""The live parameters that a flight has, with their values."""

from contextlib import suppress

from workbench.errors import WorkbenchError
from workbench.session import Session
from workbench.vehicle_parameters import vehicle_parameters


def parameter_values(session: Session) -> dict[str, float]:
    """Return the live parameters that a flight has, by name."""
    values = {}
    for row in vehicle_parameters(session.vehicle):
        with suppress(WorkbenchError):  # of a sensor that does not measure
            values[row.name] = session.get(row.name)
    return values
