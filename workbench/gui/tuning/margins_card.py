"""The card of margins: every loop, while a slider moves."""

import math
from collections.abc import Callable

from PyQt6.QtCore import Qt, pyqtSignal

from workbench.analysis.replies import Judged, JudgedLoop
from workbench.control.loop import loop_label
from workbench.gui.labels import set_tip
from workbench.gui.layout import fill, named, tool_button
from workbench.gui.tuning.card import TuningCard
from workbench.gui.tuning.excitation_form import loop_excitation
from workbench.gui.tuning.judgement import InputMargins, StabilityFollower, with_caveat
from workbench.gui.tuning.limits import (
    MARGIN_LIMITS,
    LimitsForm,
    LimitValues,
    NumberLimit,
    find_limit,
)
from workbench.gui.tuning.number_row import Cell, NumberRow, RowState
from workbench.gui.tuning.number_table import NumberTable
from workbench.gui.units import frequency_text
from workbench.gui.workspace import Workspace

LimitLookup = Callable[[str], float]
PLANT_INPUT_ROW = "plant input, all at once"
EXCITE_HELP = "Choose a step of the setpoint of the weakest loop"
INPUT_DISK_LIMIT = find_limit("disk_margin")
FOLD_TEXTS = "Fold the table of margins", "Fold the table, to leave its room to what is below"
UNFOLD_TEXTS = "Open the table of margins", "Show the margins of every loop"
EXPECTED_MARGIN_ROWS = 10
"""Number of rows to expect before they are known: loops, and the plant's input."""


def margin_rows(now: Judged, before: Judged | None, limit_of: LimitLookup) -> tuple[NumberRow, ...]:
    """Return a row for each loop.

    Args:
        now: results for the proposed gains, or else for the flown ones.
        before: results for the flown gains, None if these are the same.
        limit_of: returns a limit by name, as shown.
    """
    old = {loop.name: loop for loop in before.loops} if before is not None else {}
    weakest = weakest_loop(now, limit_of) if now.stable else None  # else all are alike
    return tuple(_margin_row(loop, old.get(loop.name), weakest, limit_of) for loop in now.loops)


def plant_input_row(
    now: InputMargins | None, before: InputMargins | None, limit_of: LimitLookup, said: str
) -> NumberRow:
    """Return the row of simultaneous changes of force and moments, which has only a disk margin.

    Args:
        now: result for the proposed gains, None while unknown.
        before: result for the flown gains, None if these are the same, or unknown.
        limit_of: returns a limit by name, as shown.
        said: why it is unknown, "" if it is still expected.
    """
    words = "at the plant's input, force and moments all at once"
    none = (Cell("", help=words),) * (len(MARGIN_LIMITS) - 1)
    was = (
        INPUT_DISK_LIMIT.number_text(min(before))
        if before is not None and min(before) > 0.0
        else ""
    )
    if now is None:
        state = RowState.NONE if said else RowState.WAITING
        return NumberRow(
            PLANT_INPUT_ROW, (*none, Cell("–", was, help=f"{words}: {said or 'computing'}")), state
        )
    margin, (steering, holding) = min(now), now
    if not margin:
        return NumberRow(PLANT_INPUT_ROW, (*none, Cell("–", help=f"{words}: unstable")))
    text = INPUT_DISK_LIMIT.number_text(margin)
    over = not INPUT_DISK_LIMIT.keeps(margin, limit_of(INPUT_DISK_LIMIT.name))
    low = (2.0 - margin) / (2.0 + margin)
    gains = f"; gains within {low:.2f} .. {1.0 / low:.2f}" if low > 0.0 else ""
    help = (
        f"{words}: α {INPUT_DISK_LIMIT.number_text(steering)} while the pilot steers, "
        f"{INPUT_DISK_LIMIT.number_text(holding)} while the position is held{gains}"
    )
    cell = Cell(text, was if was != text else "", over, help)
    return NumberRow(PLANT_INPUT_ROW, (*none, cell), RowState.LOW if over else RowState.GOOD)


def weakest_loop(judged: Judged, limit_of: LimitLookup) -> JudgedLoop | None:
    """Return the loop with the least reserve: an unstable one, or the one closest to a limit."""
    if not judged.loops:
        return None
    return min(judged.loops, key=lambda loop: _loop_reserve(loop, limit_of))


