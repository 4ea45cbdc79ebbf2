"""Run the benchmarks: `make bench`, or `python benchmarks/run.py --only sweep --json FILE`.

Tables come on standard output, progress on standard error. With `--write`, docs/performance.json,
the page and the picture that follow from it are written, when all benchmarks have run; with
`--only` as well, some tables are measured anew, and say where if that is another machine or with
other versions.
"""

import argparse
import dataclasses
import importlib
import json
import os
import platform
import sys
import time
import traceback
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from page import DOCS, write
from simulators import version as pinned

PACKAGES = ("drake", "numpy", "numba", "embreex", "trimesh", "mujoco")
OTHERS = (
    ("rotorpy", "rotorpy"),
    ("rotorpy", "torch"),
    ("crazyflow", "crazyflow"),
    ("crazyflow", "jax"),
    ("pybullet_drones", "pybullet"),
)
NAMES = (
    "live_diagram",
    "joints",
    "same_flight",
    "sweep",
    "agreement",
    "fast_flights",
    "gain_map",
    "design",
    "lidar",
    "live_sensors",
    "live_flight",
    "analyst",
    "link_age",
    "link_flood",
    "link_hold",
    "log",
    "app",
    "charts",
    "executor",
    "commands",
    "start_up",
    "memory",
    "growth",
)


def main() -> int:
    """Measure, print, and write what is asked for; 1 if a benchmark broke."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", nargs="+", choices=NAMES, metavar="NAME", help=", ".join(NAMES))
    parser.add_argument("--json", type=Path, help="file for the figures")
    parser.add_argument("--write", action="store_true", help="write docs/performance.*")
    arguments = parser.parse_args()
    results: dict[str, Any] = {
        "machine": machine(),
        "versions": _versions(),
        "benchmarks": {},
    }
    if arguments.write and arguments.only:
        kept = json.loads((DOCS / "performance.json").read_text(encoding="utf-8"))
        here = {each: results[each] for each in ("machine", "versions")}
        same = all(kept[each] == here[each] for each in here)
        apart = {} if same else here | {"load": os.getloadavg()[0]}
        elsewhere = kept.get("apart", {}) | dict.fromkeys(arguments.only, apart)
        results = {**kept, "apart": {name: each for name, each in elsewhere.items() if each}}
    print(f"{results['machine']}\n", flush=True)
    broken = [name for name in arguments.only or NAMES if not _run(name, results["benchmarks"])]
    text = json.dumps(results, indent=1) + "\n"
    if arguments.json:
        arguments.json.write_text(text, encoding="utf-8")
        print(f"written to {arguments.json}", file=sys.stderr)
    if broken:
        print(f"broken: {', '.join(broken)}; no page is written", file=sys.stderr)
        return 1
    if arguments.write:
        (DOCS / "performance.json").write_text(text, encoding="utf-8")
        write(json.loads(text))
        print(f"written to {DOCS / 'performance.md'}", file=sys.stderr)
    return 0


def _run(name: str, benchmarks: dict[str, Any]) -> bool:
    """Measure one, print its table, and note its rows; say whether that went well."""
    print(f"{name} ...", file=sys.stderr, flush=True)
    begun = time.perf_counter()
    try:
        benchmark = importlib.import_module(name)
        rows = benchmark.measure()
        benchmark.show(rows)
    except Exception:  # the others are worth an hour; this one is told about at the end
        traceback.print_exc()
        return False
    print(flush=True)
    benchmarks[name] = _plain(rows)
    print(f"{name}: {time.perf_counter() - begun:.0f} s", file=sys.stderr, flush=True)
    return True


def _plain(rows: Any) -> Any:
    """Return rows as JSON has them."""
    if isinstance(rows, list | tuple):
        return [_plain(row) for row in rows]
    if isinstance(rows, dict):
        return {name: _plain(each) for name, each in rows.items()}
    return dataclasses.asdict(rows)


def _versions() -> dict[str, str]:
    """Return the versions of what is installed here, and of what others run on."""
    found = {}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found | {package: pinned(name, package) for name, package in OTHERS}


def machine() -> str:
    """Return processor, cores, memory and Python."""
    lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    cores = len(os.sched_getaffinity(0))
    processor = models[0] if models else platform.machine()
    return f"{processor}, {cores} cores, {memory:.0f} GiB, Python {platform.python_version()}"


if __name__ == "__main__":
    sys.exit(main())
