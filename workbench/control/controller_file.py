"""Load controllers, shipped ones by name and those in files of the user, and check them."""

import copyreg
import importlib
import math
import types
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache, lru_cache
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.extensions import ExtensionGroup, load_extension
from workbench.common.jitable import mark_functions
from workbench.common.own_file import (
    check_names,
    find_user_file,
    limit_executed_lines,
    read_memory,
    read_parameters,
    read_update,
    read_user_file,
    read_user_table,
    run_user_file,
    user_code_errors,
)
from workbench.common.parameter import Parameter
from workbench.control.controller import (
    COMMON_PARAMETERS,
    LAW_TRIAL_PERIOD_S,
    ZERO_VECTOR,
    Controller,
    hovering_motion,
    law_trial,
)
from workbench.control.guidance import (
    LawResult,
    MeasuredMotion,
)
from workbench.control.installed_laws import (
    DEFAULT_CONTROLLER,
    SHIPPED_CONTROLLERS,
    is_shipped,
    known_laws,
    law_group_of,
    shipped_file,
)
from workbench.control.law_program import not_repeatable_error
from workbench.control.loop import LOOP_AXES, Loop
from workbench.control.schedule import split_label
from workbench.control.scheduled_controller import scheduled_controller
from workbench.control.system_controller import controller_of_system
from workbench.plant.gravity import GRAVITY

if TYPE_CHECKING:
    from workbench.estimation.estimators import Estimator


UPDATE_ARGUMENTS = ("measured", "setpoint", "g", "vehicle", "memory", "dt", "loops")
"""Of `update`, in this order."""
LAW_PERIOD_RANGE_S = (1 / 4096, 0.05)
"""Smallest and largest period of a law [s]."""
MAX_DIVIDER = 1000


def load_controller(name_or_path: str | Path = DEFAULT_CONTROLLER) -> Controller:
    """Return a controller by its name, or the one in a file or an installed module.

    The file's code runs, with the rights of whoever calls this.

    Args:
        name_or_path: `pd` or another of `known_laws`; the path of a file that ends in .py; or the
            name of an importable module, with a dot in it. A schedule of its gains may follow, as
            in `pd@speed=0,4,8`, see `control.schedule`.

    Raises:
        WorkbenchError: naming file and line of what is wrong.
    """
    name, label = split_label(str(name_or_path))
    if label:
        return scheduled_controller(load_controller(name), label)
    if is_shipped(name):
        return _shipped(name)
    path = find_user_file(name, "controller")
    if path is not None:
        for known in known_laws():
            if path.resolve() == shipped_file(known):
                return _shipped(known)
        return _from_text(path.stem, path.resolve(), read_user_file(path, "controller"))
    if "@" in name:
        raise WorkbenchError(
            f"controller {name}: there is no schedule after the @: write it as pd@speed=0,4,8"
        )
    raise unknown_name("controller", name, known_laws())


def controller_or_default(controller: Controller | None) -> Controller:
    """Return a controller, the default one where none is given."""
    return controller or load_controller()


def find_loop(name: str, controller: Controller | None = None) -> Loop:
    """Return a loop of a controller, the default one where none is given.

    Raises:
        WorkbenchError: if there is none of that name.
    """
    return controller_or_default(controller).loop(name)


@cache
def _shipped(name: str) -> Controller:
    """Return the controller with a name of `known_laws`.

    Raises:
        WorkbenchError: if its package is incomplete, or states something else in the group.
    """
    if name in SHIPPED_CONTROLLERS:
        return _from_file_of(name, importlib.import_module(f"workbench.controllers.{name}"))
    group = law_group_of(name)
    assert group is not None
    module = load_extension(group, name)
    if not isinstance(module, types.ModuleType) or module.__file__ is None:
        raise WorkbenchError(
            f"the entry '{name}' of {group} names {module!r:.60}: let it name a module that is the "
            "file of a law"
        )
    controller = _from_file_of(name, module)
    if (controller.program is not None) != (group is ExtensionGroup.LAW_PROGRAMS):
        raise WorkbenchError(
            f"{controller.file}: a law with a program belongs to {ExtensionGroup.LAW_PROGRAMS}, "
            f"and any other to {ExtensionGroup.LAWS}: move the entry '{name}' of {group}"
        )
    return _checked(controller)


def _from_file_of(name: str, module: types.ModuleType) -> Controller:
    path = Path(str(module.__file__))
    return _from_module(name, path, path.read_text(encoding="utf-8"), module)


