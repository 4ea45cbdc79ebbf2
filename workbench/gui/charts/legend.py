"""Names of a chart's curves and their values, now or under the cursor."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from PyQt6.QtCore import QEvent, Qt, pyqtSignal
from PyQt6.QtGui import QColor, QResizeEvent
from PyQt6.QtWidgets import QLabel, QSizePolicy, QWidget

from workbench.gui.charts.curve import CurveStyle, make_pen
from workbench.gui.theme import Look

NO_BREAK = "\N{NO-BREAK SPACE}"
FIGURE_SPACE = "\N{FIGURE SPACE}"
"""As wide as a digit: names do not jump as digits come and go."""


@dataclass(frozen=True)
class Entry:
    """A curve in the legend.

    Attributes:
        label: of the curve.
        value: as text with its unit, "" for none.
        colour: of its stroke.
        style: of its stroke.
        number: at its end in the chart, 0 for none.
        visible: whether it is drawn.
    """

    label: str
    value: str
    colour: QColor
    style: CurveStyle
    number: int
    visible: bool


class Legend(QLabel):
    """A line of text, broken where it has to be; a click on a name hides or shows its curve.

    Args:
        look: colours.
        parent: whose life it shares.
    """

    toggled = pyqtSignal(int)
    """Index of the entry that was clicked."""

    def __init__(self, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._look = look
        self._entries: tuple[Entry, ...] = ()
        self._lengths: list[int] = []
        self._title = ""
        self.setTextFormat(Qt.TextFormat.RichText)
        self.setWordWrap(True)
        self.setTextInteractionFlags(Qt.TextInteractionFlag.LinksAccessibleByMouse)
        self.setAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignTop)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Minimum)
        self.setMinimumWidth(80)
        self.linkActivated.connect(lambda link: self.toggled.emit(int(link)))
        look.changed.connect(self._write)

    @property
    def entries(self) -> tuple[Entry, ...]:
        """What is shown."""
        return self._entries

    @property
    def title(self) -> str:
        """Name of the chart."""
        return self._title

    def set_title(self, title: str) -> None:
        """Begin with a name, "" for none."""
        self._title = title
        self._write()

    def show_entries(self, entries: Sequence[Entry]) -> None:
        """Show these; nothing is written where nothing has changed."""
        if tuple(entries) == self._entries:
            return
        if [each.label for each in entries] != [each.label for each in self._entries]:
            self._lengths = [0 for _ in entries]
        self._entries = tuple(entries)
        self._lengths = [
            max(length, len(each.value))
            for length, each in zip(self._lengths, entries, strict=True)
        ]
        self._write()

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Take the rows that are needed."""
        super().resizeEvent(event)
        self._fit()

    def changeEvent(self, event: QEvent | None) -> None:
        """Follow another font."""
        super().changeEvent(event)
        if event is not None and event.type() == QEvent.Type.FontChange:
            self._fit()

    def _write(self) -> None:
        parts = [f"<b>{_unbroken(self._title)}</b>"] if self._title else []
        parts += [
            self._html(index, each, length)
            for index, (each, length) in enumerate(zip(self._entries, self._lengths, strict=True))
        ]
        self.setText(f"{2 * NO_BREAK} ".join(parts))
        self._fit()

    def _html(self, index: int, entry: Entry, length: int) -> str:
        colour = self._look.colours
        pen = make_pen(entry.colour, entry.style, self._look.colour("card"))
        dash = "\N{EN DASH}" * 2 if entry.style is CurveStyle.DASHED else "\N{EM DASH}"
        number = f"{NO_BREAK}{entry.number}" if entry.number else ""
        stroke = f"<b style='color:{pen.color().name()}'>{dash}{number}</b>{NO_BREAK}"
        label = _unbroken(entry.label)
        if not entry.visible:
            stroke, label = "", f"{label}{NO_BREAK}(hidden)"
        ink = colour.ink if entry.visible else colour.muted
        link = f"<a href='{index}' style='color:{ink};text-decoration:none'>{stroke}{label}</a>"
        if not entry.visible or not entry.value:
            return link
        value = _unbroken(entry.value.rjust(length, FIGURE_SPACE))
        return f"{link}{NO_BREAK}<span style='color:{colour.muted}'>{value}</span>"

    def _fit(self) -> None:
        """Take the height that the text has at this width: a layout alone would squeeze it."""
        height = max(0, self.heightForWidth(self.width()))
        if height != self.minimumHeight():
            self.setMinimumHeight(height)


def _unbroken(text: str) -> str:
    """Return text in which no line is broken, as HTML."""
    return escape(text).replace(" ", NO_BREAK)
