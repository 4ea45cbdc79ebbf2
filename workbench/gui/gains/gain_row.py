"""The line of one parameter: name, slider, number, state, and reset."""

from functools import partial

from PyQt6.QtCore import QSize, Qt
from PyQt6.QtGui import (
    QResizeEvent,
)
from PyQt6.QtWidgets import QWidget

from workbench.common.parameter import Parameter
from workbench.gui.charts.ticks import decimals_for_step
from workbench.gui.gains.gain_editor import GainEditor, GainMark
from workbench.gui.gains.gain_input import GainField, GainSlider
from workbench.gui.gains.gain_rows import linked_gain
from workbench.gui.gains.gain_scale import GainScale
from workbench.gui.gains.step_key import FINEST_STEP_FACTOR
from workbench.gui.labels import WrappedName, set_tip
from workbench.gui.layout import NO_MARGINS, hbox, label, tool_button
from workbench.gui.style import set_class, with_class
from workbench.gui.units import gain_text, unit_for
from workbench.gui.workspace import Workspace

MAX_GAIN_DECIMALS = 3
GAIN_COLUMN_GAP_PX = 4
"""Space between columns [px]."""
GAIN_MARK_SHAPES = {GainMark.KEPT: "", GainMark.TRIED: "◆", GainMark.PROPOSED: "◇"}
OWN_NAME_WIDTHS_DIGITS = (11.6, 13.2)
"""Least and largest width of the parameter's own name, in widths of a digit; longer ones wrap."""
MIN_TRACK_WIDTH_PX = 150
"""Width of the slider below which names and units grow no wider, and own names are hidden [px]."""
NAME_WIDTH_DIGITS, FIELD_WIDTH_DIGITS, UNIT_WIDTH_DIGITS, MARK_WIDTH_DIGITS = 14.4, 7.4, 3.8, 1.6
"""Widths of the columns, in widths of a digit, so that all lines have the same."""
MIN_NAME_WIDTH_DIGITS = 11.0
"""Least width of a name beside a long unit: it wraps."""
MAX_NAME_WIDTH_DIGITS, MAX_UNIT_WIDTH_DIGITS = 22.0, 9.6
"""Largest widths of long names and units; longer names wrap."""


