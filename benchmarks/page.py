"""docs/performance.md from docs/performance.json: `python benchmarks/page.py` writes it again.

Every figure of the page is one of the JSON's. Words are the docstrings of the benchmarks and of
their rows; nothing that is measured needs to be installed.
"""

import ast
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from spread import Spread, number, text
from targets import TARGETS, Figures

HERE = Path(__file__).resolve().parent
DOCS = HERE.parent / "docs"
HEADINGS = {
    "flight_core": "Flight core and floor",
    "same_flight": "The same flight elsewhere",
    "sweep": "Sweeps",
    "agreement": "Agreement of compiled flights with the diagram",
    "fast_flights": "Fast flights and batches",
    "gain_map": "The map of gains",
    "design": "Design tools",
    "lidar": "Lidar",
    "live_sensors": "Sensors",
    "live_flight": "Live flight beside a screen",
    "analyst": "Margins while a slider moves",
    "link_age": "Watchers of a live flight",
    "link_flood": "A pilot beside ten greedy viewers",
    "link_hold": "From the last command to the hold",
    "log": "Logs",
    "app": "The app",
    "charts": "Charts",
    "executor": "Flights on more machines",
    "commands": "Commands",
    "start_up": "Start-up",
    "memory": "Memory",
    "growth": "Growth",
}
INTRODUCTION = """\
# Performance

Written by `make bench`, each table in one run: {machine}.
With {versions}.

Compare ratios: they are measured in alternating turns of one run, while absolute figures depend on
the machine and the day. A figure is a median with its quartiles, or with minimum and maximum if
there are fewer than four turns. `performance.json` has the same figures.

![Flights a second](performance.png)
"""


def page(results: Figures) -> str:
    """Return the page.

    Args:
        results: what performance.json holds: machine, versions, rows by benchmark, and machine and
            versions of benchmarks that were measured separately.
    """
    benchmarks, apart = results["benchmarks"], results.get("apart", {})
    versions = _versions(results)
    parts = [INTRODUCTION.format(machine=results["machine"], versions=versions)]
    parts.append(f"## Requirements\n{_targets(benchmarks)}")
    for name, heading in HEADINGS.items():
        if name in benchmarks:
            source = (HERE / f"{name}.py").read_text(encoding="utf-8")
            words = ast.get_docstring(ast.parse(source)) or ""
            tables = "\n".join(_tables(benchmarks[name], source))
            if name in apart:
                where = apart[name]
                words += f"\n\nMeasured separately: {where['machine']}, load {where['load']:.0f}."
                words += f"\nWith {_versions(where)}."
            parts.append(f"## {heading}\n{words}\n\n{tables}")
    return "\n".join(parts)


def _versions(measured: Figures) -> str:
    return ", ".join(f"{name} {found}" for name, found in measured["versions"].items())


def _targets(figures: Figures) -> str:
    rows = []
    for target in TARGETS:
        asked = f"{'at least' if target.at_least else 'at most'} {target.limit:g}"
        try:
            holds = "yes" if target.holds(figures) else "**no**"
            rows.append([target.what, asked, _cell(target.measured(figures)), holds])
        except LookupError:
            rows.append([target.what, asked, "not measured", "–"])
    return _table(["quantity", "required", "measured", "met"], rows)


def _tables(rows: Any, source: str) -> Iterator[str]:
    """Give the tables of a benchmark: of its rows, or of each of its parts."""
    if isinstance(rows, dict):
        lists = {name: each for name, each in rows.items() if _is_rows(each)}
        single = {name: each for name, each in rows.items() if name not in lists}
        for each in lists.values():
            yield from _tables(each, source)
        nested = {name: each for name, each in single.items() if _is_record(each)}
        for each in nested.values():
            yield from _tables([each], source)
        plain = {name: each for name, each in single.items() if name not in nested}
        if plain:
            yield from _tables([plain], source)
        return
    full = [each for each in rows if "reason" not in each]
    if full:
        columns = list(full[0])
        cells = [[_cell(each[name]) for name in columns] for each in full]
        yield _table([name.replace("_", " ") for name in columns], cells)
        yield from _legend(columns, source)
    for each in rows:
        if "reason" in each:
            name, reason = each.values()
            yield f"{name}: {reason}.\n"


def _is_rows(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(each, dict) for each in value)


def _is_record(value: Any) -> bool:
    return isinstance(value, dict) and "median" not in value


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


def _legend(columns: list[str], source: str) -> Iterator[str]:
    """Give what the row's docstring says about the columns, a line each."""
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.ClassDef):
            continue
        fields = [each.target.id for each in node.body if _is_field(each)]  # type: ignore[attr-defined]
        _, _, attributes = (ast.get_docstring(node) or "").partition("Attributes:\n")
        if fields == columns and attributes:
            said = re.sub(r"\n {8,}", " ", attributes.rstrip())
            for line in said.splitlines():
                name, _, words = line.strip().partition(": ")
                yield f"- {name.replace('_', ' ')}: {words}"
            yield ""


def _is_field(node: ast.stmt) -> bool:
    return isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)


def write(results: Figures) -> None:
    """Write page and picture beside each other."""
    from picture import save_picture

    (DOCS / "performance.md").write_text(page(results), encoding="utf-8")
    save_picture(results["benchmarks"], DOCS / "performance.png")


if __name__ == "__main__":
    write(json.loads((DOCS / "performance.json").read_text(encoding="utf-8")))
