"""The table of designs: numbers of the step and margins, the best of each row marked."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from workbench.analysis.replies import Judged, JudgedLoop, Predicted
from workbench.design.metrics import find_metric
from workbench.gui.tuning.limit_table import MARGIN_LIMITS, STEP_LIMITS, Limit
from workbench.gui.tuning.margins_card import LimitOf, loop_label, short_label, weakest_loop
from workbench.gui.tuning.table_rows import BEST, Cell, Row

DASH = "–"
WEAKEST = "weakest"


@dataclass(frozen=True)
class Known:
    """What is known of a design.

    Attributes:
        name: of the design.
        predicted: its step, None where it is not known, or there is none.
        judged: its margins, None where they are not known.
        said: why something is not known, "" where it will be.
    """

    name: str
    predicted: Predicted | None = None
    judged: Judged | None = None
    said: str = ""

    def loop(self, name: str) -> JudgedLoop | None:
        """Return a loop of it, None where it has none of that name, or is not known."""
        loops = self.judged.loops if self.judged is not None else ()
        return next((loop for loop in loops if loop.name == name), None)


@dataclass(frozen=True)
class Compared:
    """A row of the table: a number of each design.

    Attributes:
        name: as on the command line, as overshoot or pitch.phase_margin.
        label: on the screen.
        limit: how it is shown, and what it should keep.
        values: of the designs in SI; NaN where one has none.
        help: about each value.
    """

    name: str
    label: str
    limit: Limit
    values: tuple[float, ...]
    help: tuple[str, ...]

    @property
    def best(self) -> int | None:
        """Place of the best value; None where there is no second one, or two are shown alike."""
        shown = [self.limit.shown(value) for value in self.values]
        known = [value for value in shown if not math.isnan(value)]
        if len(known) < 2:
            return None
        best = max(known) if self.limit.at_least else min(known)
        alike = [self.limit.digits(value) == self.limit.digits(best) for value in shown]
        return alike.index(True) if alike.count(True) == 1 else None

    def row(self, most: float) -> Row:
        """Return it as a row of a table; `most` is its limit as shown."""
        cells = []
        for place, (value, help) in enumerate(zip(self.values, self.help, strict=True)):
            over = not math.isnan(value) and not self.limit.keeps(value, most)
            marked = BEST if place == self.best else ""
            cells.append(Cell(self.limit.text(value), over=over, help=help, marked=marked))
        return Row(self.label, tuple(cells))


def compared_rows(designs: Sequence[Known], loop: str, limit_of: LimitOf) -> tuple[Compared, ...]:
    """Return the numbers of designs: of the step, of each one's weakest loop, and of one loop.

    Args:
        designs: a column each.
        loop: name of the loop that is looked at.
        limit_of: gives a limit by its name, as shown; by these the weakest loop is found.
    """
    weakest = [
        weakest_loop(each.judged, limit_of) if each.judged is not None else None for each in designs
    ]
    chosen = [each.loop(loop) for each in designs]
    return (
        *(_of_step(limit, designs) for limit in STEP_LIMITS),
        *(_of_loop(WEAKEST, limit, designs, weakest) for limit in MARGIN_LIMITS),
        *(_of_loop(loop, limit, designs, chosen) for limit in MARGIN_LIMITS),
    )


def table_rows(
    compared: Sequence[Compared], designs: Sequence[Known], loop: str, limit_of: LimitOf
) -> tuple[Row, ...]:
    """Return the rows of the table, with a line above the margins of the loops that says whose.

    Args:
        compared: as `compared_rows` gives them.
        designs: a column each.
        loop: name of the loop that is looked at.
        limit_of: gives a limit by its name, as shown.
    """
    rows = [each.row(limit_of(each.limit.name)) for each in compared]
    cells = []
    for each in designs:
        weakest = weakest_loop(each.judged, limit_of) if each.judged is not None else None
        name = short_label(weakest.name) if weakest is not None else DASH
        help = f"{each.name}: {_why(each) or 'the loop that has least to spare of its limits'}"
        if each.judged is not None and not each.judged.stable:
            name, help = "unstable", f"{each.name}: {each.judged.said}"
        cells.append(Cell(name, over=name == "unstable", help=help))
    first, second = len(STEP_LIMITS), len(STEP_LIMITS) + len(MARGIN_LIMITS)
    rows.insert(second, Row(f"Loop {loop_label(loop)}", (Cell(""),) * len(designs), strong=True))
    rows.insert(first, Row("Weakest loop", tuple(cells), strong=True))
    return tuple(rows)


def csv_text(compared: Sequence[Compared], designs: Sequence[Known]) -> str:
    """Return the numbers as CSV, in SI: a line each, named and in units as on the command line."""
    lines = [",".join(["metric", "unit", *(each.name for each in designs)])]
    for row in compared:
        unit = find_metric(row.limit.name).unit
        values = ["" if math.isnan(value) else f"{value:.9g}" for value in row.values]
        lines.append(",".join([row.name, unit, *values]))
    return "\n".join(lines) + "\n"


def plain_text(rows: Sequence[Row], designs: Sequence[Known]) -> str:
    """Return the table as it is shown, in columns; a star stands behind the best of a row."""
    lines = [["", *(f"{each.name} " for each in designs)]]
    for row in rows:
        lines.append([row.label, *(c.text + ("*" if c.marked else " ") for c in row.cells)])
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    text = ""
    for name, *numbers in lines:
        padded = [each.rjust(width) for each, width in zip(numbers, widths[1:], strict=True)]
        text += "  ".join([name.ljust(widths[0]), *padded]).rstrip() + "\n"
    return text


def _of_step(limit: Limit, designs: Sequence[Known]) -> Compared:
    values, help = [], []
    for each in designs:
        numbers = each.predicted.numbers if each.predicted is not None else None
        lost = each.predicted is not None and each.predicted.lost
        value = getattr(numbers, limit.name) if numbers is not None and not lost else math.nan
        why = f"{limit.label}, {limit.help}"
        if math.isnan(value):
            withheld = numbers.withheld if numbers is not None else _why(each)
            why = "the drone would be lost" if lost else withheld or why
        values.append(value)
        help.append(f"{each.name}: {why}")
    return Compared(limit.name, _label(limit), limit, tuple(values), tuple(help))


def _of_loop(
    name: str, limit: Limit, designs: Sequence[Known], loops: Sequence[JudgedLoop | None]
) -> Compared:
    values, help = [], []
    for each, loop in zip(designs, loops, strict=True):
        value = getattr(loop, limit.name) if loop is not None and loop.stable else math.nan
        if loop is None:
            why = _why(each) or f"it has no loop {loop_label(name)}"
        elif loop.stable:
            why = f"{loop_label(loop.name)}: {limit.label.lower()}, {limit.help}"
        else:
            why = each.judged.said if each.judged is not None else ""
        values.append(value)
        help.append(f"{each.name}: {why}")
    label = f"   {limit.short} {limit.unit}".rstrip()
    return Compared(f"{name}.{limit.name}", label, limit, tuple(values), tuple(help))


def _label(limit: Limit) -> str:
    return f"{limit.label} {limit.unit}"


def _why(design: Known) -> str:
    """Return why nothing is known of a design, "" where it is."""
    return design.said or ("not known yet" if design.judged is None else "")
