"""Compile the flights of a controller, on the true motion or on an estimate."""

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

from workbench.common.compiled import Compiled, compile_cached
from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller
from workbench.control.flight_law import LAW_SOURCES as LAW
from workbench.design.rollout.estimate import estimator_source
from workbench.design.rollout.flights import make_fly_block
from workbench.design.rollout.gyro import TRUE_STATE
from workbench.estimation.estimators import Estimator

ENGINE_SOURCES = (
    *LAW,
    "estimation",
    "systems/sensors/barometer.py",
    "design/rollout",
    "design/tumbling.py",
)
"""Sources of the compiled flights, below `workbench/`."""
FLIGHT_COMPILE_OPTIONS: dict[str, Any] = {
    "nogil": True,
    "error_model": "numpy",  # divisions that might raise make no vector instructions
    "fastmath": {"contract"},  # a b + c in one instruction
}
"""How flights are compiled."""
BLOCK_COMPILE_OPTIONS = FLIGHT_COMPILE_OPTIONS | {"_nrt": False}
"""How blocks of flights that make no arrays are compiled: without counts of references."""


@lru_cache(maxsize=64)
def compiled_fly(controller: Controller, estimator: Estimator | None) -> Callable[..., Any]:
    """Return the flight of up to 16 candidates with a controller, compiled at its first call.

    Args:
        controller: whose law flies.
        estimator: that tells it the motion; None tells it the truth.

    Raises:
        WorkbenchError: if the law cannot be compiled.
    """
    if not controller.compiles:
        raise WorkbenchError(
            f"{controller.name} is a system of Drake's, which cannot be compiled: fly it on the "
            "full diagram"
        )
    source = estimator_source(estimator) if estimator else TRUE_STATE
    return compiled_flights(
        make_fly_block(controller, source),
        "flights by the thousand",
        controller,
        estimator,
        options=BLOCK_COMPILE_OPTIONS,
    )


def compiled_flights(
    function: Callable[..., Any],
    what: str,
    controller: Controller,
    estimator: Estimator | None,
    text: str = "",
    options: Mapping[str, Any] = FLIGHT_COMPILE_OPTIONS,
) -> Compiled:
    """Return flights with a controller, compiled at their first call.

    Args:
        function: that flies.
        what: they are, for messages.
        controller: whose law flies.
        estimator: that tells it the motion; None for the truth.
        text: of what else the machine code depends on.
        options: see `FLIGHT_COMPILE_OPTIONS`.
    """
    whose = "" if controller.shipped else f" with {controller.name}"
    known = f" on the estimate {estimator.name}" if estimator else ""
    return compile_cached(
        function,
        ENGINE_SOURCES,
        f"{what}{whose}{known}",
        parts=300 if estimator else 260,
        text=f"{text}{controller.digest}{estimator.key if estimator else ''}",
        file=str(estimator.file if estimator and estimator.file else controller.file),
        **options,
    )
