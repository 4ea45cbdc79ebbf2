"""Which rows of the parameter table a vehicle has: not every one has eight rotors, or a lidar."""

from collections.abc import Iterable, Mapping

from workbench.common.errors import WorkbenchError
from workbench.plant.vehicle import Vehicle
from workbench.scenario.parameters import (
    SENSOR_KINDS,
    Parameter,
    ParameterTable,
    parameter_table,
)


def vehicle_parameters(
    vehicle: Vehicle, table: ParameterTable | None = None
) -> tuple[Parameter, ...]:
    """Return the rows that mean something for a vehicle, in the table's order."""
    table = table or parameter_table()
    rotors = table.of("rotors")[: len(vehicle.rotors)]
    kinds = {sensor.kind for sensor in vehicle.sensors}
    return tuple(
        row
        for row in table
        if (row.system != "rotors" or row in rotors)
        and (row.system not in SENSOR_KINDS or row.system in kinds)
    )


def check_settings(
    vehicle: Vehicle, settings: Mapping[str, float], table: ParameterTable | None = None
) -> None:
    """Refuse values for rows that a vehicle has not, unless they are the defaults.

    So a file with every row of the table may be flown with any drone.

    Raises:
        WorkbenchError: for the first one.
    """
    table = table or parameter_table()
    changed = [
        row.name
        for name, value in settings.items()
        for row in table.sets(name)
        if value != row.default
    ]
    check_parameters(vehicle, changed, table)


def check_parameters(
    vehicle: Vehicle, names: Iterable[str], table: ParameterTable | None = None
) -> None:
    """Refuse names of rows that a vehicle has not.

    Raises:
        WorkbenchError: for the first one.
    """
    table = table or parameter_table()
    rows = vehicle_parameters(vehicle, table)
    for name in names:
        row = table.find(name)
        if row in rows:
            continue
        if row.system == "rotors":
            has = f"{len(vehicle.rotors)} rotors"
        else:
            has = f"no {row.system.replace('_', ' ')}"
        raise WorkbenchError(f"{name} cannot be set: {vehicle.name} has {has}")
