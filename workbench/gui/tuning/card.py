"""Cards of the tuning screen, and parts that they share."""

from bisect import bisect_left
from collections.abc import Mapping, Sequence

from PyQt6.QtCore import QEvent, QSignalBlocker, Qt, pyqtSignal
from PyQt6.QtGui import QMouseEvent, QResizeEvent
from PyQt6.QtWidgets import (
    QComboBox,
    QFrame,
    QGridLayout,
    QMenu,
    QWidget,
)

from workbench.common.plain_text import plain_name, plain_text
from workbench.gui.help import set_card_help
from workbench.gui.labels import Label, WrappedLabel, set_tip
from workbench.gui.layout import NO_MARGINS, add_action, buddy, grid, hbox, label, menu_button, vbox
from workbench.gui.style import set_class, with_class

CARD_SPACING_PX = 6
SENTENCE_LINES = 2
"""Lines for which a sentence of a card has room."""
MAX_TEXT_HEIGHT_PX = 9999
"""Height of the space in which a sentence is measured [px]."""
CARD_FILL_SHORTCUT, CARD_WINDOW_SHORTCUT = "Shift+F11", "Ctrl+F11"
"""Keys that let a card fill its column, and have a window of its own."""


class TuningCard(QFrame):
    """A framed part of a screen, with a heading.

    A double click on the heading lets it fill its column; the menu there can also move it to a
    window of its own.

    Args:
        title: heading and accessible name.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        head: line with the heading; buttons are at its end.
        said: sentence beside the heading.
        body: layout below the heading.
        has_window: whether it has a window of its own.
    """

    fill_wanted = pyqtSignal(object)
    """This card shall fill its column, or no longer."""
    window_wanted = pyqtSignal(object)
    """This card shall have a window of its own, or go back from it."""

    def __init__(self, title: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        with_class(self, "card")
        self.setAccessibleName(title)
        set_card_help(self, title)
        self.said = CutToneLabel()
        self._fills = self.has_window = False
        places = menu_button("⤢", f"Larger: {title}", self._fill_place_menu)
        with_class(places, "quiet small")
        self.head = hbox(label(title, "heading"), (self.said, 1), spacing=CARD_SPACING_PX)
        row = hbox((self.head, 1), places, spacing=CARD_SPACING_PX)
        self.body = vbox(row, of=self, margins=(9, 5, 9, 8), spacing=CARD_SPACING_PX)

    def set_seen(self, seen: bool) -> None:
        """Ask and draw only while the card is visible."""

    def set_filling(self, fills: bool) -> None:
        """Show whether it fills its column."""
        self._fills = fills

    def mouseDoubleClickEvent(self, event: QMouseEvent | None) -> None:
        """Fill the column, or no longer, after a double click on the heading."""
        if event is not None and event.position().y() <= self.head.geometry().bottom():
            self.fill_wanted.emit(self)

    def _fill_place_menu(self, menu: QMenu) -> None:
        """Offer the column and the window."""
        for text, wanted, on in (  # the keys are those of the screen's actions
            (f"&Fill the column\t{CARD_FILL_SHORTCUT}", self.fill_wanted, self._fills),
            (f"&Window of its own\t{CARD_WINDOW_SHORTCUT}", self.window_wanted, self.has_window),
        ):
            action = add_action(menu, text, lambda _, wanted=wanted: wanted.emit(self), on)
            action.setEnabled(on or not self.has_window)


class ToneLabel(WrappedLabel):
    """A sentence, coloured by its tone, with room for two lines."""

    def __init__(self, tone: str = "muted") -> None:
        super().__init__(lines=SENTENCE_LINES)
        self.setProperty("class", tone)

    def say(self, text: str, tone: str = "muted") -> None:
        """Show a sentence as muted, good, warning or bad."""
        set_class(self, tone)
        self.setText(text)


class CutToneLabel(ToneLabel):
    """One that never has more than two lines: the tool tip has the whole of a longer sentence."""

    def __init__(self) -> None:
        self._whole = ""
        super().__init__()

    def setText(self, text: str | None) -> None:
        """Show another sentence."""
        self._whole = plain_text(text or "")
        self._cut()

    def text(self) -> str:
        """Return the whole sentence."""
        return self._whole

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Cut the sentence at another width."""
        super().resizeEvent(event)
        self._cut()

    def changeEvent(self, event: QEvent | None) -> None:
        """Cut the sentence in another font, as that of a style."""
        super().changeEvent(event)
        if event is not None and event.type() == QEvent.Type.FontChange:
            self._cut()

    def _cut(self) -> None:
        """Show as many characters as fit."""
        shown = self._whole
        if not self._fits(shown):
            fitting = range(len(shown))
            kept = bisect_left(fitting, True, key=lambda count: not self._fits(shown[:count] + "…"))
            shown = f"{shown[: max(0, kept - 1)].rstrip()}…"
        is_cut = shown != self._whole
        set_tip(self, self._whole if is_cut else "")
        self.setAccessibleName(self._whole if is_cut else "")
        if shown != super().text():
            super().setText(shown)

    def _fits(self, text: str) -> bool:
        metrics, wraps = self.fontMetrics(), Qt.TextFlag.TextWordWrap
        height = metrics.boundingRect(0, 0, self.width(), MAX_TEXT_HEIGHT_PX, wraps, text).height()
        return height <= metrics.size(0, "\n".join(["Ag"] * SENTENCE_LINES)).height()


def wrapped_label(tone: str = "muted") -> Label:
    """Return a label with wrapped text."""
    return label(kind=tone, wraps=True)


def fields_beside(
    fields: Sequence[tuple[str, QWidget]],
    widths: Sequence[int] | int = 78,
    *,
    of: QWidget | None = None,
    gap: int = CARD_SPACING_PX,
) -> QGridLayout:
    """Return fields side by side, each below its label.

    Args:
        fields: text of the label, and the field.
        widths: least widths of the fields, or the same for all [px]; wider ones get more space.
        of: widget that gets the layout, None for a nested layout.
        gap: between a label and its field [px].
    """
    shares = [widths] * len(fields) if isinstance(widths, int) else widths
    for (_, field), width in zip(fields, shares, strict=True):
        field.setMinimumWidth(width)
    return grid(
        [buddy(text, field) for text, field in fields],
        [field for _, field in fields],
        of=of,
        margins=NO_MARGINS,
        spacing=(CARD_SPACING_PX, gap),
        stretches=shares,
    )


def set_items(box: QComboBox, texts: Mapping[str, str], first: str | None = None) -> bool:
    """Set the items of a box, without a signal; return whether they differ from the present ones.

    Args:
        box: the box, which keeps its selection if possible.
        texts: texts of the items, by their data.
        first: default selection; the first item if it is not among them.
    """
    if [*texts] == [box.itemData(index) for index in range(box.count())]:
        return False
    chosen = box.currentData()
    with QSignalBlocker(box):
        box.clear()
        for data, text in texts.items():
            box.addItem(plain_name(text), data)
        box.setCurrentIndex(max(0, box.findData(chosen if chosen in texts else first)))
    return True
