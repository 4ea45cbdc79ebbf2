"""Frequent commands, compared with the time to import Drake's plant.

Each is a separate process, in turns with one that only imports `pydrake.multibody.plant`, with warm
caches. Wall-clock time is what a user waits for: a second process draws pictures, so it needs two
free cores. Processor time, of both processes, depends less on other load.

On two free cores each command meets its target in wall-clock time. Half of the processor time of
`step`, `judge` and `sweep` is for the picture, a third of that for loading matplotlib. A second
free core draws the picture at the same time. With one free core, the wall-clock ratios are about
as large as those of processor time.

The first use after installation compiles, unless `make setup` or `workbench compile` has done so;
here the cache is empty. `silence` is the longest time without a message.
"""

import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass

from spread import Spread, ratios, spread, text
from start_up import PLANT, Taken, run

ROUNDS = 4
RANGES = ("kp_velocity_x=2..8:32", "kp_pitch=100..400:32")
COMMANDS = (
    ("step", "--axis", "x", "--amplitude", "1"),
    ("judge",),
    ("linearize",),
    ("sweep", *RANGES, "--axis", "x", "--metric", "overshoot"),
    ("inspect", "dh_drone"),
    ("regress", "steps"),
)
FIRST = (COMMANDS[0], COMMANDS[3])


@dataclass(frozen=True)
class CommandRow:
    """A command.

    Attributes:
        name: the command line.
        wall: wall-clock time [s].
        cpu: processor time of the command and its processes [s].
        to_plant: wall-clock time relative to loading Drake's plant, turn by turn.
        least_to_plant: the same for the shortest times, which other load disturbs least.
        cpu_to_plant: processor time relative to loading it, turn by turn.
    """

    name: str
    wall: Spread
    cpu: Spread
    to_plant: Spread
    least_to_plant: float
    cpu_to_plant: Spread


@dataclass(frozen=True)
class FirstUse:
    """A command whose cache is empty.

    Attributes:
        command: the command line.
        seconds: time until it ends [s].
        silence: the longest time without a message [s].
    """

    command: str
    seconds: float
    silence: float


def measure(rounds: int = ROUNDS) -> dict[str, list[CommandRow] | list[FirstUse]]:
    """Return a row for each command, and for the first use of some."""
    with tempfile.TemporaryDirectory() as folder:
        return {
            "commands": _warm(rounds, folder),
            "first_uses": [_first_use(each, folder) for each in FIRST],
        }


def _warm(rounds: int, folder: str) -> list[CommandRow]:
    processes = {PLANT: ["-c", PLANT]}
    processes |= {_name(each): ["-m", "workbench", *each] for each in COMMANDS}
    taken: dict[str, list[Taken]] = {name: [] for name in processes}
    for turn in range(rounds + 1):
        for name, arguments in processes.items():
            found = run(arguments, folder)
            if turn:  # the first fills the caches
                taken[name].append(found)
    plant = taken[PLANT]
    return [
        CommandRow(
            name,
            wall=spread([each.wall for each in times]),
            cpu=spread([each.cpu for each in times]),
            to_plant=ratios([each.wall for each in times], [each.wall for each in plant]),
            least_to_plant=min(each.wall for each in times) / min(each.wall for each in plant),
            cpu_to_plant=ratios([each.cpu for each in times], [each.cpu for each in plant]),
        )
        for name, times in taken.items()
    ]


def _first_use(command: tuple[str, ...], folder: str) -> FirstUse:
    """Run a command with an empty cache, and listen to it."""
    with tempfile.TemporaryDirectory() as cache:
        began = said = time.perf_counter()
        silence = 0.0
        with subprocess.Popen(
            [sys.executable, "-m", "workbench", *command],
            cwd=folder,
            env={**os.environ, "XDG_CACHE_HOME": cache},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            bufsize=0,
        ) as process:
            assert process.stderr
            while process.stderr.read(4096):
                now = time.perf_counter()
                silence, said = max(silence, now - said), now
        ended = time.perf_counter()
    if process.returncode:
        raise RuntimeError(f"{_name(command)} ended with {process.returncode}")
    return FirstUse(_name(command), ended - began, max(silence, ended - said))


def _name(command: tuple[str, ...]) -> str:
    return " ".join(("workbench", *command))


def show(found: dict[str, list[CommandRow] | list[FirstUse]]) -> None:
    """Print the tables."""
    for row in found["commands"]:
        assert isinstance(row, CommandRow)
        cells = (row.wall, row.cpu, row.to_plant, row.cpu_to_plant)
        print(f"{row.name:40.40}  {';  '.join(map(text, cells))};  {row.least_to_plant:.2f}")
    for row in found["first_uses"]:
        assert isinstance(row, FirstUse)
        print(f"{row.command:40.40}  first {row.seconds:.1f} s, silent for {row.silence:.1f} s")


if __name__ == "__main__":
    show(measure())
