"""What is done for a block of candidates, compiled: fly it, and measure its steps."""

from workbench.common.compiled import compile_cached
from workbench.control.flight_law import SOURCES as LAW
from workbench.design.rollout.flight import fly_block
from workbench.design.rollout.measuring import measure_steps

SOURCES = (*LAW, "design/rollout", "design/tumbling.py", "design/response_metrics.py")
"""What the compiled flights stand in, below `workbench/`."""

compiled_block = compile_cached(
    fly_block,
    SOURCES,
    "flights by the thousand",
    parts=174,
    nogil=True,
    error_model="numpy",  # divisions that might raise make no vector instructions
    fastmath={"contract"},  # a b + c in one instruction: a fifth quicker, and equal to rounding
)
compiled_measures = compile_cached(
    measure_steps,
    SOURCES,
    "the metrics of steps",
    nogil=True,
    error_model="numpy",
)