def margins_headline(judged: Judged, at_input: InputMargins | None, limit_of: LimitLookup) -> str:
    """Return a sentence about the stability with gains.

    It names the plant's input if only its margin is low.
    """
    loop = weakest_loop(judged, limit_of)
    if not judged.stable:
        said = judged.said or "the closed loop is unstable with these gains."
        return said[0].upper() + said[1:]
    low = [limit for limit in MARGIN_LIMITS if loop and not _keeps_limit(loop, limit, limit_of)]
    margin = min(at_input) if at_input is not None else math.inf
    if not low and not INPUT_DISK_LIMIT.keeps(margin, limit_of(INPUT_DISK_LIMIT.name)):
        least = INPUT_DISK_LIMIT.relation(limit_of(INPUT_DISK_LIMIT.name))
        return (
            f"Weakest: {PLANT_INPUT_ROW}, {INPUT_DISK_LIMIT.label.lower()} "
            f"{INPUT_DISK_LIMIT.number_text(margin)} ({least})"
        )
    if loop is None:
        return "No loop is closed."
    name = loop_label(loop.name)
    limit = min(low or MARGIN_LIMITS, key=lambda each: _limit_share(loop, each, limit_of))
    value = limit.text(getattr(loop, limit.name))
    said = f"Weakest: {name}, {limit.label.lower()} {value}"
    if low:
        return f"{said} ({limit.relation(limit_of(limit.name))})"
    return said


def short_label(name: str) -> str:
    """Return a loop's short name in words, for a row."""
    return loop_label(name).replace("velocity", "vel.").replace("position", "pos.")


def _margin_row(
    loop: JudgedLoop, old: JudgedLoop | None, weakest: JudgedLoop | None, of: LimitLookup
) -> NumberRow:
    cells = []
    for limit in MARGIN_LIMITS:
        value = getattr(loop, limit.name)
        text = limit.number_text(value) if loop.stable else "–"
        # An unstable loop has no numbers to compare.
        compared = old is not None and loop.stable
        was = limit.number_text(getattr(old, limit.name)) if compared else text
        was = was if was != text else ""  # compare only what changes
        over = loop.stable and not _keeps_limit(loop, limit, of)
        cells.append(Cell(text, was, over, _margin_help(loop, limit)))
    if not loop.stable:  # then no loop has a margin, but only some are the cause
        state = RowState.BROKEN if loop.growing else RowState.NONE
    else:
        state = RowState.LOW if any(cell.over for cell in cells) else RowState.GOOD
    return NumberRow(short_label(loop.name), tuple(cells), state, loop is weakest)


def _keeps_limit(loop: JudgedLoop, limit: NumberLimit, limit_of: LimitLookup) -> bool:
    return limit.keeps(getattr(loop, limit.name), limit_of(limit.name))


def _limit_share(loop: JudgedLoop, limit: NumberLimit, limit_of: LimitLookup) -> float:
    """Return a margin as a share of its limit."""
    wanted, value = limit_of(limit.name), limit.shown(getattr(loop, limit.name))
    if math.isnan(value):
        return -math.inf
    return value / wanted if wanted else math.inf


def _loop_reserve(loop: JudgedLoop, limit_of: LimitLookup) -> float:
    if not loop.stable:
        return -math.inf
    return min(_limit_share(loop, limit, limit_of) for limit in MARGIN_LIMITS)


def _margin_help(loop: JudgedLoop, limit: NumberLimit) -> str:
    value = getattr(loop, limit.name)
    text = f"{loop_label(loop.name)}: {limit.label.lower()}, {limit.help}"
    if limit.unit == "dB" and math.isfinite(value):
        return f"{text}: factor {value:.3g}"
    if limit.name == "phase_margin" and math.isfinite(loop.crossover):
        return f"{text}, at {frequency_text(loop.crossover)}"
    return text


