"""Which rows of the parameter table a vehicle has: not every one has eight rotors, or a lidar."""

from collections.abc import Iterable, Mapping

from workbench.common.errors import WorkbenchError
from workbench.plant.vehicle import Vehicle
from workbench.scenario.parameters import (
    PARAMETERS,
    SENSOR_KINDS,
    Parameter,
    find_parameter,
    parameters_of,
)


def vehicle_parameters(vehicle: Vehicle) -> tuple[Parameter, ...]:
    """Return the rows that mean something for a vehicle, in the table's order."""
    rotors = parameters_of("rotors")[: len(vehicle.rotors)]
    kinds = {sensor.kind for sensor in vehicle.sensors}
    return tuple(
        row
        for row in PARAMETERS
        if (row.system != "rotors" or row in rotors)
        and (row.system not in SENSOR_KINDS or row.system in kinds)
    )


def check_settings(vehicle: Vehicle, settings: Mapping[str, float]) -> None:
    """Refuse values for rows that a vehicle has not, unless they are the defaults.

    So a file with every row of the table may be flown with any drone.

    Raises:
        WorkbenchError: for the first one.
    """
    check_parameters(vehicle, [n for n, v in settings.items() if v != find_parameter(n).default])


def check_parameters(vehicle: Vehicle, names: Iterable[str]) -> None:
    """Refuse names of rows that a vehicle has not.

    Raises:
        WorkbenchError: for the first one.
    """
    rows = vehicle_parameters(vehicle)
    for name in names:
        row = find_parameter(name)
        if row in rows:
            continue
        if row.system == "rotors":
            has = f"{len(vehicle.rotors)} rotors"
        else:
            has = f"no {row.system.replace('_', ' ')}"
        raise WorkbenchError(f"{name} cannot be set: {vehicle.name} has {has}")
