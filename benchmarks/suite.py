"""Time of the tests over that of a reference command, in one run, on a machine that is else idle.

`python benchmarks/suite.py test` runs `make test`; `test-slow` and `ci` (all of `.ci/run`) are the
others. The reference runs before and after: if the two differ by a fifth, the machine was not idle.
`--write` keeps the figures in benchmarks/suite.json.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import time
from pathlib import Path

from host import Host
from run import machine

ROOT = Path(__file__).resolve().parent.parent
FIGURES = Path(__file__).with_suffix(".json")
REFERENCE = (
    sys.executable,
    "-c",
    "import pydrake.all, scipy.signal, matplotlib.pyplot; sum(i * i for i in range(100_000_000))",
)
COMMANDS = {"test": ("make", "test"), "test-slow": ("make", "test-slow"), "ci": (".ci/run",)}
MOST_APART = 1.2


def main() -> None:
    """Measure, print, and keep the figures if that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("what", choices=COMMANDS)
    parser.add_argument("--write", action="store_true", help=f"keep the figures in {FIGURES.name}")
    args = parser.parse_args()
    host = Host()
    before, _, _ = timed(REFERENCE)
    wall, processor, code = timed(COMMANDS[args.what])
    after, _, _ = timed(REFERENCE)
    found = {
        "machine": machine(),
        "date": time.strftime("%Y-%m-%d"),
        "stolen_percent": round(host.stolen, 1),
        "exit_code": code,
        "wall_seconds": round(wall, 1),
        "processor_seconds": round(processor, 1),
        "reference_seconds": round((before + after) / 2.0, 2),
        "over_reference": round(2.0 * wall / (before + after), 1),
    }
    print(json.dumps(found, indent=1))
    if max(before, after) > MOST_APART * min(before, after):
        print(f"the machine was not idle: the reference took {before:.1f} s and {after:.1f} s")
        sys.exit(1)
    if args.write:
        known = json.loads(FIGURES.read_text(encoding="utf-8")) if FIGURES.exists() else {}
        text = json.dumps({**known, args.what: found}, indent=1)
        FIGURES.write_text(f"{text}\n", encoding="utf-8")


def timed(command: tuple[str, ...]) -> tuple[float, float, int]:
    """Return wall time and processor time of a command [s], and its exit code."""
    begun, used = time.perf_counter(), _used()
    done = subprocess.run(command, cwd=ROOT, env=os.environ | {"PYTHONDONTWRITEBYTECODE": ""})
    return time.perf_counter() - begun, _used() - used, done.returncode


def _used() -> float:
    """Return the processor time of all children that have ended [s]."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


if __name__ == "__main__":
    main()
