"""Requirements that docs/performance.json meets: `python benchmarks/page.py` prints their figures.

They would fill a second page. With `--write`, docs/performance.md, which lists those that are not
met, and its picture are written from the same file instead.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from spread import Spread, number, text
from targets import TARGETS, Figures

DOCS = Path(__file__).resolve().parent.parent / "docs"
INTRODUCTION = """\
# Performance

How fast the workbench flies, sweeps, serves and draws, against requirements of our own and beside
other simulators. [performance.json](performance.json) has all figures. A dagger (†) marks figures
of versions before Drake's plant flew; batches then had another engine. Compare ratios: they are
measured in alternating turns of one run, absolute figures depend on the machine. A figure is a
median with its quartiles, or with minimum and maximum of fewer than four turns. `make bench`
measures again.

![Flights a second](performance.png)

## Requirements that are not met

{missed}
The other {met} are met; `python benchmarks/page.py` prints them with their figures.
{notes}
## Where it was measured
{places}

performance.json has the versions of all packages.
"""
NOTES = """
## What limits
- **A live flight** is a Drake diagram. Rotors, sensors and laws are systems in Python, some 20 µs
  an evaluation. Thousands of flights are compiled: sweeps, `tune` and batches.
- **Compiled flights**: of 1,024 steps of 5 s (perf) the control law takes 36 %, the motion's
  derivatives 28 %, sums and copies of Runge-Kutta 19 %, events 17 %. Motion and sums are vectors of
  eight vehicles; the law is scalar code, 95 ns an update. A fifth more is Python.
- **crazyflow** has no contact, battery or estimator. It compiles the whole flight into one call,
  and XLA moves all drones in the widest vectors. Where that is enough, use it.
- **Commands** load Drake's plant first. Those that fly many flights load machine code, for 0.3 s; a
  first sweep compiles it for 12 s.
"""


THIS_VERSION = {"live_diagram", "sweep", "commands"}
"""Benchmarks that were measured for this version."""


class _ReadFigures(dict[str, Any]):
    """Figures that remember which benchmarks were read."""

    def __init__(self, figures: Figures) -> None:
        super().__init__(figures)
        self.read: set[str] = set()

    def __getitem__(self, name: str) -> Any:
        self.read.add(name)
        return super().__getitem__(name)


def page(results: Figures) -> str:
    """Return the page.

    Args:
        results: what performance.json holds: machine, versions, rows by benchmark, and machine and
            versions of benchmarks that were measured separately.
    """
    places = {_place(results): ["the others"]}
    for name, where in results.get("apart", {}).items():
        places.setdefault(_place(where), []).append(name)
    lines = [f"- {', '.join(names)}: {place}" for place, names in places.items()]
    missed, met = _targets(results["benchmarks"])
    return INTRODUCTION.format(missed=missed, met=len(met), notes=NOTES, places="\n".join(lines))


def met_requirements(results: Figures) -> str:
    """Return a list of the requirements that are met, with their figures."""
    return "".join(_targets(results["benchmarks"])[1])


def _place(measured: Figures) -> str:
    return f"{measured['machine']}, drake {measured['versions'].get('drake', 'not installed')}"


def _targets(figures: Figures) -> tuple[str, list[str]]:
    """Return a table of what is not met, or was not measured, and lines of what is met."""
    missed, met = [], []
    for target in TARGETS:
        asked = f"{'at least' if target.at_least else 'at most'} {target.limit:g}"
        seen = _ReadFigures(figures)
        try:
            figure = target.measured(seen)
            mark = "" if seen.read <= THIS_VERSION else " †"
            if target.holds(figures):
                median = figure["median"] if isinstance(figure, dict) else figure
                met.append(f"- {target.what}: {_cell(median)}{mark}\n")
            else:
                missed.append([target.what, asked, _cell(figure) + mark])
        except LookupError:
            missed.append([target.what, asked, "not measured"])
    return _table(["quantity", "required", "measured"], missed), met


def _table(columns: list[str], rows: list[list[str]]) -> str:
    lines = [columns, ["---"] * len(columns), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _cell(value: Any) -> str:
    if isinstance(value, dict):
        return text(Spread(**value))
    if isinstance(value, bool | str):
        return str(value)
    if isinstance(value, int):
        return f"{value:,}"
    return number(value)


def write(results: Figures) -> None:
    """Write page and picture beside each other."""
    from picture import save_picture

    (DOCS / "performance.md").write_text(page(results), encoding="utf-8")
    save_picture(results["benchmarks"], DOCS / "performance.png")


def main(words: Sequence[str] | None = None) -> None:
    """Print what is met, or write the page."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--write", action="store_true", help="write docs/performance.md and .png")
    arguments = parser.parse_args(words)
    results = json.loads((DOCS / "performance.json").read_text(encoding="utf-8"))
    if arguments.write:
        write(results)
        print(f"written to {DOCS / 'performance.md'}", file=sys.stderr)
    else:
        print(met_requirements(results), end="")


if __name__ == "__main__":
    main()
