"""The sidecar of an identification: rotors and body, for `--rotors` of any command."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml

from workbench.extras.flightdata.identify.identified_number import IdentifiedNumber
from workbench.plant.rotors import Rotor
from workbench.plant.vehicle import Vehicle

YAW_ROWS = ("inertia_z", "rotor_inertia")
"""Rows of quantities about z."""
YAW_FIELDS = ("moment_constant", "inertia")
SIDECAR_ROTOR_FIELDS = (
    *("motor_constant", "linear_motor_constant", "moment_constant"),
    *("time_constant_up", "time_constant_down", "max_rot_velocity"),
    *("rotor_drag_coefficient", "rolling_moment_coefficient", "inertia"),
    *("inflow_coefficient", "ground_effect_coefficient", "propeller_radius"),
)
"""Numbers of a rotor about z, and all that are written."""


def sidecar_text(vehicle: Vehicle, rows: Sequence[IdentifiedNumber], logs: Sequence[Path]) -> str:
    """Return the YAML of the sidecar.

    Args:
        vehicle: the identified one.
        rows: with the intervals.
        logs: used, for its head.
    """
    inertia = vehicle.inertia
    products = (inertia[0, 1], inertia[0, 2], inertia[1, 2])
    scale = yaw_scale(vehicle)
    moments = (inertia[0, 0], inertia[1, 1], scale * inertia[2, 2])
    content: dict[str, Any] = {
        "body": {
            "mass": vehicle.mass,
            "center_of_mass": [float(each) for each in vehicle.p_BoBcm_B],
            "inertia": [float(each) for each in (*moments, *products)],
        },
        "identified": [
            {
                "name": row.name,
                "unit": row.unit,
                "value": _shortened_number(part * row.value),
                "low": _shortened_number(part * row.low),
                "high": _shortened_number(part * row.high),
            }
            for row in rows
            for part in [scale if row.name in YAW_ROWS else 1.0]
        ],
        "rotors": [_rotor_entry(rotor, vehicle.base_link, scale) for rotor in vehicle.rotors],
    }
    if vehicle.battery:
        pack = vehicle.battery
        content["battery"] = {
            "capacity": pack.capacity,
            "resistance": pack.resistance,
            "open_circuit_voltage": [list(point) for point in pack.open_circuit_voltage],
            **{
                name: value
                for name in ("hover_duration", "sag_compensation")
                if (value := getattr(pack, name)) is not None
            },
        }
    names = ", ".join(log.name for log in logs)
    head = (
        f"# {vehicle.name} as identified by `workbench identify` from {names}.\n"
        f"# For any command: --model {vehicle.source.name} --rotors THIS_FILE\n"
    )
    return head + yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=100)


def yaw_scale(vehicle: Vehicle) -> float:
    """Return the factor on the inertia about z, and on all other quantities about z.

    A log only yields the inertia about z over the moment constant. If with the described constant
    it exceeds those about x and y together, which is impossible, both are reduced.
    """
    inertia = vehicle.inertia
    return float(min(1.0, (inertia[0, 0] + inertia[1, 1]) / inertia[2, 2]))


def _rotor_entry(rotor: Rotor, base_link: str, scale: float) -> dict[str, Any]:
    """Return a rotor as `plant.rotor_sources.sidecar` has it."""
    return {
        "name": rotor.name,
        "link": base_link,
        "position": [_shortened_number(each, 9) for each in rotor.p_BR],
        "axis": [_shortened_number(each, 9) for each in rotor.axis_B],
        "direction": "ccw" if rotor.direction > 0 else "cw",
        **{
            name: _shortened_number(getattr(rotor, name) * (scale if name in YAW_FIELDS else 1.0))
            for name in SIDECAR_ROTOR_FIELDS
        },
    }


def _shortened_number(value: float, digits: int = 6) -> float:
    return float(f"{value:.{digits}g}")
