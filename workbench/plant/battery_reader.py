"""The battery that a description or the sidecar beside it states."""

import math
from itertools import pairwise
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.common.yaml_files import YamlFile
from workbench.plant.battery import BatteryPack
from workbench.plant.model import DeclaredPlugin, Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.sidecar_file import find_sidecar, load_battery
from workbench.plant.rotor_sources.tags import Tags

_KIND = "battery plugin"
_FILE = "linear-battery"
_CLASS = "::LinearBatteryPlugin"
_HOUR = 3600.0


def is_battery_plugin(plugin: DeclaredPlugin) -> bool:
    """Return whether a plugin is gz-sim's linear battery, by its file or its class."""
    name, file = (plugin.element.get(key, "").strip() for key in ("name", "filename"))
    return name.endswith(_CLASS) or _FILE in file


def read_battery(model: Model, sidecar: Path | None, remarks: Remarks) -> BatteryPack | None:
    """Return the battery of a sidecar, else that of gz-sim's LinearBatteryPlugin, else None.

    The plugin's voltage without load is E0 + E1 (1 - q/c) with q/c the share of charge (its
    LinearBatteryPlugin.cc); our `openCircuitVoltage` in it, pairs of share and voltage, counts
    more.

    Args:
        model: with the plugins.
        sidecar: a file that was asked for, instead of one that lies beside.
        remarks: where to note a plugin that tells too little.

    Raises:
        WorkbenchError: with file and line, for what cannot be.
    """
    path = sidecar or find_sidecar(model.source)
    found = load_battery(path) if path else None
    if found:
        file, rows = found
        points = rows.open_circuit_voltage
        return _checked(rows.capacity, rows.resistance, points, _where(file))
    plugins = [plugin for plugin in model.plugins if is_battery_plugin(plugin)]
    for plugin in plugins[1:]:
        text = "there are several; only the first counts"
        remarks.add("ignored", plugin.file, _KIND, text)
    return _of_plugin(plugins[0], remarks) if plugins else None


def _of_plugin(plugin: DeclaredPlugin, remarks: Remarks) -> BatteryPack | None:
    tags = Tags(plugin, _KIND)
    constant, linear = "open_circuit_voltage_constant_coef", "open_circuit_voltage_linear_coef"
    if not tags.has("capacity") or not (tags.has("openCircuitVoltage") or tags.has(constant)):
        text = f"it has no <capacity>, or no <{constant}>; not used"
        remarks.add("ignored", plugin.file, _KIND, text)
        return None
    if tags.has("openCircuitVoltage"):
        values = tags.numbers("openCircuitVoltage")
        points = [values[i : i + 2] for i in range(0, len(values), 2)]
    else:
        full = tags.positive(constant)
        slope = tags.numbers(linear)[0] if tags.has(linear) else 0.0
        points = [[0.0, full + slope], [1.0, full]]
    resistance = tags.not_negative("resistance") if tags.has("resistance") else 0.0
    return _checked(_HOUR * tags.positive("capacity"), resistance, points, tags.where())


def _checked(
    capacity: float, resistance: float, points: list[list[float]], where: str
) -> BatteryPack:
    """Return a battery that can be.

    Raises:
        WorkbenchError: saying what cannot.
    """
    if not (0.0 < capacity < math.inf and 0.0 <= resistance < math.inf):
        raise WorkbenchError(
            f"{where}: a battery has a positive capacity and a resistance of 0 or more"
        )
    shares = [point[0] for point in points if len(point) == 2]
    voltages = [point[1] for point in points if len(point) == 2]
    rising = all(one < other for one, other in pairwise(shares))
    falls = any(one > other for one, other in pairwise(voltages))
    if (
        len(shares) != len(points)
        or len(points) < 2
        or not rising
        or falls
        or (shares[0], shares[-1]) != (0.0, 1.0)
        or not 0.0 < voltages[0] <= voltages[-1] < math.inf
    ):
        raise WorkbenchError(
            f"{where}: the battery's open-circuit voltage is pairs of charge and V, both rising, "
            "from charge 0 to charge 1"
        )
    return BatteryPack(
        float(capacity),
        float(resistance),
        tuple((float(share), float(voltage)) for share, voltage in points),
    )


def _where(file: YamlFile) -> str:
    return file.where("battery").removesuffix(": ")
