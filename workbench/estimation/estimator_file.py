"""Parts of an estimator in a file of the user: arrays and functions."""

import inspect
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.estimation import ekf_state

ESTIMATOR_ARGUMENTS = {
    "update": ("memory", "z", "settings", "mounting", "dt"),
    "begin": ("state", "mounting", "drawn", "known"),
    "covariance": ("memory",),
}
"""Arguments of the functions of a file, in this order."""


def optional_function(file: Path, own: Mapping[str, Any], name: str) -> Callable[..., Any] | None:
    """Return an optional function of a file, None without it.

    Raises:
        WorkbenchError: if it is not a function, or has other arguments.
    """
    function, wanted = own.get(name), ESTIMATOR_ARGUMENTS[name]
    if function is None:
        return None
    if not inspect.isfunction(function) or tuple(inspect.signature(function).parameters) != wanted:
        raise WorkbenchError(
            f"{file}: {name} is not a function of ({', '.join(wanted)}): write def "
            f"{name}({', '.join(wanted)}), or leave it out"
        )
    return function


def checked_array(file: Path, what: str, found: object, *shape: int) -> np.ndarray:
    """Return the result of a function of a file, which must be an array of finite numbers.

    Args:
        file: of the function.
        what: name of the function.
        found: its result.
        shape: required shape.

    Raises:
        WorkbenchError: if the result is anything else.
    """
    wanted = " x ".join(map(str, shape))
    if not isinstance(found, np.ndarray) or found.shape != shape:
        has = "x".join(map(str, found.shape)) if isinstance(found, np.ndarray) else repr(found)
        rule = ""
        if what == "begin":
            rule = f": {ekf_state.NOMINAL} of the nominal state, and one for each row of MEMORY"
        raise WorkbenchError(
            f"{file}: {what} returns {has:.60}: let it be an array of {wanted} numbers{rule}"
        )
    if not np.isfinite(found).all():
        raise WorkbenchError(f"{file}: {what} returns numbers that are not finite: correct it")
    return found.astype(float)
