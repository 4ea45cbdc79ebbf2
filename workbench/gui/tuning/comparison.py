"""The numbers of several designs side by side, as rows of a table, as text and as CSV."""

import csv
import io
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from workbench.analysis.replies import JudgedLoop
from workbench.control.loop import loop_label
from workbench.design.metrics import find_metric
from workbench.gui.tuning.designs import Design
from workbench.gui.tuning.limits import MARGIN_LIMITS, STEP_LIMITS, NumberLimit
from workbench.gui.tuning.margins_card import LimitLookup, short_label, weakest_loop
from workbench.gui.tuning.number_row import Cell, NumberRow
from workbench.gui.tuning.number_table import BEST_CELL

UNKNOWN_LOOP_TEXT = "–"
WEAKEST_LOOP_ROW = "weakest"


@dataclass(frozen=True)
class ComparedNumber:
    """A row of the table: one number for each design.

    Attributes:
        name: name as on the command line, as overshoot or pitch.phase_margin.
        label: name on the screen.
        limit: its format and its limit.
        values: values of the designs in SI; NaN if a design has none.
        help: explanation of each value.
    """

    name: str
    label: str
    limit: NumberLimit
    values: tuple[float, ...]
    help: tuple[str, ...]

    @property
    def best(self) -> int | None:
        """Index of the best value; None with fewer than two values, or if two look alike."""
        shown = [self.limit.shown(value) for value in self.values]
        known = [value for value in shown if not math.isnan(value)]
        if len(known) < 2:
            return None
        best = max(known) if self.limit.at_least else min(known)
        alike = [self.limit.digits(value) == self.limit.digits(best) for value in shown]
        return alike.index(True) if alike.count(True) == 1 else None

    def row(self, most: float) -> NumberRow:
        """Return it as a row of a table; `most` is its limit as shown."""
        cells = []
        for place, (value, help) in enumerate(zip(self.values, self.help, strict=True)):
            over = not math.isnan(value) and not self.limit.keeps(value, most)
            marked = BEST_CELL if place == self.best else ""
            cells.append(Cell(self.limit.number_text(value), over=over, help=help, marked=marked))
        return NumberRow(self.label, tuple(cells))


def compared_rows(
    designs: Sequence[Design], loop: str, limit_of: LimitLookup
) -> tuple[ComparedNumber, ...]:
    """Return the numbers of designs: of the step, of each one's weakest loop, and of one loop.

    Args:
        designs: one column each.
        loop: name of the selected loop.
        limit_of: returns a limit by name, as shown; these determine the weakest loop.
    """
    weakest = [
        weakest_loop(each.judged, limit_of) if each.judged is not None else None for each in designs
    ]
    chosen = [each.loop(loop) for each in designs]
    return (
        *(_step_numbers(limit, designs) for limit in STEP_LIMITS),
        *(_loop_numbers(WEAKEST_LOOP_ROW, limit, designs, weakest) for limit in MARGIN_LIMITS),
        *(_loop_numbers(loop, limit, designs, chosen) for limit in MARGIN_LIMITS),
    )


def table_rows(
    designs: Sequence[Design], loop: str, limit_of: LimitLookup
) -> tuple[NumberRow, ...]:
    """Return the rows of the table, with a line that names the loop above its margins.

    Args: as for `compared_rows`.
    """
    compared = compared_rows(designs, loop, limit_of)
    rows = [each.row(limit_of(each.limit.name)) for each in compared]
    cells = []
    for each in designs:
        weakest = weakest_loop(each.judged, limit_of) if each.judged is not None else None
        name = short_label(weakest.name) if weakest is not None else UNKNOWN_LOOP_TEXT
        help = f"{each.name}: {_unknown_reason(each) or 'the loop that is nearest to its limits'}"
        if each.judged is not None and not each.judged.stable:
            name, help = "unstable", f"{each.name}: {each.judged.said}"
        cells.append(Cell(name, over=name == "unstable", help=help))
    first, second = len(STEP_LIMITS), len(STEP_LIMITS) + len(MARGIN_LIMITS)
    rows.insert(
        second, NumberRow(f"Loop {loop_label(loop)}", (Cell(""),) * len(designs), strong=True)
    )
    rows.insert(first, NumberRow("Weakest loop", tuple(cells), strong=True))
    return tuple(rows)


