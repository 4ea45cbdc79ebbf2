"""A controller that is a Drake system."""

import inspect
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from workbench.common.errors import WorkbenchError
from workbench.common.own_file import (
    check_names,
    read_parameters,
    user_code_errors,
    user_record_type,
)
from workbench.common.parameter import State
from workbench.control.controller import (
    COMMON_PARAMETERS,
    LAW_TRIAL_BODY,
    LAW_TRIAL_PERIOD_S,
    Controller,
)
from workbench.control.loop import Loop


def controller_of_system(name: str, file: Path, text: str, own: Mapping[str, Any]) -> Controller:
    """Return the controller of a file that states a Drake system."""
    from workbench.control.system_law import (
        SYSTEM_POINTS,
        SYSTEM_STEP_AXES,
        SystemLaw,
    )  # it loads Drake

    make = own["system"]
    if not inspect.isfunction(make) or len(inspect.signature(make).parameters) != 3:
        raise WorkbenchError(f"{file}: system is not a function: write def system(vehicle, g, dt)")
    for stated in ("update", "MEMORY", "POINTS", "DESIGNED", "design"):
        if stated in own:
            raise WorkbenchError(
                f"{file}: states system and {stated}: a system has states and ports of its own, so "
                f"leave {stated} out"
            )
    gains = tuple(row.name for row in read_parameters(file, own))
    rows = (*read_parameters(file, own), *COMMON_PARAMETERS)
    check_names(file, "parameter", [row.name for row in rows])
    g = user_record_type("Gains", [row.name for row in rows])(*(row.default for row in rows))
    with user_code_errors(file, "system"):
        system = make(LAW_TRIAL_BODY, g, LAW_TRIAL_PERIOD_S)
    law = SystemLaw(file, make, system, LAW_TRIAL_PERIOD_S)
    return Controller(
        name=name,
        file=file,
        text=text,
        parameters=rows,
        update=law.update,
        points=SYSTEM_POINTS,
        loops=tuple(
            Loop(point, point, axis=SYSTEM_STEP_AXES[point], gains=gains) for point in SYSTEM_POINTS
        ),
        memory=tuple(State(f"x_{k + 1}", "1", value) for k, value in enumerate(law.memory)),
        rule=own.get("rule"),
        compiles=False,
        derivatives="AutoDiff" if law.converts else "differences",
    )
