"""The form of the gains: made from the parameter table, one line per row."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise

from PyQt6.QtCore import QSignalBlocker, Qt
from PyQt6.QtGui import QKeyEvent, QShowEvent
from PyQt6.QtWidgets import (
    QCheckBox,
    QLineEdit,
    QSizePolicy,
    QWidget,
)

from workbench.common.parameter import Parameter
from workbench.gui.command_action import CommandAction
from workbench.gui.errands import single_shot
from workbench.gui.gains.gain_editor import GainEditor
from workbench.gui.gains.gain_row import GainRow
from workbench.gui.gains.gain_rows import FILTERS_GROUP, gain_groups, gain_label, is_gain
from workbench.gui.gains.set_bar import SetBar
from workbench.gui.key_table import FIND_GAIN_KEY
from workbench.gui.labels import set_tip
from workbench.gui.layout import (
    NO_MARGINS,
    hbox,
    label,
    named,
    scroll_area,
    tool_button,
    vbox,
)
from workbench.gui.workspace import Workspace

GAIN_LINE_GAP_PX = 1
"""Space between lines [px]."""
COLLAPSED_GROUP = "Limits"
"""This group is closed at first, so that the gains fit without scrolling."""
MORE_GROUP_TITLE = "More parameters"
GAIN_PANEL_STYLE = """
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
        self._lines = vbox(of=self._body, margins=(4, 0, 0, 2), spacing=GAIN_LINE_GAP_PX)
        vbox(self.heading, self._body, of=self, margins=NO_MARGINS, spacing=0)
        self.is_open = is_open
        self._searched: set[QWidget] | None = None
        self._left_out: set[QWidget] = set()
        self.set_open(is_open)

    @property
    def tab_stops(self) -> list[QWidget]:
        """What Tab goes to, in order."""
        rows = self._body.findChildren(GainRow, options=Qt.FindChildOption.FindDirectChildrenOnly)
        return [self.heading, *(stop for row in rows for stop in row.tab_stops)]

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


class GainPanel(QWidget):
    """All live parameters of the flight: gains first, everything else below.

    Enter flies the proposed values; Escape discards them. Tab goes to the heading of the first
    group, and then to the first gain.

    Args:
        workspace: colours and units.
        editor: sets them.

    Attributes:
        search_action: moves the focus to the search.
    """

    def __init__(self, workspace: Workspace, editor: GainEditor) -> None:
        super().__init__()
        self._workspace, self._editor = workspace, editor
        self.setAccessibleName("Gains")
        self.setStyleSheet(GAIN_PANEL_STYLE)
        self.rows: dict[str, GainRow] = {}
        self._groups: list[GainGroup] = []
        self._more: GainGroup | None = None
        self._has_more = False
        self._shown: tuple[Parameter, ...] = ()
        self._start: Mapping[str, float] = editor.start
        self.search = named(QLineEdit(), "Search parameters by name or help")
        self.search_action = CommandAction(FIND_GAIN_KEY, workspace.keys, self._show_search, self)
        self.search_action.changed.connect(self._show_search_key)
        self._show_search_key()
        self.search.setClearButtonEnabled(True)
        self.linked = QCheckBox("Link &x and y")
        set_tip(self.linked, "Move gains of x and y together; linking itself moves none")
        self.linked.setChecked(editor.linked)
        self.set_bar = SetBar(editor)
        self.nothing = label(workspace.absence.text, "muted", wraps=True)
        self.nothing.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._area = scroll_area(sideways=False)
        self._area.hide()
        vbox(
            hbox((self.search, 1), self.linked, margins=(8, 4, 8, 0)),
            self.set_bar,
            (self._area, 1),
            (self.nothing, 1),
            of=self,
            margins=NO_MARGINS,
            spacing=4,
        )
        self._soon = single_shot(self._show_all, self)
        self._connect()
        self._show_all()

    @property
    def first_stop(self) -> QWidget | None:
        """What Tab goes to first; None while nothing flies."""
        headings = (group.heading for group in self._groups)
        return next((each for each in headings if each.isVisible()), None)

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
        for name in [*self._editor.faults]:
            self._editor.refuse(name, "")
        self._editor.discard()

    def _show_search(self) -> None:
        self.search.setFocus(Qt.FocusReason.ShortcutFocusReason)

    def _show_search_key(self) -> None:
        self.search.setPlaceholderText(self._workspace.keys.with_key("find_gain", "Search"))

    def _connect(self) -> None:
        editor = self._editor
        self.search.textChanged.connect(self._search)
        self.linked.toggled.connect(editor.set_linked)
        editor.state_changed.connect(self._soon.start)
        editor.set_changed.connect(self._show_set)
        editor.flown_changed.connect(self._show_values)
        editor.proposed_changed.connect(self._show_value)
        editor.ranges_changed.connect(self._show_ranges)
        editor.value_refused.connect(self._show_fault)
        self._workspace.preferences.changed.connect(self._show_units)
        self._workspace.absence.changed.connect(self.nothing.setText)

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

    def _show_fault(self, name: str) -> None:
        if name in self.rows:
            self.rows[name].show_fault()

    def _make_rows(self) -> None:
        """Make the lines of the flight's gains; the other lines are made when needed."""
        self._shown, self._start = self._editor.rows, self._editor.start
        self.rows, self._has_more = {}, False
        self._groups = []
        content = QWidget()
        gains = [row for row in self._shown if is_gain(row)]
        groups = [
            self._make_group(title, gains, title != COLLAPSED_GROUP) for title in gain_groups(gains)
        ]
        filters = [row for row in self._shown if gain_label(row).group == FILTERS_GROUP]
        if filters and gains:
            groups.append(self._make_group(FILTERS_GROUP, filters, False))
        self._more = GainGroup(MORE_GROUP_TITLE, False, self)
        self._more.heading.clicked.connect(self._make_more)
        vbox(*groups, self._more, 0, of=content, margins=(8, 0, 2, 2), spacing=0)
        self._area.setWidget(content)
        self._area.setVisible(bool(gains))
        self.nothing.setVisible(not gains)
        self._show_ranges()
        self._search(self.search.text())
        self._set_tab_order()
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
        rest = [row for row in self._shown if not is_gain(row) and row.name not in self.rows]
        if self._more is None or self._has_more:
            return
        self._has_more = True
        titles = dict.fromkeys(gain_label(row).group for row in rest)
        self._more.add([self._make_group(title, rest, True) for title in titles])
        self._set_tab_order()

    def _set_tab_order(self) -> None:
        """Let Tab go through the gains first: their lines are made after everything else."""
        more = self._more
        assert more is not None
        inside = [each for each in self._groups if more.isAncestorOf(each)]
        groups = (*(each for each in self._groups if each not in inside), more, *inside)
        gains = [stop for group in groups for stop in group.tab_stops]
        stops = (*gains, self.search, self.linked, self.set_bar.choice)
        for one, other in pairwise(stops):
            self.setTabOrder(one, other)

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
