"""Gain files: the values of live parameters that belong to a vehicle, as YAML."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from workbench.errors import WorkbenchError, unknown_name
from workbench.parameters import defaults, find_parameter
from workbench.yaml_files import YamlFile, read_yaml

_KEYS = ("vehicle", "origin", "gains")


@dataclass(frozen=True)
class GainFile:
    """A set of parameter values with the vehicle they are for and where they come from."""

    vehicle: str
    origin: str
    gains: Mapping[str, float]


def load_gains(path: Path) -> GainFile:
    """Read and check a gain file.

    Raises:
        WorkbenchError: naming file and line of what is wrong.
    """
    file = read_yaml(path)
    for key in file.data:
        if key not in _KEYS:
            raise WorkbenchError(f"{file.where(key)}{unknown_name('key', str(key), _KEYS)}")
    gains = file.data.get("gains")
    if not isinstance(gains, dict):
        raise WorkbenchError(
            f"{file.where('gains')}a gain file has 'gains:' with NAME: VALUE lines"
        )
    return GainFile(
        vehicle=str(file.data.get("vehicle", "")),
        origin=str(file.data.get("origin", "")),
        gains={name: _checked(file, name, value) for name, value in gains.items()},
    )


def vehicle_gains(description: Path) -> dict[str, float]:
    """Return all values for a vehicle: defaults, then `gains.yaml` beside its description."""
    values = defaults()
    beside = description.parent / "gains.yaml"
    if beside.is_file():
        values.update(load_gains(beside).gains)
    return values


def _checked(file: YamlFile, name: str, value: Any) -> float:
    where = file.where("gains", name)
    try:
        parameter = find_parameter(name)
    except WorkbenchError as error:
        raise WorkbenchError(f"{where}{error}") from None
    return parameter.check(value, where)
