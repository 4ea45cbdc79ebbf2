"""The card of margins: every loop, while a slider moves."""

import math
from collections.abc import Callable

from PyQt6.QtCore import Qt, pyqtSignal

from workbench.analysis.replies import Judged, JudgedLoop
from workbench.gui.layout import fill, named, tool_button
from workbench.gui.tuning.card import Card
from workbench.gui.tuning.judgement import Judgement, Margins
from workbench.gui.tuning.limits import MARGIN_LIMITS, Limit, Limits, LimitsForm, find_limit
from workbench.gui.tuning.number_table import Cell, NumberTable, Row, State
from workbench.gui.workspace import Workspace

LimitOf = Callable[[str], float]
PLANT_INPUT = "plant input, all at once"
DISK = find_limit("disk_margin")
ROWS = 10
"""Number of rows to expect before they are known: loops, and the plant's input."""


def margin_rows(now: Judged, before: Judged | None, limit_of: LimitOf) -> tuple[Row, ...]:
    """Return a row for each loop.

    Args:
        now: results for the proposed gains, or else for the flown ones.
        before: results for the flown gains, None if these are the same.
        limit_of: returns a limit by name, as shown.
    """
    old = {loop.name: loop for loop in before.loops} if before is not None else {}
    weakest = weakest_loop(now, limit_of) if now.stable else None  # else all are alike
    return tuple(_row(loop, old.get(loop.name), weakest, limit_of) for loop in now.loops)


def plant_input_row(
    now: Margins | None, before: Margins | None, limit_of: LimitOf, said: str
) -> Row:
    """Return the row of simultaneous changes of force and moments, which has only a disk margin.

    Args:
        now: result for the proposed gains, None while unknown.
        before: result for the flown gains, None if these are the same, or unknown.
        limit_of: returns a limit by name, as shown.
        said: why it is unknown, "" if it is still expected.
    """
    words = "at the plant's input, force and moments all at once"
    none = (Cell("", help=words),) * (len(MARGIN_LIMITS) - 1)
    was = DISK.text(min(before)) if before is not None and min(before) > 0.0 else ""
    if now is None:
        state = State.NONE if said else State.WAITING
        return Row(
            PLANT_INPUT, (*none, Cell("–", was, help=f"{words}: {said or 'computing'}")), state
        )
    margin, (steering, holding) = min(now), now
    if not margin:
        return Row(PLANT_INPUT, (*none, Cell("–", help=f"{words}: unstable")))
    text = DISK.text(margin)
    over = not DISK.keeps(margin, limit_of(DISK.name))
    low = (2.0 - margin) / (2.0 + margin)
    gains = f"; gains within {low:.2f} .. {1.0 / low:.2f}" if low > 0.0 else ""
    help = (
        f"{words}: α {DISK.text(steering)} while the pilot steers, "
        f"{DISK.text(holding)} while the position is held{gains}"
    )
    cell = Cell(text, was if was != text else "", over, help)
    return Row(PLANT_INPUT, (*none, cell), State.LOW if over else State.GOOD)


def weakest_loop(judged: Judged, limit_of: LimitOf) -> JudgedLoop | None:
    """Return the loop with the least reserve: an unstable one, or the one closest to a limit."""
    if not judged.loops:
        return None
    return min(judged.loops, key=lambda loop: _spare(loop, limit_of))


def margins_headline(judged: Judged, at_input: Margins | None, limit_of: LimitOf) -> str:
    """Return a sentence about the stability with gains.

    It names the plant's input if only its margin is low.
    """
    loop = weakest_loop(judged, limit_of)
    if not judged.stable:
        said = judged.said or "the closed loop is unstable with these gains."
        return said[0].upper() + said[1:]
    low = [limit for limit in MARGIN_LIMITS if loop and not _keeps(loop, limit, limit_of)]
    margin = min(at_input) if at_input is not None else math.inf
    if not low and not DISK.keeps(margin, limit_of(DISK.name)):
        least = f"{DISK.sign} {limit_of(DISK.name):g}"
        return f"Weakest: {PLANT_INPUT}, {DISK.label.lower()} {DISK.text(margin)} ({least})"
    if loop is None:
        return "No loop is closed."
    name = loop_label(loop.name)
    limit = min(low or MARGIN_LIMITS, key=lambda each: _share(loop, each, limit_of))
    value = _with_unit(limit.text(getattr(loop, limit.name)), limit)
    said = f"Weakest: {name}, {limit.label.lower()} {value}"
    if low:
        return f"{said} ({limit.sign} {_with_unit(f'{limit_of(limit.name):g}', limit)})"
    return said


def _with_unit(text: str, limit: Limit) -> str:
    glue = "" if limit.unit in ("", "°") else " "
    return f"{text}{glue}{limit.unit}"


def loop_label(name: str) -> str:
    """Return a loop's name in words."""
    return name.replace("_", " ")


def short_label(name: str) -> str:
    """Return a loop's short name in words, for a row."""
    return loop_label(name).replace("velocity", "vel.").replace("position", "pos.")


