"""The tuning screen's map: a grid of 32 x 32 gain pairs, each flown for two seconds of a step.

Compiled flights run in two threads and compute metrics without curves; times are wall-clock times
without the first map. Of the second of hover before a step, they fly only a sixteenth, because
nothing moves in still air. The map must follow a slider within a tenth of a second.
"""

import time
from dataclasses import dataclass

from spread import Spread, spread, text
from sweep import CORES, SPEED

from workbench.common.resources import find_model
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.sweep.ranges import SweepRange
from workbench.design.sweep.sweep import gain_map
from workbench.plant.loading import load_vehicle

SIDE, DURATION, TURNS = 32, 2.0, 30
REFRESH = 0.1
"""What a map may take [s]."""


@dataclass(frozen=True)
class MapRow:
    """One way to make the map.

    Attributes:
        name: what is flown.
        seconds: time for a map [s].
        of_refresh: time relative to the limit; required: at most 1.
    """

    name: str
    seconds: Spread
    of_refresh: Spread


def measure(turns: int = TURNS) -> list[MapRow]:
    """Make maps."""
    engine = RolloutEngine(load_vehicle(find_model("dh_drone")), threads=CORES)
    x, y = (_around(name, engine.gains[name]) for name in ("kp_pitch", "kd_pitch"))
    seconds = []
    for turn in range(turns + 1):
        begun = time.perf_counter()
        gain_map(engine, {}, x, y, axis="x", amplitude=SPEED, duration=DURATION)
        if turn:
            seconds.append(time.perf_counter() - begun)
    shares = [each / REFRESH for each in seconds]
    return [MapRow(f"{SIDE} x {SIDE} steps of {DURATION:g} s", spread(seconds), spread(shares))]


def show(rows: list[MapRow]) -> None:
    """Print the table."""
    for row in rows:
        print(
            f"{row.name}: {text(row.seconds)} s a map, {text(row.of_refresh)} of what it may take"
        )


def _around(name: str, own: float) -> SweepRange:
    """Return a gain from half to twice its own value."""
    return SweepRange(name, 0.5 * own, 2.0 * own, SIDE)


if __name__ == "__main__":
    show(measure())
