"""Times of the design tools: margins while a slider moves, and compiled flights.

The linear model and the margins of all loops must be ready within 20 ms, a frame of a screen at
50 Hz. Compiled flights are compared with flights of the full diagram, of the same step, in the same
run.
"""

import statistics
import time
from dataclasses import dataclass

from workbench.design.judge.loop_judgement import live_margins
from workbench.design.linear.study import LinearStudy
from workbench.design.rollout.engine import RolloutEngine
from workbench.scenario.scenario import Scenario
from workbench.session.session import Session

FRAME = 0.02
"""What a live update may take [s]."""
UPDATES = 100
CANDIDATES = 256
STEP = 3.0
"""Duration of the flights [s]."""


@dataclass(frozen=True)
class DesignRow:
    """One figure.

    Attributes:
        name: what was measured.
        seconds: time for an update or a flight [s].
        ratio: relative to a frame for updates (required: at most 1), to the diagram for flights.
    """

    name: str
    seconds: float
    ratio: float


def measure() -> list[DesignRow]:
    """Measure updates, and flights in turns with those of the diagram."""
    update = _update()
    engine = RolloutEngine(Session(Scenario()).vehicle)
    engine.fly([engine.gains], "x", 2.0, duration=STEP)  # compiles
    diagram, compiled = [], []
    for _ in range(5):
        session = Session(Scenario(duration=STEP + 1.0))
        session.command([2.0, 0.0, 0.0])
        diagram.append(_time(session.run))
        sets = [{**engine.gains, "kp_pitch": 150.0 + index} for index in range(CANDIDATES)]
        compiled.append(_time(lambda sets=sets: engine.fly(sets, "x", 2.0, duration=STEP)))
    full, fast = statistics.median(diagram), statistics.median(compiled) / CANDIDATES
    return [
        DesignRow("model and margins of all loops", update, update / FRAME),
        DesignRow("a step on the full diagram", full, 1.0),
        DesignRow(f"a compiled step, {CANDIDATES} at a time", fast, full / fast),
    ]


def show(rows: list[DesignRow]) -> None:
    """Print the table."""
    print("design: updates over a frame of 20 ms; flights as often as the diagram's")
    for row in rows:
        print(f"  {row.name:36} {1e3 * row.seconds:9.2f} ms {row.ratio:9.2f}")


def _update() -> float:
    """Return the median time of a live update, with other gains each time."""
    study = LinearStudy()
    live_margins(study)
    gains = [{"kp_pitch": 150.0 + index} for index in range(UPDATES)]
    return statistics.median(_time(lambda g=g: live_margins(study, g)) for g in gains)


def _time(function) -> float:
    begun = time.perf_counter()
    function()
    return time.perf_counter() - begun


if __name__ == "__main__":
    show(measure())