def _row(loop: JudgedLoop, old: JudgedLoop | None, weakest: JudgedLoop | None, of: LimitOf) -> Row:
    cells = []
    for limit in MARGIN_LIMITS:
        value = getattr(loop, limit.name)
        text = limit.text(value) if loop.stable else "–"
        # An unstable loop has no numbers to compare.
        compared = old is not None and loop.stable
        was = limit.text(getattr(old, limit.name)) if compared else text
        was = was if was != text else ""  # compare only what changes
        over = loop.stable and not _keeps(loop, limit, of)
        cells.append(Cell(text, was, over, _help(loop, limit)))
    if not loop.stable:  # then no loop has a margin, but only some are the cause
        state = State.BROKEN if loop.growing else State.NONE
    else:
        state = State.LOW if any(cell.over for cell in cells) else State.GOOD
    return Row(short_label(loop.name), tuple(cells), state, loop is weakest)


def _keeps(loop: JudgedLoop, limit: Limit, limit_of: LimitOf) -> bool:
    return limit.keeps(getattr(loop, limit.name), limit_of(limit.name))


def _share(loop: JudgedLoop, limit: Limit, limit_of: LimitOf) -> float:
    """Return a margin as a share of its limit."""
    wanted, value = limit_of(limit.name), limit.shown(getattr(loop, limit.name))
    if math.isnan(value):
        return -math.inf
    return value / wanted if wanted else math.inf


def _spare(loop: JudgedLoop, limit_of: LimitOf) -> float:
    if not loop.stable:
        return -math.inf
    return min(_share(loop, limit, limit_of) for limit in MARGIN_LIMITS)


def _help(loop: JudgedLoop, limit: Limit) -> str:
    value = getattr(loop, limit.name)
    text = f"{loop_label(loop.name)}: {limit.label.lower()}, {limit.help}"
    if limit.unit == "dB" and math.isfinite(value):
        return f"{text}: factor {value:.3g}"
    if limit.name == "phase_margin" and math.isfinite(loop.crossover):
        return f"{text}, at {loop.crossover:.3g} rad/s"
    return text


class MarginsCard(Card):
    """Margins with the proposed gains, beside those with the flown gains.

    Args:
        workspace: source of colours.
        judgement: known results for both.
        limits: limits of the margins.
        title: title of the card.
    """

    loop_chosen = pyqtSignal(str)
    """Name of the loop whose row was selected."""

    def __init__(
        self, workspace: Workspace, judgement: Judgement, limits: Limits, title: str = "Margins"
    ) -> None:
        super().__init__(title)
        self._judgement = judgement
        self._limits = limits
        self.form = LimitsForm(MARGIN_LIMITS, limits, columns=3)
        help = "Fold the table, to leave its room to what is below"
        self.fold = named(tool_button("", kind="quiet small"), "Fold the table of margins", help)
        self.fold.setCheckable(True)
        self.fold.setArrowType(Qt.ArrowType.DownArrow)
        self.fold.toggled.connect(self._fold)
        fill(self.head, self.form.button, self.fold)
        head = [f"{row.short} {row.unit}".strip() for row in MARGIN_LIMITS]
        self.table = NumberTable(
            "Margins of every loop", head, workspace.look, paired=True, widest="yaw rate"
        )
        self.table.expect(ROWS)
        self.table.row_chosen.connect(self._choose)
        fill(self.body, self.form, (self.table, 1))
        judgement.changed.connect(self._show)
        limits.changed.connect(lambda _: self._show())
        self._show()

    def _show(self) -> None:
        now, before = self._judgement.proposed, self._judgement.flown
        if now is None:
            self.said.say(self._judgement.said or "Not known yet: the analyst is computing it.")
            self.table.set_rows(())
            return
        other = before if before is not None and before is not now else None
        at_input, input_before = self._judgement.inputs
        if input_before is at_input:
            input_before = None
        last = plant_input_row(
            at_input, input_before, self._limits.value, self._judgement.input_said
        )
        self.table.expect(len(now.loops) + 1)
        self.table.set_rows((*margin_rows(now, other, self._limits.value), last))
        if caveat := self._judgement.caveat:
            self.said.say(caveat, "warning")
        else:
            self.said.say(margins_headline(now, at_input, self._limits.value), self._tone(now))

    def _fold(self, folded: bool) -> None:
        """Show only the sentence, or everything."""
        arrow = Qt.ArrowType.RightArrow if folded else Qt.ArrowType.DownArrow
        self.fold.setArrowType(arrow)
        self.table.setVisible(not folded)

    def _choose(self, row: int) -> None:
        now = self._judgement.proposed
        if now is not None and row < len(now.loops):  # the last row is the plant's input
            self.loop_chosen.emit(now.loops[row].name)

    def _tone(self, now: Judged) -> str:
        if not now.stable:
            return "bad"
        low = any(cell.over for row in self.table.rows for cell in row.cells)
        return "warning" if low else "muted"