def best_text(compared: Sequence[ComparedNumber], designs: Sequence[Design]) -> str:
    """Return which design is best in most rows, as a sentence."""
    best = Counter(designs[row.best].name for row in compared if row.best is not None)
    if not best:
        return "None is better than another." if len(designs) > 1 else ""
    said = ", ".join(f"{name} in {count}" for name, count in best.most_common())
    return f"{BEST_CELL.capitalize()}: {said} of {len(compared)} rows."


def compared_loops(designs: Sequence[Design], limit_of: LimitLookup) -> tuple[list[str], str]:
    """Return the names of the known loops of designs, and the weakest of the first of them."""
    names: dict[str, None] = {}
    weakest = ""
    for each in designs:
        if each.judged is not None:
            names |= dict.fromkeys(loop.name for loop in each.judged.loops)
            loop = weakest_loop(each.judged, limit_of)
            weakest = weakest or (loop.name if loop is not None else "")
    return [*names], weakest


def csv_text(compared: Sequence[ComparedNumber], designs: Sequence[Design]) -> str:
    """Return the numbers as CSV in SI: one per line, with names and units of the command line."""
    text = io.StringIO()
    write = csv.writer(text, lineterminator="\n").writerow  # quotes names with commas
    write(["metric", "unit", *(each.name for each in designs)])
    for row in compared:
        values = ["" if math.isnan(value) else f"{value:.9g}" for value in row.values]
        write([row.name, find_metric(row.limit.name).unit, *values])
    return text.getvalue()


def comparison_text(rows: Sequence[NumberRow], designs: Sequence[Design]) -> str:
    """Return the table as shown, in columns; a star marks the best value of a row."""
    lines = [["", *(f"{each.name} " for each in designs)]]
    for row in rows:
        lines.append([row.label, *(c.text + ("*" if c.marked else " ") for c in row.cells)])
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    text = ""
    for name, *numbers in lines:
        padded = [each.rjust(width) for each, width in zip(numbers, widths[1:], strict=True)]
        text += "  ".join([name.ljust(widths[0]), *padded]).rstrip() + "\n"
    return text


def _step_numbers(limit: NumberLimit, designs: Sequence[Design]) -> ComparedNumber:
    values, help = [], []
    for each in designs:
        numbers = each.predicted.numbers if each.predicted is not None else None
        lost = each.predicted is not None and each.predicted.lost
        value = limit.of(numbers) if numbers is not None and not lost else math.nan
        why = f"{limit.label}, {limit.help}"
        if math.isnan(value):
            withheld = numbers.withheld if numbers is not None else _unknown_reason(each)
            why = "the drone crashes" if lost else withheld or why
        values.append(value)
        help.append(f"{each.name}: {why}")
    return ComparedNumber(limit.name, _limit_label(limit), limit, tuple(values), tuple(help))


def _loop_numbers(
    name: str, limit: NumberLimit, designs: Sequence[Design], loops: Sequence[JudgedLoop | None]
) -> ComparedNumber:
    values, help = [], []
    for each, loop in zip(designs, loops, strict=True):
        value = limit.of(loop) if loop is not None and loop.stable else math.nan
        if loop is None:
            why = _unknown_reason(each) or f"it has no loop {loop_label(name)}"
        elif loop.stable:
            why = f"{loop_label(loop.name)}: {limit.label.lower()}, {limit.help}"
        else:
            why = each.judged.said if each.judged is not None else ""
        values.append(value)
        help.append(f"{each.name}: {why}")
    label = f"   {limit.short} {limit.unit}".rstrip()
    return ComparedNumber(f"{name}.{limit.name}", label, limit, tuple(values), tuple(help))


def _limit_label(limit: NumberLimit) -> str:
    return f"{limit.label} {limit.unit}"


def _unknown_reason(design: Design) -> str:
    """Return why nothing is known of a design, "" if it is known."""
    return design.said or ("not known yet" if design.judged is None else "")
