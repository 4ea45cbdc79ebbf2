"""What is done for a block of candidates, compiled: fly it, and measure its steps."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from workbench.common.compiled import compile_cached
from workbench.control.controller import Controller
from workbench.control.flight_law import SOURCES as LAW
from workbench.design.rollout.flight import make_fly_block
from workbench.design.rollout.measuring import measure_steps

SOURCES = (*LAW, "design/rollout", "design/tumbling.py", "design/response_metrics.py")
"""What the compiled flights stand in, below `workbench/`."""


@lru_cache(maxsize=64)
def compiled_block(controller: Controller) -> Callable[..., Any]:
    """Return the flight of a block with a controller, compiled at its first call."""
    whose = "" if controller.shipped else f" with {controller.name}"
    return compile_cached(
        make_fly_block(controller),
        SOURCES,
        f"flights by the thousand{whose}",
        parts=174,
        text=controller.digest,
        file=str(controller.file),
        nogil=True,
        error_model="numpy",  # divisions that might raise make no vector instructions
        fastmath={"contract"},  # a b + c in one instruction: a fifth quicker, equal to rounding
    )


compiled_measures = compile_cached(
    measure_steps,
    SOURCES,
    "the metrics of steps",
    nogil=True,
    error_model="numpy",
)
