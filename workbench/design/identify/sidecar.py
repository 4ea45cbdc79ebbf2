"""The file of rotors and body that any `--model` takes, written from what was identified."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml

from workbench.design.identify.result import Row
from workbench.plant.rotors import Rotor
from workbench.plant.vehicle import Vehicle

ABOUT_Z = ("inertia_z", "rotor_inertia")


def sidecar_text(vehicle: Vehicle, rows: Sequence[Row], logs: Sequence[Path]) -> str:
    """Return the sidecar's YAML.

    Args:
        vehicle: that was identified.
        rows: with the intervals.
        logs: that it comes from, for its head.
    """
    inertia = vehicle.inertia
    products = (inertia[0, 1], inertia[0, 2], inertia[1, 2])
    scale = yaw_scale(vehicle)
    moments = (inertia[0, 0], inertia[1, 1], scale * inertia[2, 2])
    content = {
        "body": {
            "mass": vehicle.mass,
            "center_of_mass": [float(each) for each in vehicle.p_BoBcm_B],
            "inertia": [float(each) for each in (*moments, *products)],
        },
        "identified": [
            {
                "name": row.name,
                "unit": row.unit,
                "value": _short(part * row.value),
                "low": _short(part * row.low),
                "high": _short(part * row.high),
            }
            for row in rows
            for part in [scale if row.name in ABOUT_Z else 1.0]
        ],
        "rotors": [_rotor(rotor, vehicle.base_link, scale) for rotor in vehicle.rotors],
    }
    if vehicle.battery:
        pack = vehicle.battery
        content["battery"] = {
            "capacity": pack.capacity,
            "resistance": pack.resistance,
            "open_circuit_voltage": [list(point) for point in pack.open_circuit_voltage],
        }
    names = ", ".join(log.name for log in logs)
    head = (
        f"# {vehicle.name} as identified by `workbench identify` from {names}.\n"
        f"# For any command: --model {vehicle.source.name} --rotors THIS_FILE\n"
    )
    return head + yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=100)


def yaw_scale(vehicle: Vehicle) -> float:
    """Return what the inertia about z is to be taken times, with all that turns about z.

    A log has the inertia about z over the moment constant alone. Where the described constant makes
    it more than those about x and y together, which no body's is, both are smaller.
    """
    inertia = vehicle.inertia
    return float(min(1.0, (inertia[0, 0] + inertia[1, 1]) / inertia[2, 2]))


def _rotor(rotor: Rotor, base_link: str, scale: float) -> dict[str, Any]:
    """Return a rotor as `plant.rotor_sources.sidecar_file` has it."""
    where: dict[str, Any] = {"name": rotor.name}
    direction = rotor.direction
    where["link"] = base_link
    where["position"] = [_short(each, 9) for each in rotor.p_BR]
    where["axis"] = [_short(each, 9) for each in rotor.axis_B]
    return where | {
        "direction": "ccw" if direction > 0 else "cw",
        "motor_constant": _short(rotor.motor_constant),
        "linear_motor_constant": _short(rotor.linear_motor_constant),
        "moment_constant": _short(scale * rotor.moment_constant),
        "time_constant_up": _short(rotor.time_constant_up),
        "time_constant_down": _short(rotor.time_constant_down),
        "max_rot_velocity": _short(rotor.max_rot_velocity),
        "rotor_drag_coefficient": _short(rotor.rotor_drag_coefficient),
        "rolling_moment_coefficient": _short(rotor.rolling_moment_coefficient),
        "inertia": _short(scale * rotor.inertia),
        "inflow_coefficient": _short(rotor.inflow_coefficient),
        "ground_effect_coefficient": _short(rotor.ground_effect_coefficient),
        "propeller_radius": _short(rotor.propeller_radius),
    }


def _short(value: float, digits: int = 6) -> float:
    return float(f"{value:.{digits}g}")
