"""The controller and the estimator of a scenario, and their parameters and control period."""

import dataclasses
from typing import TYPE_CHECKING

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller
from workbench.control.controller_file import load_controller, with_estimator
from workbench.estimation.settings import ESTIMATORS
from workbench.scenario.scenario import DEFAULT_CONTROL_PERIOD_S, Scenario

if TYPE_CHECKING:
    from workbench.estimation.estimators import Estimator


def flown_estimator(scenario: Scenario) -> "Estimator | None":
    """Return the user's own estimator in a scenario, None for a shipped one.

    Raises:
        WorkbenchError: if it cannot be read.
    """
    if scenario.estimator in ESTIMATORS:
        return None
    from workbench.estimation.estimators import find_estimator  # most flights do not need it

    return find_estimator(scenario.estimator)


def flown_controller(scenario: Scenario, controller: str = "") -> Controller:
    """Return the controller of a scenario, with the user's own estimator if any.

    Args:
        scenario: the one flown.
        controller: replaces that of the scenario.

    Raises:
        WorkbenchError: if one of them cannot be read, or both state a parameter of one name.
    """
    law = load_controller(controller or scenario.controller)
    law = with_estimator(law, flown_estimator(scenario))
    _ = law.table  # refuses a name that both state
    return law


def at_own_period(scenario: Scenario, controller: Controller) -> Scenario:
    """Return a scenario with the control period of its controller.

    This only replaces the default: a scenario that states another period keeps it.

    Args:
        scenario: the one flown.
        controller: that of the scenario.

    Raises:
        WorkbenchError: if its period is not a multiple of the physics step.
    """
    period = controller.period
    if period is None or scenario.rates.control_period != DEFAULT_CONTROL_PERIOD_S:
        return scenario
    step = scenario.rates.physics_step
    if not (period / step).is_integer():
        raise WorkbenchError(
            f"the controller {scenario.controller} is made for updates every {period:g} s, which "
            f"is not a multiple of the physics step {step:g} s: set physics_step to a part of it"
        )
    rates = dataclasses.replace(scenario.rates, control_period=period)
    return dataclasses.replace(scenario, rates=rates)


def script_controllers(
    scenario: Scenario, controller: Controller | None = None
) -> list[Controller]:
    """Return the controller that flies at each action of a script, which may change it.

    Args:
        scenario: the one flown.
        controller: that of the scenario, if already read.

    Raises:
        WorkbenchError: if a controller cannot be read.
    """
    law = controller or flown_controller(scenario)
    found = [law] * len(scenario.script)
    for index in sorted(range(len(found)), key=lambda index: scenario.script[index].at):
        name = scenario.script[index].controller
        if name is not None:
            law = flown_controller(scenario, name)
        found[index] = law
    return found
