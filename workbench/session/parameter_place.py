"""Where the diagram of a flight holds each parameter."""

from pydrake.systems.framework import System

from workbench.diagram.workbench import Workbench
from workbench.dynamics.air.settings import PUSH_FIELDS, WIND_FIELDS
from workbench.estimation.settings import AIDING_SENSORS, ESTIMATORS, USER_ESTIMATOR
from workbench.plant.sensors import sensor_kinds

ParameterPlace = tuple[System, int, int]
"""A system, the index of its numeric parameter, and an index in it."""


def parameter_places(bench: Workbench) -> dict[str, list[ParameterPlace]]:
    """Return the places of the first row of each system of the parameter table.

    Most systems have their rows in numeric parameter 0 of the diagram's system of that name.
    """
    airframe, computer, navigation = bench.airframe, bench.computer, bench.navigation
    places: dict[str, list[ParameterPlace]] = {
        each.get_name(): [(each, 0, 0)] for each in bench.diagram.GetSystems()
    }
    places |= {
        "gyro": [(airframe.imu, airframe.imu.settings_index, 0)],
        "payload": [(computer, computer.payload_index, 0)],
        "computer": [(computer, computer.settings_index, 0)],
    }
    for system, names in (
        (airframe.wind, WIND_FIELDS),
        (airframe.push, PUSH_FIELDS),
        (airframe.body_forces, ("drag_area", "air_density")),
    ):
        places |= {name: [(system, 0, number)] for number, name in enumerate(names)}
    for kind in sensor_kinds():
        places[kind] = [(each.system, 0, 0) for each in bench.sensing.of_kind(kind)]
    if computer.hooks_index is not None:  # the law knows whether it carries its loads
        places["cables"].append((computer, computer.hooks_index, 0))
    if navigation:
        own = navigation.estimator
        places[own.name if own.file is None else USER_ESTIMATOR] = [(navigation, 0, 0)]
        places["imu"].insert(0, (airframe.imu, airframe.imu.fault_index, 0))
    return places


def missing_system_remedy(system: str) -> str:
    """Return how to get a missing system into a flight."""
    if system in sensor_kinds():
        remedy = f"switch the {system.replace('_', ' ')} on, as `--sensors {system}`"
        if system in AIDING_SENSORS:
            remedy += ", or fly with an estimator, which reads it, as `--estimator ekf`"
        return remedy
    if system in ESTIMATORS:
        return f"fly with that estimator, as `--estimator {system}`"
    if system == "cables":
        return "fly a vehicle with a cable, see docs/joints.md"
    if system == "gauge":
        return "fly a drone that has a battery with an estimator, as `--estimator ekf`"
    return "fly in a world with obstacles, as `--world room`"
