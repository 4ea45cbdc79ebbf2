"""The line of one parameter: name, slider, number, what has changed, and a way back."""

from functools import partial

from PyQt6.QtCore import QSize, Qt
from PyQt6.QtGui import QResizeEvent
from PyQt6.QtWidgets import QGridLayout, QLabel, QToolButton, QWidget

from workbench.gui.elided_label import ElidedLabel
from workbench.gui.gains.gain_editor import GainEditor, Mark
from workbench.gui.gains.gain_field import GainField
from workbench.gui.gains.gain_rows import gain_label, partner
from workbench.gui.gains.gain_scale import GainScale, StepSize, decimals
from workbench.gui.gains.gain_slider import GainSlider
from workbench.gui.style import dressed, set_class
from workbench.gui.units import unit_for
from workbench.gui.workspace import Workspace
from workbench.scenario.parameters import Parameter

MOST_DECIMALS = 3
SHAPES = {Mark.KEPT: "", Mark.TRIED: "◆", Mark.PROPOSED: "◇"}
OWN_NAME_WIDTH, ROOM_FOR_NAME = 11.6, 54.0
"""Of the parameter's own name, and of a line that has room for it, in widths of a digit."""
NAME_WIDTH, FIELD_WIDTH, UNIT_WIDTH, MARK_WIDTH = 14.4, 7.4, 3.8, 1.6
"""Of the columns, in widths of a digit, so that all lines have them alike."""


