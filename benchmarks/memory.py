"""Peak memory of separate processes, as the system reports it.

A sweep measures steps of five seconds and discards their curves, so its memory must not depend on
the number of candidates. A session keeps its recording, so it grows with the flight: it is measured
after a second and after ten minutes of flight.

The largest sweep must stay under 500 MB, including Python, Drake and numba's compiler.
"""

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from sweep import COUNTS, DURATION, SPEED

from workbench.design.sweep.case import SweepCandidate, SweepCase
from workbench.design.sweep.compiled_flights import fly_compiled
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Scenario
from workbench.session.session import Session
from workbench.setup import make_setup

FLIGHTS = (1.0, 600.0)
"""Durations of the sessions' flights [s]."""


@dataclass(frozen=True)
class MemoryRow:
    """What one process took.

    Attributes:
        name: what the process did.
        amount: candidates, or seconds of flight.
        megabytes: peak of resident memory [MB].
        more_than_least: difference from the first of its kind [MB].
    """

    name: str
    amount: float
    megabytes: float
    more_than_least: float


def measure() -> list[MemoryRow]:
    """Run the processes one after the other."""
    rows = []
    for kind, amounts in (("sweep", COUNTS), ("session", FLIGHTS)):
        peaks = [_peak(kind, amount) for amount in amounts]
        unit = "candidates" if kind == "sweep" else "seconds of flight"
        rows += [
            MemoryRow(f"{kind}, {unit}", amount, peak, peak - peaks[0])
            for amount, peak in zip(amounts, peaks, strict=True)
        ]
    return rows


def show(rows: list[MemoryRow]) -> None:
    """Print the table."""
    print("peak memory                    amount        MB    more than the first of its kind")
    for row in rows:
        print(f"{row.name:28} {row.amount:8.0f} {row.megabytes:9.0f} {row.more_than_least:9.0f}")


def _peak(kind: str, amount: float) -> float:
    command = [sys.executable, __file__, kind, str(amount)]
    answer = subprocess.run(command, check=True, capture_output=True, text=True)
    print(f"  memory: {kind} of {amount:g}", file=sys.stderr, flush=True)
    peak: float = json.loads(answer.stdout)
    return peak


def _sweep(count: int) -> None:
    case = SweepCase("x", SPEED, DURATION)
    spread = np.linspace(0.8, 1.2, count)
    some = [SweepCandidate({"kp_pitch": 225.0 * share}, Variation()) for share in spread.tolist()]
    list(fly_compiled(case, make_setup(case.scenario), some))


def _fly(duration: float) -> None:
    Session(Scenario(duration=duration)).run()


def _main(kind: str, amount: float) -> None:
    """Do one thing, and print the peak [MB]."""
    if kind == "sweep":
        _sweep(round(amount))
    else:
        _fly(amount)
    print(json.dumps(_own_peak()))


def _own_peak() -> float:
    """Return this process's peak [MB]; `resource` would give its parent's, if that was larger."""
    lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("VmHWM"))


if __name__ == "__main__":
    if len(sys.argv) > 1:
        _main(sys.argv[1], float(sys.argv[2]))
    else:
        show(measure())
