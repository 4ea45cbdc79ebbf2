"""The margins of a spec: limits on what each loop bears."""

import dataclasses
from collections.abc import Mapping

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.yaml_files import YamlFile, read_yaml
from workbench.control.controller import load_controller
from workbench.design.judge.margins import LoopMargins, loop_margins
from workbench.design.linear.operating_point import OperatingPoint, parse_point
from workbench.design.linear.study import LinearStudy
from workbench.design.metrics import find_metric
from workbench.design.regress.case_check import check_limit
from workbench.design.regress.spec import Spec, SpecFile
from workbench.design.regress.verdict import Check
from workbench.gains.gains import flight_gains
from workbench.scenario.scenario import Scenario

MARGINS = tuple(
    margin.name for margin in dataclasses.fields(LoopMargins) if margin.name != "stable"
)


def check_margins(content: SpecFile, file: YamlFile) -> None:
    """Refuse margins that do not exist.

    Raises:
        WorkbenchError: naming file and line of the first thing that is wrong.
    """
    law = load_controller(content.controller)
    try:
        point = parse_point(content.at)
    except WorkbenchError as error:
        raise WorkbenchError(f"{file.where('at')}{error}") from None
    for loop, limits in content.margins.items():
        try:
            only_in_hover = law.loop(loop).hold
        except WorkbenchError as error:
            raise WorkbenchError(f"{file.where('margins', loop)}{error}") from None
        if only_in_hover and dataclasses.replace(point, hold=False) != OperatingPoint():
            raise WorkbenchError(
                f"{file.where('margins', loop)}{loop} is closed in hover only, and at is "
                f"'{content.at}': leave one out"
            )
        for name, limit in limits.items():
            where = file.where("margins", loop, name)
            if name not in MARGINS:
                raise WorkbenchError(f"{where}{unknown_name('margin', name, MARGINS)}")
            check_limit(limit, file, ("margins", loop, name))


def check_loops(spec: Spec, common: Scenario, settings: Mapping[str, float]) -> tuple[Check, ...]:
    """Return the margins of a spec's loops, cut at their actuators, beside their limits.

    Args:
        spec: with its loops.
        common: vehicle and rates, with a run's changes.
        settings: parameter values over those of the vehicle.

    Raises:
        WorkbenchError: if the vehicle cannot be built, or does not fly at the spec's point.
    """
    study = LinearStudy(common)
    values = flight_gains(study.vehicle, common.vehicle.gains, settings, study.controller)
    point = parse_point(spec.content.at)
    held = dataclasses.replace(point, hold=True) if _holding(spec.content) else point
    try:
        models = {at: study.sampled(at, values) for at in {point, held}}
    except WorkbenchError as error:
        raise WorkbenchError(f"{read_yaml(spec.path).where('at')}{error}") from None
    found = []
    for name, limits in spec.content.margins.items():
        loop = study.controller.loop(name)
        margins = loop_margins(models[held if loop.hold else point], loop.point("actuator"))
        for margin, limit in limits.items():
            value = float(getattr(margins, margin))
            found.append(Check(f"{name} {margin}", find_metric(margin).unit, value, limit))
    return tuple(found)


def _holding(content: SpecFile) -> bool:
    """Return whether there is a loop that is closed only while a place is held."""
    law = load_controller(content.controller)
    return any(law.loop(name).hold for name in content.margins)
