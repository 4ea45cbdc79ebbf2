"""How cost grows with candidates, rays, rotors and obstacles.

An exponent of one means that the cost is proportional to the amount, zero that it is constant. It
is a least-squares fit to the logarithms of the medians. For rotors or obstacles of a session, the
constant cost of the rest of the flight makes the exponent small. Turns alternate; times are
processor times of one thread.
"""

import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from lidar_scene import HEIGHT, MOVING, RECORD, lidar_in_a_diagram
from pydrake.math import RigidTransform
from spread import Spread, ratios, text
from sweep import SPEED, candidates

from workbench.common.resources import find_model
from workbench.design.rollout.engine import RolloutEngine
from workbench.plant.loading import load_vehicle
from workbench.scenario.scenario import Scenario, VehicleConfig
from workbench.session.session import Session

DRONES = Path(__file__).resolve().parent.parent / "tests" / "drones"
CANDIDATES = (64, 1024, 16384)
RAYS = (360, 1440, 5760)
ROTORS = {4: "h_quad", 6: "hexacopter", 8: "octocopter"}
OBSTACLES = (1, 10, 100)
CASTS = 50
"""A turn."""
FLIGHT = 1.0
"""Of a session a turn [s], and of a candidate."""
TURNS = 9


@dataclass(frozen=True)
class GrowthRow:
    """Cost of one amount.

    Attributes:
        name: what grows.
        amount: number of it.
        as_often: cost relative to the smallest amount.
        exponent: exponent of cost over amount, fitted to all amounts.
    """

    name: str
    amount: int
    as_often: Spread
    exponent: float


@dataclass(frozen=True)
class Growing:
    """Work for amounts: each is done once a turn."""

    name: str
    work: dict[int, Callable[[], object]]


def measure(turns: int = TURNS) -> list[GrowthRow]:
    """Return a row for each amount."""
    with TemporaryDirectory() as folder:
        kinds = [_candidates(), _rays(), _rotors(), _obstacles(Path(folder))]
        return [row for kind in kinds for row in _rows(kind, turns)]


def show(rows: list[GrowthRow]) -> None:
    """Print the table."""
    print("growth            amount   as often as the least      exponent")
    for row in rows:
        print(f"{row.name:16} {row.amount:7d}   {text(row.as_often):26} {row.exponent:6.2f}")


def _rows(kind: Growing, turns: int) -> Iterator[GrowthRow]:
    times: dict[int, list[float]] = {amount: [] for amount in kind.work}
    for turn in range(turns + 1):
        for amount, work in kind.work.items():
            begun = time.process_time()
            work()
            if turn:  # the first one warms up
                times[amount].append(time.process_time() - begun)
    print(f"  growth with {kind.name}", file=sys.stderr, flush=True)
    medians = [float(np.median(each)) for each in times.values()]
    slope = np.polyfit(np.log(list(times)), np.log(medians), 1)[0]
    least = times[min(times)]
    for amount, each in times.items():
        yield GrowthRow(kind.name, amount, ratios(each, least), float(slope))


def _candidates() -> Growing:
    engine = RolloutEngine(load_vehicle(find_model("dh_drone")), threads=1)

    def fly(count: int) -> Callable[[], object]:
        gains = candidates(engine.gains, count)
        return lambda: engine.measure(gains, "x", SPEED, duration=FLIGHT)

    return Growing("candidates", {count: fly(count) for count in CANDIDATES})


def _rays() -> Growing:
    lidar, _ = lidar_in_a_diagram()
    origin = np.array([0.0, 0.0, HEIGHT]) + RECORD.p_BS
    poses = [RigidTransform()] * MOVING

    def cast(count: int) -> Callable[[], object]:
        directions = lidar.pattern.directions_S[:count]
        assert len(directions) == count

        def repeat() -> None:
            for _ in range(CASTS):
                lidar.caster.cast(origin, directions, poses, RECORD.max_range)

        return repeat

    return Growing("rays", {count: cast(count) for count in RAYS})


def _rotors() -> Growing:
    work = {}
    for count, name in ROTORS.items():
        model = str(DRONES / f"{name}.urdf.xacro")
        session = Session(Scenario(vehicle=VehicleConfig(model=model)))
        assert len(session.vehicle.rotors) == count
        work[count] = _ticking(session)
    return Growing("rotors", work)


def _obstacles(folder: Path) -> Growing:
    work = {}
    for count in OBSTACLES:
        path = folder / f"{count}.yaml"
        path.write_text(_world(count), encoding="utf-8")
        work[count] = _ticking(Session(Scenario(world=str(path))))
    return Growing("obstacles", work)


def _world(count: int) -> str:
    """Return a world with posts on a grid around the drone, and none in its way."""
    side = 10
    rows = [
        f"  - {{name: post_{index}, shape: {{box: [0.2, 0.2, 3.0]}}, "
        f"position: [{2 + index % side}, {2 + index // side}, 1.5]}}"
        for index in range(count)
    ]
    return "\n".join(["obstacles:", *rows, ""])


def _ticking(session: Session) -> Callable[[], object]:
    return lambda: session.tick(FLIGHT)


if __name__ == "__main__":
    show(measure())
