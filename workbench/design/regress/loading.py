"""Read a spec, and refuse what cannot be judged, with file and line."""

import copy
import dataclasses
from pathlib import Path
from typing import Any

import yaml
from pydrake.common.yaml import yaml_load_typed

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.yaml_files import YamlFile, check_schema, read_yaml, with_numbers
from workbench.control.controller import DEFAULT
from workbench.design.regress.case_check import check_case
from workbench.design.regress.spec import SKIP, Case, Spec, SpecFile
from workbench.design.regress.spec_names import MARGINS, slug
from workbench.estimation.settings import ESTIMATORS
from workbench.scenario.scenario import (
    Scenario,
    check_scenario,
    chosen_controller,
    find_files,
    find_scenario_world,
)


def load_spec(path: Path | str, controller: str = "", trusted: Path | None = None) -> Spec:
    """Read and check a spec; what it names is looked for beside it first.

    Args:
        path: the file.
        controller: that flies in place of the one that the spec names: a shipped one's name, or a
            file's path. A file of Python that only the spec names does not run.
        trusted: a folder whose files of Python run nevertheless; None for none.

    Raises:
        WorkbenchError: naming file and line of what is wrong.
    """
    path = Path(path)
    file = with_numbers(_with_plain_limits(read_yaml(path)), SpecFile)
    check_schema(file, SpecFile)
    text = yaml.safe_dump(file.data, sort_keys=False)
    try:
        content = yaml_load_typed(schema=SpecFile, data=text, defaults=SpecFile())
    except (RuntimeError, TypeError, ValueError) as error:
        raise WorkbenchError(f"{path}: {' '.join(str(error).split())}") from error
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
    names = {MARGINS}
    for index, case in enumerate(content.cases):
        _find_log(case, index, file)
        check_case(case, index, file, content.controller)
        if slug(case.name) in names:
            where = file.where("cases", index, "name")
            raise WorkbenchError(f"{where}there is '{case.name}' already: take another name")
        names.add(slug(case.name))
    if content.margins:
        from workbench.design.regress.margins import check_margins  # loads the linear models

        check_margins(content, file)
    return Spec(path.resolve(), content)


def check_named(path: Path, controller: str) -> None:
    """Refuse a controller that is not the one a spec names; "" is none.

    Raises:
        WorkbenchError: if a baseline would be of another one.
    """
    file = read_yaml(path)
    named = str(file.data.get("controller") or DEFAULT)
    same = (path.parent / named).resolve() == Path(controller).resolve()
    if controller not in ("", named) and not same:
        raise WorkbenchError(
            f"{file.where('controller')}a baseline is of the spec as it stands, whose controller "
            f"is {named}: leave out --update, or write controller: {controller} into the spec"
        )


def _find_log(case: Case, index: int, file: YamlFile) -> None:
    """Let a case's log, and its mapping, be found beside the spec; refuse what is not there.

    A log that may be missing is looked for when the case is judged.
    """
    if case.log is None:
        return
    for key in ("file", "mapping"):
        name = getattr(case.log, key)
        if name:
            place = (file.path.parent / Path(name).expanduser()).resolve()
            setattr(case.log, key, str(place))
            if not place.is_file() and case.log.missing != SKIP:
                where = file.where("cases", index, "log", key)
                raise WorkbenchError(
                    f"{where}there is no {name} beside the spec: name a log, or write "
                    f"missing: {SKIP} to leave the case out where it is not there"
                )


def _with_plain_limits(file: YamlFile) -> YamlFile:
    """Return a file with limits that are written as [least, most], and logs as FILE, spelt out."""
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
