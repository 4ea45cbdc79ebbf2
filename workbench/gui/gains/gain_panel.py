"""The form of the gains: made from the parameter table, one line per row."""

from collections.abc import Iterable, Mapping, Sequence

from PyQt6.QtCore import QSignalBlocker, Qt
from PyQt6.QtGui import QKeyEvent, QKeySequence, QShortcut, QShowEvent
from PyQt6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QFrame,
    QLineEdit,
    QSizePolicy,
    QWidget,
)

from workbench.gui.errands import single_shot
from workbench.gui.gains.gain_editor import GainEditor
from workbench.gui.gains.gain_row import GainRow
from workbench.gui.gains.gain_rows import gain_groups, gain_label, is_gain
from workbench.gui.labels import set_tip
from workbench.gui.layout import (
    NO_MARGINS,
    button,
    choice,
    hbox,
    label,
    named,
    scroll_area,
    tool_button,
    vbox,
)
from workbench.gui.workspace import Workspace
from workbench.scenario.parameters import Parameter
from workbench.session.snapshot import Snapshot

GAP = 1
"""Space between lines [px]."""
CLOSED = "Limits"
"""This group is closed at first, so that the gains fit without scrolling."""
MORE = "More parameters"
NOTHING = "Nothing flies yet: open a scenario to tune its gains."
COMPACT = """
GainField { min-height: 16px; padding: 1px 5px; }
GainField:focus, GainField[class~="bad"] { padding: 0 4px; }
GainGroup > QToolButton { font-weight: 600; text-align: left; min-height: 16px; padding: 3px 4px; }
GainGroup > QToolButton:focus { padding: 2px 3px; }
GainSlider:horizontal { min-height: 19px; }
GainRow > QToolButton { min-height: 16px; padding: 1px 4px; }
GainRow > QToolButton:focus { padding: 0 3px; }
"""
"""Compact style, so that all gains fit into a window of 720 lines."""


class GainGroup(QWidget):
    """A heading and the lines below it.

    Args:
        title: the heading.
        is_open: whether it is open at first.
        parent: the Qt parent.

    Attributes:
        heading: opens and closes.
    """

    def __init__(self, title: str, is_open: bool, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.heading = tool_button(
            title, lambda: self.set_open(not self.is_open), "quiet compact heading"
        )
        self.heading.setAccessibleName(f"{title}, show or hide")
        self.heading.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.heading.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.heading.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self._body = QWidget(self)
        self._lines = vbox(of=self._body, margins=(4, 0, 0, 2), spacing=GAP)
        vbox(self.heading, self._body, of=self, margins=NO_MARGINS, spacing=0)
        self.is_open = is_open
        self._searched: set[QWidget] | None = None
        self._left_out: set[QWidget] = set()
        self.set_open(is_open)

    def add(self, lines: Sequence[QWidget]) -> None:
        """Append lines."""
        for line in lines:
            self._lines.addWidget(line)

    def set_open(self, is_open: bool) -> None:
        """Show the lines, or only the heading."""
        self.is_open = is_open
        self._show()

    def search(self, found: set[QWidget] | None) -> None:
        """Show the lines that were found, whether the group is open or not; None for no search."""
        self._searched = found
        self._show()

    def leave_out(self, lines: set[QWidget]) -> None:
        """Always hide these lines."""
        self._left_out = lines
        self._show()

    def _show(self) -> None:
        is_open = self.is_open or self._searched is not None
        arrow = Qt.ArrowType.DownArrow if is_open else Qt.ArrowType.RightArrow
        self.heading.setArrowType(arrow)
        self._body.setVisible(is_open)
        if self._searched is None:
            self.setVisible(True)
            self._show_lines(None)
        else:
            self.setVisible(self._show_lines(self._searched))

    def _show_lines(self, found: set[QWidget] | None) -> bool:
        """Show these lines; return whether there are any."""
        shown = False
        for index in range(self._lines.count()):
            item = self._lines.itemAt(index)
            line = item.widget() if item else None
            if line is not None:
                seen = line not in self._left_out and (found is None or line in found)
                line.setVisible(seen)
                shown = shown or seen
        return shown


class StabilityWarning(QFrame):
    """Says above the gains why they do not fly, and asks whether to fly them.

    Args:
        editor: has the gains.
    """

    def __init__(self, editor: GainEditor) -> None:
        super().__init__()
        self.setProperty("class", "card")
        self.said = named(label(wraps=True), "Why the gains are not flown")
        self.fly = button(
            "&Fly it anyway",
            editor.confirm,
            help="Fly the proposed gains in spite of the warning (Ctrl+Return)",
        )
        self.back = button("&Back", editor.discard, "primary", "Discard the proposed gains (Esc)")
        QShortcut(QKeySequence("Ctrl+Return"), self).activated.connect(editor.confirm)
        buttons = hbox(0, self.fly, self.back)
        vbox(self.said, buttons, of=self, margins=(8, 6, 8, 6), spacing=5)
        editor.warning_changed.connect(self._show)
        self._show(editor.warning)

    def _show(self, said: str) -> None:
        self.said.setText(f"▲ Not flown: {said.rstrip('.')}.")
        self.setVisible(bool(said))


class SetBar(QWidget):
    """Shows which set of scheduled gains flies, and selects the one whose sliders are shown.

    Args:
        editor: has the gains.
    """

    def __init__(self, editor: GainEditor) -> None:
        super().__init__()
        self._editor = editor
        self.choice = choice(
            "Set of gains",
            help="The sliders show, and margins and steps are for, this set of gains in hover; the "
            "flight continues between the sets",
        )
        self.choice.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToContents)
        name = label("&Set")
        name.setBuddy(self.choice)
        self.flies = label(kind="muted")
        hbox(name, self.choice, (self.flies, 1), of=self, margins=(8, 0, 8, 0))
        self.choice.activated.connect(lambda place: editor.show_set(place - 1 if place else None))
        self.show_schedule()

    def show_schedule(self) -> None:
        """Show the sets of the flight's gains; hidden without a schedule."""
        schedule = self._editor.schedule
        self.setVisible(schedule is not None)
        self.choice.clear()
        if schedule is not None:
            self.choice.addItem("that flies")
            numbers = range(len(schedule.values))
            self.choice.addItems([schedule.where(number) for number in numbers])
        self.flies.setText("")

    def show_snapshot(self, snapshot: Snapshot) -> None:
        """Show which set flies now."""
        schedule, shown = self._editor.schedule, self._editor.shown_set
        if schedule is None or shown is None:
            return
        value = self._editor.scheduled_value(snapshot)
        unit = "" if schedule.quantity.unit == "1" else f" {schedule.quantity.unit}"
        shows = f", set at {schedule.values[shown]:g}" if self._editor.follows else ""
        self.flies.setText(f"{schedule.quantity.name} {value:.2f}{unit}{shows}")