@lru_cache(maxsize=32)
def with_estimator(controller: Controller, estimator: "Estimator | None") -> Controller:
    """Return a controller with the user's own estimator, or without one."""
    if estimator is controller.estimator:
        return controller
    return replace(controller, estimator=estimator)


@lru_cache(maxsize=32)
def with_setpoints(controller: Controller, rows: tuple[Parameter, ...]) -> Controller:
    """Return a controller with the parameters of the servos of a vehicle."""
    return controller if rows == controller.setpoints else replace(controller, setpoints=rows)


def controller_from_text(
    name: str,
    file: str,
    text: str,
    estimator: "Estimator | None" = None,
    setpoints: tuple[Parameter, ...] = (),
) -> Controller:
    """Return the controller of a text, in another process.

    Raises:
        WorkbenchError: naming file and line of what is wrong.
    """
    if setpoints:
        return with_setpoints(controller_from_text(name, file, text, estimator), setpoints)
    if estimator:
        return with_estimator(controller_from_text(name, file, text), estimator)
    name, label = split_label(name)
    if label:
        return scheduled_controller(controller_from_text(name, file, text), label)
    own = shipped_file(name) if is_shipped(name) else None
    if own and Path(file).parts[-2:] == own.parts[-2:] and text == _shipped(name).text:
        return _shipped(name)
    return _from_text(name, Path(file), text)


def pickle_controller(controller: Controller) -> tuple[Any, ...]:
    """Pickle the text of a controller, so that another process needs no file."""
    return controller_from_text, (
        controller.name,
        str(controller.file),
        controller.text,
        controller.estimator,
        controller.setpoints,
    )


copyreg.pickle(Controller, pickle_controller)


@lru_cache(maxsize=32)
def _from_text(name: str, file: Path, text: str) -> Controller:
    """Return the controller of a text; the same one for the same text."""
    module = run_user_file("controller", name, file, text)
    return _checked(_from_module(name, file, text, module))


def _checked(controller: Controller) -> Controller:
    """Return a controller that is not the core's own, after the trial of its functions."""
    if controller.program is None:
        file = controller.file
        with user_code_errors(file, "update"), limit_executed_lines(file):
            _check_law_by_trial(controller)
    return controller


def _from_module(name: str, file: Path, text: str, module: types.ModuleType) -> Controller:
    """Return the controller that a file states, checked."""
    own = vars(module)
    if "system" in own:
        return controller_of_system(name, file, text, own)
    if "program" in own:
        return _from_program(name, file, text, own)
    controller = Controller(
        name=name,
        file=file,
        text=text,
        parameters=(*read_parameters(file, own), *COMMON_PARAMETERS),
        update=read_update(file, own, UPDATE_ARGUMENTS),
        points=own.get("POINTS", {}),
        loops=read_user_table(file, own, "LOOPS", Loop, "Loop(...)"),
        memory=read_memory(file, own),
        rule=own.get("rule"),
        designed=read_user_table(file, own, "DESIGNED", str, '"k_speed"'),
        design=own.get("design"),
        period=_read_period(file, own),
        dividers=_read_dividers(file, own),
        servos=read_user_table(file, own, "SERVOS", str, '"pan_joint"'),
    )
    check_names(file, "parameter", controller.gain_names)
    _check_loops(controller)
    if bool(controller.designed) != callable(controller.design):
        raise WorkbenchError(
            f"{file}: DESIGNED and design(vehicle, g, dt) belong together: write both or none"
        )
    mark_functions(module)
    return controller


def _check_loops(controller: Controller) -> None:
    """Check the loop points and loops that a file states.

    Raises:
        WorkbenchError: if one is not valid, or a loop has an unknown point, axis or gain.
    """
    file, points = controller.file, controller.points
    if not isinstance(points, dict) or not all(
        isinstance(key, str) and isinstance(unit, str) for key, unit in points.items()
    ):
        raise WorkbenchError(f'{file}: POINTS is not a table: write {{"roll_error": "rad", ...}}')
    check_names(file, "loop", [each.name for each in controller.loops])
    rows = [row.name for row in controller.parameters]
    for loop in controller.loops:
        asked = [("loop point", point, list(points)) for point in (loop.error, loop.actuator)]
        asked += [("axis", loop.axis, list(LOOP_AXES))]
        asked += [("gain", gain_name, rows) for gain_name in loop.gains]
        for what, name, known in asked:
            if name and name not in known:
                raise WorkbenchError(
                    f"{file}: the loop {loop.name} has {unknown_name(what, name, known)}"
                )


