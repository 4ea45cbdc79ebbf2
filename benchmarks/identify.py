"""Errors of identified numbers, and how often intervals hold the truth: docs/identification.md.

`python benchmarks/identify.py` flies 17 minutes with each of six vehicles, identifies them, and
prints the table; half an hour. `--runs 3` is what the tests do.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from tests.extras.flightdata.identify.test_identify import KINDS, identified


def main() -> None:
    """Fly, identify, and print what comes of it."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--runs", type=int, default=17, help="flights of each vehicle")
    runs = parser.parse_args().runs
    held: dict[str, list[bool]] = {}
    for kind in KINDS:
        found = identified(kind, runs)
        for name in found[0]:
            held.setdefault(name, []).extend(abs(each[name][0]) <= each[name][1] for each in found)
        errors = (f"{name} {np.median([abs(e[name][0]) for e in found]):.3g}" for name in found[0])
        print(f"{kind}, median errors: {', '.join(errors)}", flush=True)
    for name, each in held.items():
        print(f"{name}: {sum(each)} of {len(each)} intervals hold the truth")
    print(f"all: {np.mean(list(held.values())):.1%}")


if __name__ == "__main__":
    main()