class MarginsCard(TuningCard):
    """Margins with the proposed gains, beside those with the flown gains.

    Args:
        workspace: source of colours.
        judgement: known results for both.
        limits: limits of the margins.
        title: title of the card.
    """

    loop_chosen = pyqtSignal(str)
    """Name of the loop whose row was selected."""
    excitation_wanted = pyqtSignal(str)
    """Name of the weakest loop, whose setpoint shall be excited."""

    def __init__(
        self,
        workspace: Workspace,
        judgement: StabilityFollower,
        limits: LimitValues,
        title: str = "Margins",
    ) -> None:
        super().__init__(title)
        self._judgement = judgement
        self._limits = limits
        self.form = LimitsForm(MARGIN_LIMITS, limits, columns=3)
        self.fold = tool_button("", lambda: self.set_folded(not self.is_folded), "quiet small")
        self.excite = tool_button("Excite", self._excite, "quiet compact", EXCITE_HELP)
        self.excite.setAccessibleName(EXCITE_HELP)
        self._is_excited = False
        fill(self.head, self.excite, self.form.button, self.fold)
        head = [f"{row.short} {row.unit}".strip() for row in MARGIN_LIMITS]
        self.table = NumberTable(
            "Margins of every loop", head, workspace.look, paired=True, widest="yaw rate"
        )
        self.table.expect(EXPECTED_MARGIN_ROWS)
        self.table.row_chosen.connect(self._choose)
        fill(self.body, self.form, (self.table, 1))
        judgement.changed.connect(self._show)
        limits.changed.connect(lambda _: self._show())
        self._was_folded = False
        self.set_folded(False)
        self._show()

    @property
    def is_folded(self) -> bool:
        """Whether only the sentence is shown."""
        return self.table.isHidden()

    def set_folded(self, folded: bool) -> None:
        """Show only the sentence, or everything."""
        self.fold.setArrowType(Qt.ArrowType.RightArrow if folded else Qt.ArrowType.DownArrow)
        named(self.fold, *UNFOLD_TEXTS if folded else FOLD_TEXTS)
        self.table.setVisible(not folded)

    @property
    def rows(self) -> tuple[NumberRow, ...]:
        """Margins of the loops with the proposed gains; empty while unknown."""
        now = self._judgement.proposed
        return margin_rows(now, None, self._limits.value) if now is not None else ()

    def show_excited(self, excited: bool) -> None:
        """Show whether the flight is excited: then no other excitation is chosen."""
        if excited != self._is_excited:
            self._is_excited = excited
            self._show_excite()

    @property
    def _weakest(self) -> JudgedLoop | None:
        now = self._judgement.proposed
        return weakest_loop(now, self._limits.value) if now is not None else None

    def _excite(self) -> None:
        if (weakest := self._weakest) is not None:
            self.excitation_wanted.emit(weakest.name)

    def _show_excite(self) -> None:
        """Enable the button, or let its tool tip say why it is not."""
        weakest, why_not = self._weakest, ""
        if self._judgement.proposed is None:
            why_not = "The weakest loop is not known yet"
        elif weakest is None:
            why_not = "No loop is closed"
        elif loop_excitation(weakest.name) is None:
            why_not = (
                "No excitation steps the setpoint of the weakest loop, "
                f"{loop_label(weakest.name)}: choose another one in the card Excitation"
            )
        elif self._is_excited:
            why_not = "An excitation runs: stop it first"
        self.excite.setEnabled(not why_not)
        set_tip(self.excite, why_not or EXCITE_HELP)
        self.excite.setAccessibleDescription(why_not)

    def _show(self) -> None:
        now, before = self._judgement.proposed, self._judgement.flown
        self._show_excite()
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
        headline = margins_headline(now, at_input, self._limits.value)
        self.said.say(*with_caveat(self._judgement.caveat, headline, self._tone(now)))

    def set_filling(self, fills: bool) -> None:
        """Show the whole table while it fills its column."""
        super().set_filling(fills)
        if fills:
            self._was_folded = self.is_folded
        self.set_folded(self._was_folded and not fills)
        self.fold.setEnabled(not fills)

    def _choose(self, row: int) -> None:
        now = self._judgement.proposed
        if now is not None and row < len(now.loops):  # the last row is the plant's input
            self.loop_chosen.emit(now.loops[row].name)

    def _tone(self, now: Judged) -> str:
        if not now.stable:
            return "bad"
        low = any(cell.over for row in self.table.rows for cell in row.cells)
        return "warning" if low else "muted"
