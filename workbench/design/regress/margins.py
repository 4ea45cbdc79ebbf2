"""The margins of a spec: limits on what each loop bears."""

import dataclasses
from collections.abc import Mapping

from workbench.design.judge.margins import LoopMargins, loop_margins
from workbench.design.linear.loops import find_loop
from workbench.design.linear.operating_point import parse_point
from workbench.design.linear.study import LinearStudy
from workbench.design.regress.case_check import check_limit
from workbench.design.regress.spec import SpecFile
from workbench.design.regress.verdict import Check
from workbench.errors import WorkbenchError, unknown_name
from workbench.gains import flight_gains
from workbench.scenario import Scenario
from workbench.yaml_files import YamlFile

MARGINS = tuple(
    margin.name for margin in dataclasses.fields(LoopMargins) if margin.name != "stable"
)
_UNITS = {
    "phase_margin": "rad",
    "delay_margin": "s",
    "bandwidth": "rad/s",
    "crossover": "rad/s",
}


def check_margins(content: SpecFile, file: YamlFile) -> None:
    """Refuse margins that do not exist.

    Raises:
        WorkbenchError: naming file and line of the first thing that is wrong.
    """
    try:
        parse_point(content.at)
    except WorkbenchError as error:
        raise WorkbenchError(f"{file.where('at')}{error}") from None
    for loop, limits in content.margins.items():
        try:
            find_loop(loop)
        except WorkbenchError as error:
            raise WorkbenchError(f"{file.where('margins', loop)}{error}") from None
        for name, limit in limits.items():
            where = file.where("margins", loop, name)
            if name not in MARGINS:
                raise WorkbenchError(f"{where}{unknown_name('margin', name, MARGINS)}")
            check_limit(limit, file, ("margins", loop, name))


def check_loops(
    content: SpecFile, common: Scenario, settings: Mapping[str, float]
) -> tuple[Check, ...]:
    """Return the margins of a spec's loops, cut at their actuators, beside their limits.

    Args:
        content: what the spec says.
        common: vehicle and rates, with a run's changes.
        settings: parameter values over those of the vehicle.
    """
    study = LinearStudy(common)
    values = flight_gains(study.vehicle, common.vehicle.gains, settings)
    steered = parse_point(content.at)
    held = dataclasses.replace(steered, hold=True)
    models = {hold: study.sampled(held if hold else steered, values) for hold in (False, True)}
    found = []
    for name, limits in content.margins.items():
        loop = find_loop(name)
        margins = loop_margins(models[loop.hold], loop.actuator)
        for margin, limit in limits.items():
            value = float(getattr(margins, margin))
            found.append(Check(f"{name} {margin}", _UNITS.get(margin, "1"), value, limit))
    return tuple(found)
