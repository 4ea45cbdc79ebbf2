"""What is done for a block of candidates, compiled: fly it, and measure its steps."""

from workbench.common.compiled import compile_cached
from workbench.control.flight_law import SOURCES as LAW
from workbench.design.rollout.flight import fly_block
from workbench.design.rollout.measuring import measure_steps
from workbench.systems.vehicle_dynamics import SOURCES as DYNAMICS

OWN = ("rows.py", "filling.py", "law_loops.py", "body_loops.py", "flight.py")
TAKEN = ("candidates.py", "craft.py", "schedule.py")
"""What the arguments' types stand in: numba's cache keeps where to find them."""
SOURCES = (
    *LAW,
    *DYNAMICS,
    "dynamics/air/settings.py",
    "design/tumbling.py",
    *(f"design/rollout/{name}" for name in (*OWN, *TAKEN)),
)
"""The files that the compiled flights stand in, below `workbench/`."""

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
    ("design/rollout/measuring.py", "design/response_metrics.py"),
    "the metrics of steps",
    nogil=True,
    error_model="numpy",
)
