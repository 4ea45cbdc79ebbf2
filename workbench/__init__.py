"""A Drake-based workbench for designing a multirotor and its controller.

The public names are loaded on first use, so that `import workbench` stays free of
Drake, Qt and matplotlib.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from workbench.design.step_response import StepResponse, fly_step
    from workbench.diagram.core import make_flight_core
    from workbench.diagram.workbench import make_workbench
    from workbench.errors import WorkbenchError
    from workbench.plant.loading import load_vehicle
    from workbench.plant.vehicle import Vehicle
    from workbench.scenario import Scenario, SensorsConfig, VehicleConfig, load_scenario
    from workbench.session import Session

_HOME = {
    "Scenario": "workbench.scenario",
    "SensorsConfig": "workbench.scenario",
    "Session": "workbench.session",
    "StepResponse": "workbench.design.step_response",
    "Vehicle": "workbench.plant.vehicle",
    "VehicleConfig": "workbench.scenario",
    "WorkbenchError": "workbench.errors",
    "fly_step": "workbench.design.step_response",
    "load_scenario": "workbench.scenario",
    "load_vehicle": "workbench.plant.loading",
    "make_flight_core": "workbench.diagram.core",
    "make_workbench": "workbench.diagram.workbench",
}

__all__ = [
    "Scenario",
    "SensorsConfig",
    "Session",
    "StepResponse",
    "Vehicle",
    "VehicleConfig",
    "WorkbenchError",
    "fly_step",
    "load_scenario",
    "load_vehicle",
    "make_flight_core",
    "make_workbench",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'workbench' has no attribute '{name}'")
    return getattr(import_module(_HOME[name]), name)
