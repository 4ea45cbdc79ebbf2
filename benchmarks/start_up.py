"""The time of whole commands, and how much of it is loading: `python benchmarks/start_up.py`.

Every command is a separate process, in turns with two reference processes: an interpreter that does
nothing, and one that imports Drake's plant. Caches are warm, including compiled Python. On a busy
machine, processor time is more reliable than wall-clock time.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass

from spread import Spread, ratios, spread, text

ROUNDS = 4
PYTHON = "python -c pass"
PLANT = "import pydrake.multibody.plant"
COMMANDS = (
    ("--help",),
    ("step", "--axis", "w"),
    ("step", "--gains", "nowhere.yaml"),
    ("step", "--axis", "x", "--amplitude", "1"),
    ("step", "--axis", "x", "--amplitude", "1", "--no-plots"),
    ("judge",),
)
MODULES = (
    "numpy",
    "numba",
    "matplotlib.figure",
    "pydrake.systems.framework",
    "pydrake.multibody.plant",
    "workbench.scenario.scenario",
    "workbench.session.session",
    "workbench.design.plots_step",
    "workbench.design.rollout.engine",
)


@dataclass(frozen=True)
class Taken:
    """Times of one process [s]."""

    wall: float
    cpu: float


@dataclass(frozen=True)
class StartRow:
    """A whole process: seconds by the clock and of the processor, and its ratios of the latter."""

    name: str
    wall: Spread
    cpu: Spread
    to_python: Spread
    to_plant: Spread


def measure(rounds: int = ROUNDS) -> list[StartRow]:
    """Return a row for each of the two yardsticks, the commands, and the main modules."""
    processes = {PYTHON: ["-c", "pass"], PLANT: ["-c", PLANT]}
    processes |= {" ".join(("workbench", *each)): ["-m", "workbench", *each] for each in COMMANDS}
    processes |= {f"import {name}": ["-c", f"import {name}"] for name in MODULES}
    taken: dict[str, list[Taken]] = {name: [] for name in processes}
    with tempfile.TemporaryDirectory() as folder:
        for turn in range(rounds + 1):
            for name, arguments in processes.items():
                found = run(arguments, folder)
                if turn:  # the first fills the caches
                    taken[name].append(found)
    python, plant = ([each.cpu for each in taken[name]] for name in (PYTHON, PLANT))
    rows = []
    for name, times in taken.items():
        cpu = [each.cpu for each in times]
        wall = spread([each.wall for each in times])
        rows.append(StartRow(name, wall, spread(cpu), ratios(cpu, python), ratios(cpu, plant)))
    return rows


def run(arguments: Sequence[str], folder: str) -> Taken:
    """Run Python in a folder and return what it took; refusals are among what is measured."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(
        [sys.executable, *arguments], cwd=folder, env=environment, capture_output=True, text=True
    )
    wall, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    if "Traceback" in done.stderr:
        raise RuntimeError(done.stderr)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Taken(wall, cpu)


def show(rows: list[StartRow]) -> None:
    """Print the table."""
    width = max(len(row.name) for row in rows)
    print(f"{'process':{width}}  median (quartiles) of wall [s]; processor [s]; of that the ratio")
    print(f"{'':{width}}  to an empty interpreter; to loading Drake's plant")
    for row in rows:
        cells = (row.wall, row.cpu, row.to_python, row.to_plant)
        print(f"{row.name:{width}}  {';  '.join(map(text, cells))}")


if __name__ == "__main__":
    show(measure())
