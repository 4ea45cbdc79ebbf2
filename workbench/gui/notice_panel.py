"""The list of notices over the lower end of the window: it moves nothing below it."""

import time
from collections.abc import Callable, Mapping
from datetime import datetime, timedelta

from PyQt6.QtCore import QSize, Qt
from PyQt6.QtGui import QAction, QKeyEvent
from PyQt6.QtWidgets import QFrame, QListWidget, QListWidgetItem, QWidget

from workbench.common.plain_text import plain_text
from workbench.gui.file_dialogs import clipboard
from workbench.gui.icons import shape_icon
from workbench.gui.layout import button, hbox, label, named, tool_button, vbox
from workbench.gui.notice_list import NoticeList
from workbench.gui.notices import Notice, Severity
from workbench.gui.remedy_buttons import RemedyButtons
from workbench.gui.theme import Look

NOTICE_PANEL_SIZE_PX = (760, 300)
"""Largest size of the panel [px]."""
NOTICE_COLOURS = {
    Severity.INFORMATION: "accent",
    Severity.WARNING: "warning",
    Severity.FAILURE: "bad",
}
LISTED_ICON_PX = 16
NO_NOTICES_TEXT = "There are no notices."


class NoticePanel(QFrame):
    """Lists all notices; a click on one shows the buttons for its remedy.

    Args:
        listed: the notices.
        changed: called when some were dismissed.
        actions: actions that a remedy may name.
        look: source of the colours.
        parent: the window.

    Attributes:
        rows: the list.
        remedies: buttons for the chosen notice.
    """

    def __init__(
        self,
        listed: NoticeList,
        changed: Callable[[], None],
        actions: Mapping[str, QAction],
        look: Look,
        parent: QWidget,
    ) -> None:
        super().__init__(parent)
        self.setObjectName("notices")
        self._list, self._changed, self._look = listed, changed, look
        self._shown: tuple[Notice, ...] = ()
        self.rows = named(QListWidget(), "Notices, the newest and gravest first")
        self.rows.setWordWrap(True)
        self.rows.setTextElideMode(Qt.TextElideMode.ElideNone)
        self.rows.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.rows.setResizeMode(QListWidget.ResizeMode.Adjust)
        self.rows.setIconSize(QSize(LISTED_ICON_PX, LISTED_ICON_PX))
        self.rows.currentRowChanged.connect(lambda _: self._show_chosen())
        self.remedies = RemedyButtons(actions)
        self.copy = button("&Copy", self._copy, help="Copy the notice, with its details")
        self.dismiss = button("&Dismiss", self._dismiss, help="Show the notice no longer")
        self.clear = button("C&lear", self._clear, help="Remove the notices that are over")
        close = tool_button("✕", self.hide, "quiet compact", "Close (Esc)")
        self._close = named(close, "Close the list of notices")
        head = hbox(label("Notices", "heading"), 0, self._close)
        foot = hbox(self.clear, 0, self.remedies, self.copy, self.dismiss, spacing=6)
        vbox(head, (self.rows, 1), foot, of=self, margins=(10, 8, 10, 8), spacing=6)
        look.changed.connect(self._fill)  # icons are in its colours
        self._fill()
        self.hide()

    @property
    def chosen(self) -> Notice | None:
        """The chosen notice."""
        row = self.rows.currentRow()
        return self._shown[row] if 0 <= row < len(self._shown) else None

    def show_notices(self) -> None:
        """Show the present list; the chosen notice stays chosen."""
        if self._list.ordered == self._shown:
            self._show_chosen()
        else:
            self._fill()

    def _fill(self) -> None:
        chosen = self.chosen
        self._shown = self._list.ordered
        self.rows.clear()
        for each in self._shown:
            self.rows.addItem(self._item(each))
        same = (
            row
            for row, each in enumerate(self._shown)
            if chosen is not None and each.what == chosen.what
        )
        self.rows.setCurrentRow(next(same, 0))
        if not self._shown:
            self.rows.addItem(NO_NOTICES_TEXT)
        self._show_chosen()

    def place_above(self, line: QWidget) -> None:
        """Place it over the lower end of the window, above a line."""
        window = self.parentWidget()
        assert window is not None
        corner = line.mapTo(window, line.rect().topRight())
        width, height = NOTICE_PANEL_SIZE_PX
        width, height = min(width, line.width()), min(height, corner.y())
        self.setGeometry(corner.x() - width + 1, corner.y() - height, width, height)

    def show_above(self, line: QWidget) -> None:
        """Show it over the lower end of the window, above a line."""
        self.place_above(line)
        self.show_notices()
        self.show()
        self.raise_()
        self.rows.setFocus()

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Close it by Escape; Qt's name."""
        if event is not None and event.key() == Qt.Key.Key_Escape:
            self.hide()
        else:
            super().keyPressEvent(event)

    def _item(self, notice: Notice) -> QListWidgetItem:
        ago = timedelta(seconds=time.monotonic() - notice.told_at)
        word = notice.severity.value.capitalize() + (", over" if notice.is_over else "")
        told_at = f"{datetime.now() - ago:%H:%M:%S}"
        said = f"{told_at}  {word}: {notice.sentence} {notice.remedy}".rstrip()
        item = QListWidgetItem(plain_text(said))
        colour = self._look.colour("muted" if notice.is_over else NOTICE_COLOURS[notice.severity])
        item.setIcon(shape_icon(notice.severity.value, colour, LISTED_ICON_PX))
        if notice.is_over:
            item.setForeground(self._look.colour("muted"))
        return item

    def _show_chosen(self) -> None:
        chosen = self.chosen
        self.remedies.show_remedy(chosen.advice if chosen is not None else "")
        self.copy.setEnabled(chosen is not None)
        self.dismiss.setEnabled(chosen is not None and not chosen.is_over)
        self.clear.setEnabled(len(self._list.present) < len(self._list.ordered))

    def _copy(self) -> None:
        if (chosen := self.chosen) is not None:
            lines = (chosen.what, chosen.remedy, chosen.details)
            clipboard().setText("\n".join(filter(None, lines)))

    def _dismiss(self) -> None:
        if (chosen := self.chosen) is not None:
            self._list.end(lambda notice: notice == chosen)
            self._changed()

    def _clear(self) -> None:
        self._list.clear()
        self._changed()
