"""The dialog with the history of the gains: kept in this flight, and saved in their file."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import datetime
from itertools import pairwise

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QDialog, QHeaderView, QTableWidget, QTableWidgetItem, QWidget

from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import plain_text
from workbench.gains.gains import gains_at
from workbench.gui.gains.gain_editor import GainEditor
from workbench.gui.gains.gain_files import GainFiles
from workbench.gui.gains.gain_history import GainHistory
from workbench.gui.labels import set_tip
from workbench.gui.layout import button, hbox, label, vbox
from workbench.gui.notices import Notices
from workbench.gui.tables import table_heads, text_table
from workbench.gui.tuning.designs import gain_differences_text
from workbench.gui.units import simulated_text

HISTORY_SIZE_PX = (680, 360)
HISTORY_COLUMNS = ("When", "Gains that changed", "Note")
NOTE_COLUMN = 2
MAX_LISTED_GAINS = 4


@dataclass(frozen=True)
class HistoryLine:
    """One state of the gains.

    Attributes:
        when: when it was kept or saved.
        what: how it differs from the state before.
        note: the note on it.
        index: of the entry of this flight that it is; None for one of the file, whose note stays.
        gains: returns its values.
    """

    when: str
    what: str
    note: str
    index: int | None
    gains: Callable[[], Mapping[str, float]]


def history_lines(history: GainHistory, files: GainFiles) -> list[HistoryLine]:
    """Return all known states, the newest first: those of this flight, then those of the file."""
    entries = history.entries
    before = [entries[0], *(entry for entry, _ in pairwise(entries))] if entries else []
    kept = [
        HistoryLine(
            f"{entry.clock}, at {simulated_text(entry.time)}" if index else f"{entry.clock}, start",
            gain_differences_text(entry.gains, last.gains, same="–", most=MAX_LISTED_GAINS),
            entry.note,
            index,
            lambda entry=entry: entry.gains,
        )
        for index, (entry, last) in enumerate(zip(entries, before, strict=True))
    ]
    return [*reversed(kept), *reversed(_saved_lines(files))]


def _saved_lines(files: GainFiles) -> list[HistoryLine]:
    """Return the states in the gain file, oldest first."""
    file = files.file
    if file is None:
        return []
    return [
        HistoryLine(
            _saved_text(save.saved),
            ", ".join(list(save.changed)[:MAX_LISTED_GAINS]) or "–",
            save.origin,
            None,
            lambda index=index: gains_at(file, index, files.controller).gains,
        )
        for index, save in enumerate(file.history)
    ]


def _saved_text(saved: str) -> str:
    """Return when a state was saved, in the user's time zone as those of this flight."""
    try:
        return f"{datetime.fromisoformat(saved).astimezone():%Y-%m-%d %H:%M:%S}, saved"
    except ValueError:
        return plain_text(saved) or "by hand"


class HistoryDialog(QDialog):
    """States of the gains, which can be proposed again; notes are typed into the table.

    Args:
        editor: takes the gains.
        history: the gains kept in this flight.
        files: has the gain file.
        notices: takes refusals.
        parent: the Qt parent.

    Attributes:
        table: a row for each state.
        propose: proposes the selected one.
    """

    def __init__(
        self,
        editor: GainEditor,
        history: GainHistory,
        files: GainFiles,
        notices: Notices,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle("History of the gains")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._editor, self._history, self._files = editor, history, files
        self._notices = notices
        self._lines: list[HistoryLine] = []
        empty = QTableWidget(0, len(HISTORY_COLUMNS))
        self.table = text_table(empty, "States of the gains", wide=1)
        self.table.setHorizontalHeaderLabels(HISTORY_COLUMNS)
        self.table.setEditTriggers(QTableWidget.EditTrigger.AllEditTriggers)
        heads, sides = table_heads(self.table)
        sides.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)  # notes wrap
        heads.setSectionResizeMode(NOTE_COLUMN, QHeaderView.ResizeMode.Stretch)
        help = "A note is typed into the table; it is saved with the gains."
        self.propose = button("&Propose these", self._propose, "primary")
        below = hbox((label(help, "muted", wraps=True), 1), self.propose)
        fill = hbox(1, button("&Close", self.close))
        vbox((self.table, 1), below, fill, of=self, margins=(14, 12, 14, 12), spacing=8)
        self.table.cellChanged.connect(self._take_note)
        self.table.itemSelectionChanged.connect(self._show_choice)
        history.changed.connect(self._show)
        self._show()
        self.resize(*HISTORY_SIZE_PX)

    def _show(self) -> None:
        self._lines = history_lines(self._history, self._files)
        self.table.blockSignals(True)
        self.table.setRowCount(len(self._lines))
        for row, line in enumerate(self._lines):
            for column, text in enumerate((line.when, line.what, line.note)):
                item = QTableWidgetItem(plain_text(text))
                set_tip(item, text)
                edits = column == NOTE_COLUMN and line.index is not None
                if not edits:
                    item.setFlags(item.flags() & ~Qt.ItemFlag.ItemIsEditable)
                self.table.setItem(row, column, item)
        self.table.blockSignals(False)
        self._show_choice()

    def _show_choice(self) -> None:
        self.propose.setEnabled(bool(self.table.selectedItems()))

    def _take_note(self, row: int, column: int) -> None:
        index, item = self._lines[row].index, self.table.item(row, column)
        if index is not None and item is not None and column == NOTE_COLUMN:
            self._history.set_note(index, item.text())

    def _propose(self) -> None:
        line = self._lines[self.table.currentRow()]
        try:
            self._editor.adopt(line.gains(), f"gains of {line.when}")
        except WorkbenchError as error:
            self._notices.warn(str(error))
