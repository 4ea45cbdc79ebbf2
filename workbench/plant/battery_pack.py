"""The battery of a description."""

import math
from itertools import pairwise
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.block import XmlBlock
from workbench.plant.formats.xml import Element
from workbench.plant.model import Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.sidecar import BatteryRows, find_sidecar, load_sidecar
from workbench.plant.vehicle import BatteryPack

_BATTERY_KIND = "battery plugin"
_BATTERY_FILE = "linear-battery"
_BATTERY_CLASS = "::LinearBatteryPlugin"
_HOVER_DURATION_TAG, _SAG_TAG = "hoverDuration", "sagCompensation"
"""Our own elements of that plugin."""
_S_PER_HOUR = 3600.0


def is_battery_plugin(plugin: Element) -> bool:
    """Return whether a plugin is gz-sim's linear battery, by its file or class name."""
    name, file = (plugin.get(key, "").strip() for key in ("name", "filename"))
    return name.endswith(_BATTERY_CLASS) or _BATTERY_FILE in file


def read_battery_pack(model: Model, sidecar: Path | None, remarks: Remarks) -> BatteryPack | None:
    """Return the battery of the sidecar, else that of gz-sim's LinearBatteryPlugin, else None.

    The open-circuit voltage of the plugin is E0 + E1 (1 - q/c) with the state of charge q/c (see
    its LinearBatteryPlugin.cc). Our element `openCircuitVoltage` in it, pairs of share and voltage,
    takes precedence. `hoverDuration` [s] and `sagCompensation` are ours, too.

    Args:
        model: with the plugins.
        sidecar: a requested one, instead of the one beside the description.
        remarks: receives a remark on an incomplete plugin.

    Raises:
        WorkbenchError: with file and line, for impossible numbers.
    """
    path = sidecar or find_sidecar(model.source)
    if path:
        file, stated = load_sidecar(path)
        if (rows := stated.battery) and file.data["battery"]:
            where = file.where("battery").removesuffix(": ")
            return _checked_battery(rows, where)
    plugins = [plugin for plugin in model.plugins if is_battery_plugin(plugin)]
    for plugin in plugins[1:]:
        text = "there are several; only the first is used"
        remarks.add("ignored", plugin.file, _BATTERY_KIND, text)
    return _battery_of_plugin(plugins[0], remarks) if plugins else None


def _battery_of_plugin(plugin: Element, remarks: Remarks) -> BatteryPack | None:
    tags = XmlBlock(_BATTERY_KIND, plugin)
    constant, linear = "open_circuit_voltage_constant_coef", "open_circuit_voltage_linear_coef"
    if not tags.has("capacity") or not (tags.has("openCircuitVoltage") or tags.has(constant)):
        text = f"it has no <capacity>, or no <{constant}>; not used"
        remarks.add("ignored", plugin.file, _BATTERY_KIND, text)
        return None
    if tags.has("openCircuitVoltage"):
        values = tags.numbers("openCircuitVoltage")
        points = [values[i : i + 2] for i in range(0, len(values), 2)]
    else:
        full = tags.positive(constant)
        slope = tags.numbers(linear)[0] if tags.has(linear) else 0.0
        points = [[0.0, full + slope], [1.0, full]]
    rows = BatteryRows(
        _S_PER_HOUR * tags.positive("capacity"),
        tags.non_negative("resistance", 0.0),
        points,
        tags.positive(_HOVER_DURATION_TAG) if tags.has(_HOVER_DURATION_TAG) else None,
        tags.non_negative(_SAG_TAG, 0.0) if tags.has(_SAG_TAG) else None,
    )
    return _checked_battery(rows, tags.where())


def _checked_battery(rows: BatteryRows, where: str) -> BatteryPack:
    """Return a battery with possible numbers.

    Raises:
        WorkbenchError: for an impossible number.
    """
    capacity, resistance, points = rows.capacity, rows.resistance, rows.open_circuit_voltage
    hover, sag = rows.hover_duration, rows.sag_compensation
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
    if not (hover is None or 0.0 < hover < math.inf):
        raise WorkbenchError(f"{where}: a battery hovers for a positive time")
    if not (sag is None or 0.0 <= sag <= 1.0):
        raise WorkbenchError(f"{where}: the compensated share of a battery's sag is 0 to 1")
    return BatteryPack(
        float(capacity),
        float(resistance),
        tuple((float(share), float(voltage)) for share, voltage in points),
        None if hover is None else float(hover),
        None if sag is None else float(sag),
    )
