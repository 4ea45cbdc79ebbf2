"""The card of margins: every loop, while a slider moves."""

from PyQt6.QtWidgets import QWidget

from workbench.analysis.replies import Judged
from workbench.gui.tuning.card import Card
from workbench.gui.tuning.judgement import Judgement
from workbench.gui.tuning.limit_table import MARGIN_LIMITS
from workbench.gui.tuning.limits import Limits
from workbench.gui.tuning.limits_form import LimitsForm
from workbench.gui.tuning.margin_rows import margin_rows, margins_headline, plant_input_row
from workbench.gui.tuning.number_table import NumberTable
from workbench.gui.workspace import Workspace

ROWS = 10
"""That are expected before they are known: loops, and the plant's input."""


class MarginsCard(Card):
    """Margins of the gains that are proposed, beside those of the gains that fly.

    Args:
        workspace: colours.
        judgement: what is known of both.
        limits: that they should keep.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(
        self,
        workspace: Workspace,
        judgement: Judgement,
        limits: Limits,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__("Margins", parent)
        self._judgement = judgement
        self._limits = limits
        self.form = LimitsForm(MARGIN_LIMITS, limits, columns=3)
        self.head.addWidget(self.form.button)
        head = [f"{row.short} {row.unit}".strip() for row in MARGIN_LIMITS]
        self.table = NumberTable(
            "Margins of every loop", head, workspace.look, paired=True, widest="yaw rate"
        )
        self.table.expect(ROWS)
        self.body.addWidget(self.form)
        self.body.addWidget(self.table, 1)
        judgement.changed.connect(self._show)
        limits.changed.connect(lambda _: self._show())
        self._show()

    def _show(self) -> None:
        now, before = self._judgement.proposed, self._judgement.flown
        if now is None:
            self.said.say(self._judgement.said or "Not known yet: the analyst is asked.")
            self.table.set_rows(())
            return
        other = before if before is not None and before is not now else None
        at_input, input_before = self._judgement.proposed_input, self._judgement.flown_input
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

    def _tone(self, now: Judged) -> str:
        if not now.stable:
            return "bad"
        low = any(cell.over for row in self.table.rows for cell in row.cells)
        return "warning" if low else "muted"
