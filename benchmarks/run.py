"""Run every benchmark: `make bench`, or `python benchmarks/run.py --json FILE`."""

import argparse
import dataclasses
import json
import os
import platform
import sys
from importlib.metadata import version
from pathlib import Path

import design
import flight_core
import lidar
import live_sensors

PACKAGES = ("drake", "numpy", "numba", "embreex", "trimesh")


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
    print()
    rays = lidar.measure()
    lidar.show(rays)
    print()
    live, shares = live_sensors.measure_live(), live_sensors.measure_shares()
    live_sensors.show(live, shares)
    print()
    tools = design.measure()
    design.show(tools)
    if arguments.json:
        figures = {
            "machine": machine,
            "versions": versions,
            "flight_core": [dataclasses.asdict(row) for row in rows],
            "lidar": [dataclasses.asdict(row) for row in rays],
            "live_sensors": dataclasses.asdict(live),
            "design": [dataclasses.asdict(row) for row in tools],
            "sensor_shares": [dataclasses.asdict(row) for row in shares],
        }
        arguments.json.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
        print(f"\nwritten to {arguments.json}", file=sys.stderr)


if __name__ == "__main__":
    main()