class GainPanel(QWidget):
    """All live parameters of the flight: gains first, everything else below.

    Enter flies the proposed values; Escape discards them.

    Args:
        workspace: colours and units.
        editor: sets them.
    """

    def __init__(self, workspace: Workspace, editor: GainEditor) -> None:
        super().__init__()
        self._workspace, self._editor = workspace, editor
        self.setAccessibleName("Gains")
        self.setStyleSheet(COMPACT)
        self.rows: dict[str, GainRow] = {}
        self._groups: list[GainGroup] = []
        self._more: GainGroup | None = None
        self._shown: tuple[Parameter, ...] = ()
        self._start: Mapping[str, float] = editor.start
        self.search = named(QLineEdit(), "Search parameters by name or help")
        self.search.setPlaceholderText("Search (Ctrl+F)")
        self.search.setClearButtonEnabled(True)
        self.linked = QCheckBox("Link &x and y")
        set_tip(self.linked, "Move gains of x and y together; linking itself moves none")
        self.linked.setChecked(editor.linked)
        self.warning = StabilityWarning(editor)
        self.set_bar = SetBar(editor)
        self.nothing = label(NOTHING, "muted", wraps=True)
        self.nothing.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._area = scroll_area(sideways=False)
        self._area.hide()
        vbox(
            hbox((self.search, 1), self.linked, margins=(8, 4, 8, 0)),
            self.set_bar,
            hbox(self.warning, margins=(8, 0, 8, 0)),
            (self._area, 1),
            (self.nothing, 1),
            of=self,
            margins=NO_MARGINS,
            spacing=4,
        )
        self._soon = single_shot(self._show_all, self)
        self._connect()
        self._show_all()

    def showEvent(self, event: QShowEvent | None) -> None:
        super().showEvent(event)
        self._editor.find_ranges()

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        if event is None:
            return
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self._editor.apply()
        elif event.key() == Qt.Key.Key_Escape:
            self._escape()
        else:
            super().keyPressEvent(event)

    def _escape(self) -> None:
        """Clear the search, or discard proposed values: of the focused line, or all."""
        if self.search.hasFocus() and self.search.text():
            self.search.clear()
            return
        here = self.focusWidget()
        focused = [row for row in self.rows.values() if here and row.isAncestorOf(here)]
        if any(row.put_back() for row in focused):
            return
        for row in self.rows.values():
            if not row.error.isHidden():
                row.show_error("")
        self._editor.discard()

    def _connect(self) -> None:
        editor = self._editor
        self.search.textChanged.connect(self._search)
        QShortcut(QKeySequence("Ctrl+F"), self).activated.connect(self.search.setFocus)
        self.linked.toggled.connect(editor.set_linked)
        editor.state_changed.connect(self._soon.start)
        editor.set_changed.connect(self._show_set)
        editor.flown_changed.connect(self._show_values)
        editor.proposed_changed.connect(self._show_value)
        editor.ranges_changed.connect(self._show_ranges)
        editor.value_refused.connect(self._show_error)
        self._workspace.preferences.changed.connect(self._show_units)

    def _show_all(self) -> None:
        """Show the state of everything; lines are made again if other ones are needed."""
        if self._shown != self._editor.rows:
            self._make_rows()
        elif self._start is not self._editor.start:
            self._show_start()
        with QSignalBlocker(self.linked):
            self.linked.setChecked(self._editor.linked)
        self._show_values(self.rows)

    def _show_values(self, names: Iterable[str]) -> None:
        for name in names:
            if name in self.rows and name in self._editor.proposed:
                self.rows[name].show_value()

    def _show_value(self, name: str) -> None:
        self._show_values([name])

    def _show_ranges(self) -> None:
        fresh = self._editor.has_fresh_ranges
        for name, row in self.rows.items():
            if is_gain(row.row) and name in self._editor.proposed:
                row.show_range(self._editor.stable_range(name), fresh)

    def _show_start(self) -> None:
        """Show another flight's start, in the present units and colours."""
        self._start = self._editor.start
        for row in self.rows.values():
            row.show_unit()
        self._show_ranges()
        if self.isVisible():
            self._editor.find_ranges()

    def _show_units(self, preference: str = "") -> None:
        if self._shown != self._editor.rows:
            return  # another flight has begun: its lines are made after the present event
        for row in self.rows.values():
            row.show_unit()

    def _show_error(self, name: str, said: str) -> None:
        if name in self.rows:
            self.rows[name].show_error(said)

    def _make_rows(self) -> None:
        """Make the lines of the flight's gains; the other lines are made when needed."""
        self._shown, self._start = self._editor.rows, self._editor.start
        self.rows = {}
        self._groups = []
        content = QWidget()
        gains = [row for row in self._shown if is_gain(row)]
        groups = [self._make_group(title, gains, title != CLOSED) for title in gain_groups(gains)]
        self._more = GainGroup(MORE, False, self)
        self._more.heading.clicked.connect(self._make_more)
        vbox(*groups, self._more, 0, of=content, margins=(8, 0, 2, 2), spacing=0)
        self._area.setWidget(content)
        self._area.setVisible(bool(gains))
        self.nothing.setVisible(not gains)
        self._show_ranges()
        self._search(self.search.text())
        self.set_bar.show_schedule()
        self._show_set()
        if self.isVisible():
            self._editor.find_ranges()

    def _show_set(self) -> None:
        """Show the lines of one set of scheduled gains."""
        shown = self._editor.of_set(dict.fromkeys(self.rows, 0.0))
        others: set[QWidget] = {row for name, row in self.rows.items() if name not in shown}
        for group in self._groups:
            group.leave_out(others)

    def _make_more(self) -> None:
        """Make the lines of the other parameters, when they are first needed."""
        rest = [row for row in self._shown if not is_gain(row)]
        if self._more is None or any(row.name in self.rows for row in rest):
            return
        titles = dict.fromkeys(gain_label(row).group for row in rest)
        self._more.add([self._make_group(title, rest, True) for title in titles])

    def _make_group(self, title: str, rows: Iterable[Parameter], is_open: bool) -> GainGroup:
        group = GainGroup(title, is_open, self)  # shown without a parent it would be a window
        made = [
            GainRow(self._workspace, self._editor, row)
            for row in rows
            if gain_label(row).group == title
        ]
        self.rows.update({each.row.name: each for each in made})
        widths = [each.wanted_widths for each in self.rows.values()]
        name, unit = (max(each) for each in zip(*widths, strict=True)) if widths else (0, 0)
        for each in self.rows.values():
            each.set_widths(name, unit)
        group.add(made)
        group.setVisible(bool(made))
        self._groups.append(group)
        return group

    def _search(self, words: str) -> None:
        """Show the lines that match the words, in any group; all lines without words."""
        if words.strip():
            self._make_more()
        found: set[QWidget] = {row for row in self.rows.values() if row.matches(words)}
        for group in self._groups:
            group.search(found if words.strip() else None)
        if self._more is not None:
            inside = {each for each in self._groups if self._more.isAncestorOf(each)}
            kept: set[QWidget] = {each for each in inside if each.isVisibleTo(self._more)}
            self._more.search(kept if words.strip() else None)
