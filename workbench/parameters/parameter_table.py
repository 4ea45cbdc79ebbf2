"""The table of all parameters that can change in flight.

One row yields a slider, a `--set NAME=VALUE`, a line of `workbench params` and a test. A change of
a parameter never rebuilds the diagram; settings that would need that are in the scenario.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from typing import TYPE_CHECKING

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.parameter import Parameter, is_servo_parameter
from workbench.common.plain_text import plain_name
from workbench.parameters.flight_parameters import flight_parameters
from workbench.plant.sensors import sensor_kinds
from workbench.plant.servo import SERVO_SYSTEM

if TYPE_CHECKING:
    from workbench.plant.vehicle import Vehicle


def _no_sets(name: str) -> tuple[str, ...]:
    del name
    return ()


class ParameterTable:
    """The parameters of a flight, in order, see `Controller.table`.

    Args:
        first: the controller's own; those of every flight follow.
        last: those of the user's own estimator.
        sets: returns the names of all sets of a scheduled gain, () for a name that is none.
    """

    def __init__(
        self,
        first: tuple[Parameter, ...] = (),
        last: tuple[Parameter, ...] = (),
        sets: Callable[[str], tuple[str, ...]] = _no_sets,
    ) -> None:
        self.rows = (*first, *flight_parameters(), *last)
        self._by_name = {row.name: row for row in self.rows}
        self._sets = sets

    def __iter__(self) -> Iterator[Parameter]:
        return iter(self.rows)

    def __contains__(self, name: str) -> bool:
        """Return whether there is a parameter with a name, or sets of it."""
        try:
            return bool(self.sets(name))
        except WorkbenchError:
            return False

    def find(self, name: str, where: str = "") -> Parameter:
        """Return the row of a name.

        Args:
            name: of the parameter.
            where: file and line for the message, if any.

        Raises:
            WorkbenchError: if there is none.
        """
        if name in self._by_name:
            return self._by_name[name]
        if is_servo_parameter(name):
            raise self._unknown_servo(name, where)
        error = unknown_name("parameter", name, list(self._by_name))
        raise WorkbenchError(f"{where}{error}")

    def _unknown_servo(self, name: str, where: str) -> WorkbenchError:
        """Return the error for a setpoint of a servo that a flight does not have."""
        known = [row.name for row in self.of(SERVO_SYSTEM)]
        if known:
            return WorkbenchError(f"{where}{unknown_name('servo', name, known)}")
        return WorkbenchError(
            f"{where}{plain_name(name)} cannot be set: this drone has no servos, or its control "
            "law commands them all"
        )

    def sets(self, name: str, where: str = "") -> tuple[Parameter, ...]:
        """Return the row of a name, or those of all sets of a scheduled gain; see `find`."""
        every = self._sets(name)
        if name not in self._by_name and every and every[0] in self._by_name:
            return tuple(self._by_name[each] for each in every)
        return (self.find(name, where),)

    def defaults(self) -> dict[str, float]:
        """Return the default of every parameter by name."""
        return {row.name: row.default for row in self.rows}

    def checked(self, values: Mapping[str, float], where: str = "") -> dict[str, float]:
        """Return `values` if every name is in the table and every value within its limits.

        The name of a scheduled gain refers to all of its sets.

        Raises:
            WorkbenchError: for the first error, prefixed with `where`.
        """
        return {
            row.name: row.check(value, where)
            for name, value in values.items()
            for row in self.sets(name, where)
        }

    def of(self, system: str) -> tuple[Parameter, ...]:
        """Return the parameters of one system, in the order of its numeric parameter."""
        return tuple(row for row in self.rows if row.system == system)


@cache
def flight_table() -> ParameterTable:
    """Return the parameters of every flight, whatever its controller.

    A function, since installed packages may add sensors, and import this file themselves.
    """
    return ParameterTable()


def split_setting(text: str) -> tuple[str, float]:
    """Return name and number of a `NAME=VALUE` text; the name is not checked.

    Raises:
        WorkbenchError: if it is not of that form.
    """
    name, equals, value = text.partition("=")
    if not equals or not name.strip():
        raise WorkbenchError(f"'{text}' is not a setting: write NAME=VALUE, as kp_velocity_x=5")
    try:
        return name.strip(), float(value)
    except ValueError:
        raise WorkbenchError(f"{name.strip()} is '{value}': give it a number") from None


def vehicle_parameters(vehicle: "Vehicle", table: ParameterTable) -> tuple[Parameter, ...]:
    """Return the parameters that apply to a vehicle, in the order of the table."""
    rotors = table.of("rotors")[: len(vehicle.rotors)]
    kinds = {sensor.kind for sensor in vehicle.sensors}
    return tuple(
        row
        for row in table
        if (row.system != "rotors" or row in rotors)
        and (row.system != "cables" or vehicle.unloaded)
        and (row.system not in sensor_kinds() or row.system in kinds)
    )


def check_settings(
    vehicle: "Vehicle", settings: Mapping[str, float], table: ParameterTable
) -> None:
    """Check that parameters that do not apply to a vehicle have their defaults.

    So a file with every parameter of the table is valid for any drone.

    Raises:
        WorkbenchError: for the first error.
    """
    changed = [
        row.name
        for name, value in settings.items()
        for row in table.sets(name)
        if value != row.default
    ]
    check_parameters(vehicle, changed, table)


def check_parameters(vehicle: "Vehicle", names: Iterable[str], table: ParameterTable) -> None:
    """Check that all parameters apply to a vehicle.

    Raises:
        WorkbenchError: for the first error.
    """
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
