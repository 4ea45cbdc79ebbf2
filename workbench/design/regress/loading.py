"""Read and check a spec."""

import copy
import dataclasses
import logging
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.yaml_files import (
    YamlFile,
    as_record,
    check_schema,
    read_yaml,
    with_numbers,
)
from workbench.control.controller import Controller
from workbench.control.controller_file import load_controller
from workbench.control.installed_laws import DEFAULT_CONTROLLER
from workbench.design.metrics import find_metric
from workbench.design.regress.case_check import check_case, check_limit
from workbench.design.regress.spec import (
    MISSING_SKIP,
    Spec,
    SpecCase,
    SpecFile,
    SpecLimit,
)
from workbench.design.regress.spec_names import MARGINS_PART, slug
from workbench.estimation.settings import ESTIMATORS
from workbench.scenario.scenario import Scenario
from workbench.scenario.scenario_check import check_scenario
from workbench.scenario.scenario_file import chosen_controller, find_files, find_scenario_world

OLD_PHASE_MARGIN = "phase_margin"
"""The key of a phase margin in rad, in specs before 1.0."""
_log = logging.getLogger(__name__)


def load_spec(path: Path | str, controller: str = "", trusted: Path | str | None = None) -> Spec:
    """Read and check a spec; files named in it are first searched next to it.

    Args:
        path: the file.
        controller: replaces the one that the spec names: the name of a shipped one, or the path of
            a file. A Python file that only the spec names is not executed.
        trusted: a folder of Python files that may be executed; None for none.

    Raises:
        WorkbenchError: with file and line of the error.
    """
    path = Path(path)
    trusted = None if trusted is None else Path(trusted)
    file = with_numbers(_with_plain_limits(read_yaml(path)), SpecFile)
    check_schema(file, SpecFile)
    content: SpecFile = as_record(file.data, SpecFile)
    content.controller = chosen_controller(file, content.controller, controller, trusted)
    if content.estimator not in ESTIMATORS:
        unknown = unknown_name("estimator", content.estimator, ESTIMATORS)
        raise WorkbenchError(f"{file.where('estimator')}{unknown}")
    common = Scenario(
        vehicle=content.vehicle,
        controller=content.controller,
        estimator=content.estimator,
        world=content.world,
        sensors=content.sensors,
        rates=content.rates,
    )
    check_scenario(common, file)
    find_files(common.vehicle, file)
    find_scenario_world(common, file)
    content.world = common.world
    if not content.cases and not content.margins:
        raise WorkbenchError(f"{file.where()}a spec has cases, or margins")
    law, names = load_controller(content.controller), {MARGINS_PART}
    for index, case in enumerate(content.cases):
        _find_log(case, index, file)
        check_case(case, index, file, content.controller, law)
        if slug(case.name) in names:
            where = file.where("cases", index, "name")
            raise WorkbenchError(f"{where}there is '{case.name}' already: take another name")
        names.add(slug(case.name))
    if content.margins:
        _check_margins(content, file, law)
    return Spec(path.resolve(), content)


def check_named(path: Path, controller: str) -> None:
    """Check that a controller is the one that a spec names; "" is none.

    Raises:
        WorkbenchError: if a baseline would be for another one.
    """
    file = read_yaml(path)
    named = str(file.data.get("controller") or DEFAULT_CONTROLLER)
    same = (path.parent / named).resolve() == Path(controller).resolve()
    if controller not in ("", named) and not same:
        raise WorkbenchError(
            f"{file.where('controller')}a baseline belongs to the spec as it is written, whose "
            f"controller is {named}: leave out --update, or write controller: {controller} into "
            "the spec"
        )


def _find_log(case: SpecCase, index: int, file: YamlFile) -> None:
    """Resolve the log and mapping of a case relative to the spec, and reject missing files.

    A log that may be missing is searched when the case is judged.
    """
    if case.log is None:
        return
    for key in ("file", "mapping"):
        name = getattr(case.log, key)
        if name:
            place = (file.path.parent / Path(name).expanduser()).resolve()
            setattr(case.log, key, str(place))
            if not place.is_file() and case.log.missing != MISSING_SKIP:
                where = file.where("cases", index, "log", key)
                raise WorkbenchError(
                    f"{where}there is no {name} beside the spec: name a log, or write "
                    f"missing: {MISSING_SKIP} to leave the case out where it is not there"
                )


def _with_plain_limits(file: YamlFile) -> YamlFile:
    """Return a file with the short forms of limits [least, most] and logs FILE expanded."""
    data = copy.deepcopy(file.data)
    cases, margins = data.get("cases"), data.get("margins")
    for case in cases if isinstance(cases, list) else []:
        _spell_out(case.get("limits") if isinstance(case, dict) else None)
        if isinstance(case, dict) and isinstance(case.get("log"), str):
            case["log"] = {"file": case["log"]}
    for limits in margins.values() if isinstance(margins, dict) else []:
        _spell_out(limits)
    return dataclasses.replace(file, data=data)


def _spell_out(limits: Any) -> None:
    """Make {min: a, max: b} of each [a, b] of a mapping."""
    for name, limit in limits.items() if isinstance(limits, dict) else []:
        if isinstance(limit, list) and len(limit) == 2:
            limits[name] = {"min": limit[0], "max": limit[1]}


def _check_margins(content: SpecFile, file: YamlFile, law: Controller) -> None:
    """Check that margins exist, and write those of older specs in the unit of today's.

    Raises:
        WorkbenchError: naming file and line of the first thing that is wrong.
    """
    # slow to load, and most specs have no margins
    from workbench.design.judge.margins import LoopMargins
    from workbench.design.linear.operating_point import OperatingPoint, parse_point

    names = [
        find_metric(each.name).file_name
        for each in dataclasses.fields(LoopMargins)
        if each.name != "stable"
    ]
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
            if name not in (*names, OLD_PHASE_MARGIN):
                raise WorkbenchError(f"{where}{unknown_name('margin', name, names)}")
            check_limit(limit, file, ("margins", loop, name))
        if OLD_PHASE_MARGIN in limits:
            content.margins[loop] = _with_degrees(limits)
            _log.info(
                "%sphase_margin is read in rad, as in specs before 1.0: write phase_margin_deg",
                file.where("margins", loop, OLD_PHASE_MARGIN),
            )


def _with_degrees(limits: Mapping[str, SpecLimit]) -> dict[str, SpecLimit]:
    """Return limits of margins with that of the phase in degrees, in place of rad."""
    metric = find_metric(OLD_PHASE_MARGIN)
    return {
        metric.file_name if name == OLD_PHASE_MARGIN else name: (
            SpecLimit(metric.file_factor * limit.min, metric.file_factor * limit.max)
            if name == OLD_PHASE_MARGIN
            else limit
        )
        for name, limit in limits.items()
    }