class GainRow(QWidget):
    """The line of a parameter.

    Args:
        workspace: colours and units.
        editor: sets the parameter.
        row: row of the parameter table.
        parent: the Qt parent.

    Attributes:
        row: row of the parameter table.
    """

    def __init__(
        self,
        workspace: Workspace,
        editor: GainEditor,
        row: Parameter,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self._workspace, self._editor, self.row = workspace, editor, row
        self._label = editor.label(row)
        self._unit = unit_for(row.unit, workspace.preferences)
        self._mark = GainMark.KEPT
        self._seen: tuple[float, float, float] | None = None
        self._stable: tuple[float, float] | None = None
        self._fresh = False
        self._wanted = 0, 0
        self.slider = GainSlider(GainScale(row, self._unit), workspace.look)
        self.field = GainField()
        self.mark = label()
        self.reset = tool_button("↺", self._reset, "quiet compact")
        self.reset.setFixedWidth(24)
        self._name = WrappedName()
        self.own_name = with_class(WrappedName(), "muted small")
        self._unit_shown = label(kind="muted")
        self._name.setBuddy(self.field)
        self._lay_out()
        for part in (self.slider, self.field):
            part.stepped.connect(self._step)
            part.edit_begun.connect(editor.begin_edit)
            part.edit_ended.connect(editor.end_edit)
        self.slider.dragged.connect(partial(editor.propose, row.name))
        self.field.edited.connect(self._type)
        self.field.refused.connect(partial(editor.refuse, row.name))
        self.show_unit()

    @property
    def tab_stops(self) -> tuple[QWidget, ...]:
        """What Tab goes to, in order."""
        return self.slider, self.field, self.reset

    @property
    def wanted_widths(self) -> tuple[int, int]:
        """Widths of the columns of name and unit that this line needs, within limits [px]."""
        advance = self.fontMetrics().horizontalAdvance
        digit = advance("0")
        bounds = (
            (NAME_WIDTH_DIGITS, MAX_NAME_WIDTH_DIGITS),
            (UNIT_WIDTH_DIGITS, MAX_UNIT_WIDTH_DIGITS),
        )
        texts = f"{self._label.words} {self._label.symbol}".strip(), self._unit_shown.text()
        name, unit = (
            min(max(advance(text) + 4, round(least * digit)), round(most * digit))
            for text, (least, most) in zip(texts, bounds, strict=True)
        )
        return name, unit

    def set_widths(self, name: int, unit: int) -> None:
        """Let the columns of name and unit grow to these widths if there is room [px]."""
        self._wanted = name, unit
        self._share_width()

    def _share_width(self) -> None:
        """Give the unit what it needs, and the names what the slider can spare."""
        digit = self.fontMetrics().horizontalAdvance("0")
        rest = (
            round((FIELD_WIDTH_DIGITS + MARK_WIDTH_DIGITS) * digit)
            + MIN_TRACK_WIDTH_PX
            + self.reset.width()
            + 5 * GAIN_COLUMN_GAP_PX
        )
        (name, unit), (wanted, wanted_unit) = self._least_widths(), self._wanted
        unit = max(unit, wanted_unit)
        spare = self.width() - name - unit - rest
        own_least, own_most = (round(each * digit) for each in OWN_NAME_WIDTHS_DIGITS)
        own = min(spare - GAIN_COLUMN_GAP_PX, own_most)
        known = self._label.words == self.row.name  # a firmware's
        self.own_name.setVisible(own >= own_least and not known)
        if not self.own_name.isHidden():
            self.own_name.setFixedWidth(own)
            spare -= own + GAIN_COLUMN_GAP_PX
        least = round(MIN_NAME_WIDTH_DIGITS * digit)
        self._name.setFixedWidth(min(max(name + spare, least), max(name, wanted)))
        self._unit_shown.setFixedWidth(unit)

    def matches(self, words: str) -> bool:
        """Return whether all words occur in its name, symbol, group or help."""
        label = self._label
        text = f"{self.row.name} {label.words} {label.symbol} {label.group} {self.row.help}".lower()
        return all(word in text for word in words.lower().split())

    def show_unit(self) -> None:
        """Show name and unit in the preferred units, and the value at the flight's start."""
        self._name.setText(f"{self._label.words} {self._label.symbol}".strip())
        self._unit = unit_for(self.row.unit, self._workspace.preferences)
        scale = self.slider.scale = GainScale(self.row, self._unit)
        start = self._editor.start[self.row.name]
        step = self._unit.shown(scale.step(start))
        fine = min(6, decimals_for_step(step * FINEST_STEP_FACTOR))
        self.field.show_decimals(0 if self.row.whole else min(fine, MAX_GAIN_DECIMALS))
        self._unit_shown.setText(self._unit.symbol)
        self.slider.show_start(start)
        self._say_names()
        self._seen = None
        self.show_value()

    def show_value(self) -> None:
        """Show the proposed and flown values, and their relation to the kept one."""
        name = self.row.name
        proposed, flown = self._editor.proposed[name], self._editor.flown[name]
        kept = self._editor.kept.get(name, self._editor.start[name])
        mark = self._editor.mark(name)
        seen = (proposed, flown, kept)
        if seen == self._seen and mark is self._mark:
            return  # to keep a text that is being typed here
        self._seen = seen
        self.slider.show_value(proposed, flown)
        if not self.is_refused:
            self.field.show_value(self._unit.shown(proposed))
        self._mark = mark
        self.mark.setText(GAIN_MARK_SHAPES[mark])
        said = f"{self._label.text}: {mark.value}; kept is {self._text(kept)}"
        self.mark.setAccessibleName(said)
        set_tip(self.mark, "" if mark is GainMark.KEPT else said)
        self.reset.setEnabled(proposed != self._editor.start[name])

    def show_range(self, stable: tuple[float, float] | None, fresh: bool) -> None:
        """Show the stable range of the loop.

        Args:
            stable: least and largest value, in SI; None if unknown.
            fresh: whether the range belongs to the gains that fly.
        """
        if (stable, fresh) == (self._stable, self._fresh):
            return
        self._stable, self._fresh = stable, fresh
        self.slider.show_stable(stable, fresh)
        self._say_names()

    @property
    def is_refused(self) -> bool:
        """Whether the entered value is refused; the state of the gains says why."""
        return self.row.name in self._editor.faults

    def show_fault(self) -> None:
        """Mark the text in the field as wrong, and leave it as it is; or no longer."""
        set_class(self.field, "bare bad" if self.is_refused else "bare")
        self._seen = None
        if self.is_refused:
            set_tip(self.field, f"✕ {self._editor.faults[self.row.name]}")
        else:
            self._say_names()
            self.show_value()

    def put_back(self) -> bool:
        """Propose the flown value again, and discard typed text.

        Returns:
            Whether anything changed.
        """
        was = self._mark is GainMark.PROPOSED or self.is_refused
        if was:
            self._editor.refuse(self.row.name, "")
            linked = self._editor.linked and linked_gain(self.row.name)
            self._editor.discard([self.row.name, *([linked] if linked else [])])
        self._seen = None  # discards a half-typed text
        self.show_value()
        return was

    def _step(self, direction: int, size: float) -> None:
        value = self._editor.proposed[self.row.name]
        self._editor.propose(self.row.name, self.slider.scale.stepped(value, direction, size))

    def _type(self, shown: float) -> None:
        """Propose the typed value; the table refuses invalid ones."""
        value = self._unit.read(shown)
        low, high = self.row.minimum, self.row.maximum
        if self._unit.factor != 1.0 and not low <= value <= high:
            said = f"{self._label.text} is {self._text(value)}: keep it within {self._limits()}"
            self._editor.refuse(self.row.name, said)  # in the unit of the typed text
        else:
            self._editor.refuse(self.row.name, "")
            self._editor.propose(self.row.name, value)

    def _reset(self) -> None:
        self._editor.end_edit()
        self._editor.propose(self.row.name, self._editor.start[self.row.name])

    def _limits(self) -> str:
        return f"{self._text(self.row.minimum)} to {self._text(self.row.maximum)}"

    def _text(self, value: float) -> str:
        return f"{gain_text(self._unit.shown(value))}{self._unit.suffix}"

    def _say_names(self) -> None:
        """Set tool tips and accessible texts: name, unit, range and help."""
        row, words = self.row, self._label.text
        limits = self._limits()
        stable = self._stable
        lines = [f"{row.name}: {row.help}", f"limits {limits}"]
        lines.append(f"▲ at the start {self._text(self._editor.start[row.name])}")
        if stable:
            old = "" if self._fresh else ", with earlier gains"
            lines.append(f"┃ stable {self._text(stable[0])} to {self._text(stable[1])}{old}")
        for part, kind in ((self.slider, "slider"), (self.field, "value")):
            part.setAccessibleName(f"{words} {kind}, {limits}")
            part.setAccessibleDescription("; ".join(lines))
            set_tip(part, "\n".join(lines))
        set_tip(self._name, "\n".join(lines))
        start = self._text(self._editor.start[row.name])
        self.reset.setAccessibleName(f"Reset {words} to {start}")
        set_tip(self.reset, f"Back to {start}, as the flight began")

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Divide the new width."""
        super().resizeEvent(event)
        self._share_width()

    def minimumSizeHint(self) -> QSize:
        """Return the size without the parameter's own name, and with the narrowest columns."""
        least = super().minimumSizeHint()
        grown = self._name.width() + self._unit_shown.width() - sum(self._least_widths())
        return QSize(least.width() - self._own_name_width() - grown, least.height())

    def _own_name_width(self) -> int:
        return self.own_name.width() + GAIN_COLUMN_GAP_PX if not self.own_name.isHidden() else 0

    def _least_widths(self) -> tuple[int, int]:
        """Least widths of the columns of name and unit [px]."""
        digit = self.fontMetrics().horizontalAdvance("0")
        return round(NAME_WIDTH_DIGITS * digit), round(UNIT_WIDTH_DIGITS * digit)

    def _lay_out(self) -> None:
        digit = self.fontMetrics().horizontalAdvance("0")
        self.field.setFixedWidth(round(FIELD_WIDTH_DIGITS * digit))
        self.mark.setFixedWidth(round(MARK_WIDTH_DIGITS * digit))
        self.mark.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.own_name.setText(self.row.name)
        self.own_name.hide()
        parts = (
            self._name,
            self.own_name,
            (self.slider, 1),
            self.field,
            self._unit_shown,
            self.mark,
            self.reset,
        )
        hbox(*parts, of=self, margins=NO_MARGINS, spacing=GAIN_COLUMN_GAP_PX)
        self._share_width()