class GainRow(QWidget):
    """A parameter to be set.

    Args:
        workspace: colours and units.
        editor: sets it.
        row: of the parameter table.
        parent: owner.

    Attributes:
        row: of the parameter table.
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
        self._label = gain_label(row)
        self._unit = unit_for(row.unit, workspace.preferences)
        self._mark = Mark.KEPT
        self._seen: tuple[float, float, float] | None = None
        self._stable: tuple[float, float] | None = None
        self._fresh = False
        self.slider = GainSlider(GainScale(row, self._unit), workspace.look, self)
        self.field = GainField(self)
        self.mark = QLabel(self)
        self.reset = QToolButton(self)
        self.reset.setText("↺")
        self.reset.setProperty("class", "quiet compact")
        self.reset.setFixedWidth(24)
        self.error = dressed(QLabel(self), "bad")
        self.error.setWordWrap(True)
        self.error.hide()
        self._name = QLabel(self)
        self.own_name = dressed(ElidedLabel(self), "muted small")
        self._unit_shown = dressed(QLabel(self), "muted")
        self._name.setBuddy(self.field)
        self._lay_out()
        for part in (self.slider, self.field):
            part.stepped.connect(self._step)
            part.edit_begun.connect(editor.begin_edit)
            part.edit_ended.connect(editor.end_edit)
        self.slider.dragged.connect(partial(editor.propose, row.name))
        self.field.edited.connect(self._type)
        self.field.refused.connect(self._show_error)
        self.reset.clicked.connect(self._reset)
        self.show_unit()

    def matches(self, words: str) -> bool:
        """Return whether all words stand in its name, symbol, group or help."""
        label = self._label
        text = f"{self.row.name} {label.words} {label.symbol} {label.group} {self.row.help}".lower()
        return all(word in text for word in words.lower().split())

    def show_unit(self) -> None:
        """Show name and unit as the user prefers them, and where the flight began."""
        muted = self._workspace.look.colours.muted
        symbol = f" <span style='color:{muted}'>{self._label.symbol}</span>"
        self._name.setText(self._label.words + (symbol if self._label.symbol else ""))
        self._unit = unit_for(self.row.unit, self._workspace.preferences)
        scale = self.slider.scale = GainScale(self.row, self._unit)
        start = self._editor.start[self.row.name]
        step = self._unit.shown(scale.step(start))
        fine = decimals(step * StepSize.FINEST.value)
        self.field.show_decimals(0 if self.row.whole else min(fine, MOST_DECIMALS))
        self._unit_shown.setText(self._unit.symbol)
        self.slider.show_start(start)
        self._say_names()
        self._seen = None
        self.show_value()

    def show_value(self) -> None:
        """Show what is proposed and flown, and how that stands to what was kept."""
        name = self.row.name
        proposed, flown = self._editor.proposed[name], self._editor.flown[name]
        kept = self._editor.kept.get(name, self._editor.start[name])
        mark = self._editor.mark(name)
        seen = (proposed, flown, kept)
        if seen == self._seen and mark is self._mark:
            return  # so that nothing is taken from who types here
        self._seen = seen
        self.slider.show_value(proposed, flown)
        if self.error.isHidden():
            self.field.show_value(self._unit.shown(proposed))
        self._mark = mark
        self.mark.setText(SHAPES[mark])
        said = f"{self._label.text}: {mark.value}; kept is {self._text(kept)}"
        self.mark.setAccessibleName(said)
        self.mark.setToolTip("" if mark is Mark.KEPT else said)
        self.reset.setEnabled(proposed != self._editor.start[name])

    def show_range(self, stable: tuple[float, float] | None, fresh: bool) -> None:
        """Show where the loop is stable.

        Args:
            stable: least and largest value, in SI; None where they are not known.
            fresh: whether they are those of the gains that fly.
        """
        if (stable, fresh) == (self._stable, self._fresh):
            return
        self._stable, self._fresh = stable, fresh
        self.slider.show_stable(stable, fresh)
        self._say_names()

    def show_error(self, said: str) -> None:
        """Say why a value may not be; "" once all is well."""
        self._show_error(said)
        if not said:
            self.show_value()

    def put_back(self) -> bool:
        """Propose the flown value again, and let go of what was typed.

        Returns:
            Whether there was anything to put back.
        """
        was = self._mark is Mark.PROPOSED or not self.error.isHidden()
        if was:
            self.show_error("")
            linked = self._editor.linked and partner(self.row.name)
            self._editor.discard([self.row.name, *([linked] if linked else [])])
        self._seen = None  # a text that is half typed goes
        self.show_value()
        return was

    def _show_error(self, said: str) -> None:
        """Show what is wrong with the text in the field, and leave the text as it is."""
        self.error.setText(f"✕ {said}".replace("^2", "²") if said else "")
        self.error.setVisible(bool(said))
        set_class(self.field, "bare bad" if said else "bare")
        self._seen = None

    def _step(self, direction: int, size: StepSize) -> None:
        value = self._editor.proposed[self.row.name]
        self._editor.propose(self.row.name, self.slider.scale.stepped(value, direction, size))

    def _type(self, shown: float) -> None:
        """Propose what was typed; the table refuses what may not be."""
        value = self._unit.read(shown)
        low, high = self.row.minimum, self.row.maximum
        if self._unit.factor != 1.0 and not low <= value <= high:
            said = f"{self._label.text} is {self._text(value)}: keep it within {self._limits()}"
            self.show_error(said)  # in the unit that was typed
        else:
            self._show_error("")
            self._editor.propose(self.row.name, value)

    def _reset(self) -> None:
        self._editor.end_edit()
        self._editor.propose(self.row.name, self._editor.start[self.row.name])

    def _limits(self) -> str:
        return f"{self._text(self.row.minimum)} to {self._text(self.row.maximum)}"

    def _text(self, value: float) -> str:
        gap = "" if self._unit.symbol == "°" else " "
        return f"{self._unit.shown(value):.4g}{gap}{self._unit.symbol}".strip()

    def _say_names(self) -> None:
        """Say name, unit, range and help to those who point, and to those who listen."""
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
            part.setToolTip("\n".join(lines))
        self._name.setToolTip("\n".join(lines))
        start = self._text(self._editor.start[row.name])
        self.reset.setAccessibleName(f"Reset {words} to {start}")
        self.reset.setToolTip(f"Back to {start}, as the flight began")

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Show the parameter's own name where there is room for it."""
        super().resizeEvent(event)
        digit = self.fontMetrics().horizontalAdvance("0")
        self.own_name.setVisible(self.width() >= ROOM_FOR_NAME * digit)

    def minimumSizeHint(self) -> QSize:
        """Return the room without the parameter's own name."""
        least = super().minimumSizeHint()
        extra = self.own_name.width() + 4 if not self.own_name.isHidden() else 0
        return QSize(least.width() - extra, least.height())

    def _lay_out(self) -> None:
        digit = self.fontMetrics().horizontalAdvance("0")
        self._name.setFixedWidth(round(NAME_WIDTH * digit))
        self.field.setFixedWidth(round(FIELD_WIDTH * digit))
        self._unit_shown.setFixedWidth(round(UNIT_WIDTH * digit))
        self.mark.setFixedWidth(round(MARK_WIDTH * digit))
        self.mark.setAlignment(Qt.AlignmentFlag.AlignCenter)
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(4)
        grid.setVerticalSpacing(1)
        self.own_name.setText(self.row.name)
        self.own_name.setFixedWidth(round(OWN_NAME_WIDTH * digit))
        parts = (
            self._name,
            self.own_name,
            self.slider,
            self.field,
            self._unit_shown,
            self.mark,
            self.reset,
        )
        for column, part in enumerate(parts):
            grid.addWidget(part, 0, column)
        grid.addWidget(self.error, 1, 0, 1, len(parts))
        grid.setColumnStretch(2, 1)
