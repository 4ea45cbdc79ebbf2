"""Run every benchmark: `make bench`, or `python benchmarks/run.py --json FILE`."""

import argparse
import dataclasses
import json
import os
import platform
import sys
from importlib.metadata import version
from pathlib import Path

import flight_core

PACKAGES = ("drake", "numpy", "numba")


def main() -> None:
    """Print the tables and, where asked, write them as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path, help="file for the figures")
    arguments = parser.parse_args()
    versions = {name: version(name) for name in PACKAGES}
    machine = f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}"
    print(f"{machine}; {', '.join(f'{name} {number}' for name, number in versions.items())}\n")
    rows = flight_core.measure()
    flight_core.show(rows)
    if arguments.json:
        figures = {
            "machine": machine,
            "versions": versions,
            "flight_core": [dataclasses.asdict(row) for row in rows],
        }
        arguments.json.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
        print(f"\nwritten to {arguments.json}", file=sys.stderr)


if __name__ == "__main__":
    main()