def _read_period(file: Path, own: Mapping[str, Any]) -> float | None:
    """Return a file's `PERIOD` [s].

    Raises:
        WorkbenchError: if it is not a number in range that is exact in binary, because flights
            count whole steps.
    """
    period = own.get("PERIOD")
    if period is None:
        return None
    least, most = LAW_PERIOD_RANGE_S
    stated = float(period) if isinstance(period, int | float) else math.nan
    if not least <= stated <= most or not (stated / least).is_integer():
        raise WorkbenchError(
            f"{file}: PERIOD is {period!r:.40}: give it a multiple of 1/4096 s up to {most:g} s, "
            "as 1 / 512"
        )
    return stated


def _read_dividers(file: Path, own: Mapping[str, Any]) -> tuple[int, ...]:
    """Return a file's `DIVIDERS`.

    Raises:
        WorkbenchError: if one is not a whole number in range.
    """
    dividers = read_user_table(file, own, "DIVIDERS", int, "5")
    for divider in dividers:
        if not 1 <= divider <= MAX_DIVIDER:
            raise WorkbenchError(
                f"{file}: DIVIDERS has {divider}: give it numbers from 1 to {MAX_DIVIDER}"
            )
    return dividers


def _from_program(name: str, file: Path, text: str, own: Mapping[str, Any]) -> Controller:
    """Return the controller of a file whose law is a separate program."""
    rows = (*read_parameters(file, own), *COMMON_PARAMETERS)
    check_names(file, "parameter", [row.name for row in rows])

    def update(*_: object) -> LawResult:
        raise not_repeatable_error(name)

    return Controller(
        name=name,
        file=file,
        text=text,
        parameters=rows,
        update=update,
        memory=read_memory(file, own),
        rule=own.get("rule"),
        compiles=False,
        period=_read_period(file, own),
        dividers=_read_dividers(file, own),
        program=own["program"],
    )


def _check_law_by_trial(controller: Controller) -> None:
    """Run a file's functions twice with plain numbers: at rest in hover, and in motion.

    Raises:
        WorkbenchError: if a result is not what the interface requires.
    """
    where = f"{controller.file}:{controller.update.__code__.co_firstlineno}: update returns"
    trial = law_trial(controller)
    elapsed = (LAW_TRIAL_PERIOD_S,) * len(controller.dividers)
    v, q = (0.3, -0.2, 0.1), (0.97, 0.1, -0.2, 0.1)
    moving = MeasuredMotion(v, v, v, q, v, ZERO_VECTOR, (1.1 * GRAVITY, 0.01, -0.02, 0.01))
    servos = controller.servos
    moves = moving._replace(elapsed=(0.0,) * len(elapsed), joints=(0.1,) * (2 * len(servos)))
    memory: Sequence[float] = controller.initial_memory
    rest = hovering_motion(elapsed, len(servos))
    for measured, asked in ((rest, ZERO_VECTOR), (moves, (1.0, -0.5, 0.2))):
        found = trial(measured, asked, memory, controller.closed)
        if not isinstance(found, tuple) or len(found) != 2:
            raise WorkbenchError(
                f"{where} {found!r:.60}: let it return (F, m_x, m_y, m_z) and the memory"
            )
        memory = _finite(where, found[1], [state.name for state in controller.memory], "memory")
        _finite(where, found[0], ("F", "m_x", "m_y", "m_z", *servos), "wrench")


def _finite(where: str, found: object, names: Sequence[str], what: str) -> tuple[float, ...]:
    """Return a result of `update`, which must be a tuple of one finite number for each name."""
    if not isinstance(found, tuple) or len(found) != len(names):
        count = f" with {len(found)} places" if isinstance(found, tuple) else ""
        raise WorkbenchError(
            f"{where} {found!r:.60}{count} as {what}: let it be a tuple of {len(names)} numbers"
            + (f", {', '.join(names)}" if names else "")
        )
    for name, value in zip(names, found, strict=True):
        if not isinstance(value, Real) or not math.isfinite(value):
            raise WorkbenchError(
                f"{where} {value!r:.60} as {name} of the {what}: let it be a finite number, also "
                "at rest in hover"
            )
    return found
