"""Names of a chart's curves and their values, now or at the cursor."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from PyQt6.QtCore import QEvent, Qt, pyqtSignal
from PyQt6.QtGui import QColor, QResizeEvent
from PyQt6.QtWidgets import QLabel, QSizePolicy

from workbench.common.plain_text import html_text, plain_name
from workbench.gui.charts.curve import CurveStyle, make_pen
from workbench.gui.theme import Look

NO_BREAK_SPACE = "\N{NO-BREAK SPACE}"
WORD_JOINER = "\N{WORD JOINER}"


@dataclass(frozen=True)
class LegendEntry:
    """A curve in the legend.

    Attributes:
        label: name of the curve.
        value: its value as text with its unit, "" for none.
        colour: colour of the curve.
        style: line style of the curve.
        number: number at its end in the chart, 0 for none.
        visible: whether it is drawn.
    """

    label: str
    value: str
    colour: QColor
    style: CurveStyle
    number: int
    visible: bool


class Legend(QLabel):
    """A line of text, wrapped where necessary; a click on a name hides or shows its curve.

    Args:
        look: source of colours.

    Attributes:
        title: name of the chart.
        entries: the shown entries.
    """

    toggled = pyqtSignal(int)
    """Index of the entry that was clicked."""
    entries_changed = pyqtSignal()
    """`entries` changed: curves, their numbers or values."""

    def __init__(self, look: Look) -> None:
        super().__init__()
        self._look = look
        self.entries: tuple[LegendEntry, ...] = ()
        self._names: list[LegendEntry] = []
        self._widths: list[int] = []
        self.title = ""
        self.setTextFormat(Qt.TextFormat.RichText)
        self.setWordWrap(True)
        self.setTextInteractionFlags(Qt.TextInteractionFlag.LinksAccessibleByMouse)
        self.setAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignTop)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Minimum)
        self.setMinimumWidth(80)
        self.linkActivated.connect(lambda link: self.toggled.emit(int(link)))
        look.changed.connect(self._write)

    def set_title(self, title: str) -> None:
        """Set the title before the names, "" for none."""
        self.title = title
        self._write()
        self._fit()

    def show_entries(self, entries: Sequence[LegendEntry]) -> None:
        """Show entries; the text is written only if it has changed."""
        if tuple(entries) == self.entries:
            return
        same = [replace(each, value="") for each in entries] == self._names
        # Space that was once needed is kept: names do not jump as the number of digits varies.
        kept = self._widths if same else [0 for _ in entries]
        found = [self.fontMetrics().horizontalAdvance(each.value) for each in entries]
        widths = [max(pair) for pair in zip(found, kept, strict=True)]
        fits = same and widths == kept
        self.entries, self._widths = tuple(entries), widths
        self._names = [replace(each, value="") for each in entries]
        self._write()
        if not fits:
            self._fit()
        self.entries_changed.emit()

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Adapt the number of lines to the width."""
        super().resizeEvent(event)
        self._fit()

    def changeEvent(self, event: QEvent | None) -> None:
        """Adapt to another font."""
        super().changeEvent(event)
        if event is not None and event.type() == QEvent.Type.FontChange:
            self._fit()

    def _write(self) -> None:
        parts = [f"<b>{_no_break_html(self.title)}</b>"] if self.title else []
        parts += [
            self._html(index, each, width)
            for index, (each, width) in enumerate(zip(self.entries, self._widths, strict=True))
        ]
        self.setText(f"{2 * NO_BREAK_SPACE} ".join(parts))

    def _html(self, index: int, entry: LegendEntry, width: int) -> str:
        colour = self._look.colours
        pen = make_pen(entry.colour, entry.style, self._look.colour("card"))
        dash = {CurveStyle.DASHED: "╍╍", CurveStyle.POINTS: "••"}.get(entry.style, "━━")
        number = f"{NO_BREAK_SPACE}{entry.number}" if entry.number else ""
        stroke = f"<b style='color:{pen.color().name()}'>{dash}{number}</b>{NO_BREAK_SPACE}"
        label = _no_break_html(entry.label)
        if not entry.visible:
            stroke, label = "", f"{label}{NO_BREAK_SPACE}(hidden)"
        ink = colour.ink if entry.visible else colour.muted
        link = f"<a href='{index}' style='color:{ink};text-decoration:none'>{stroke}{label}</a>"
        if not entry.visible or not entry.value:
            return link
        metrics = self.fontMetrics()
        free = width - metrics.horizontalAdvance(entry.value)
        room = NO_BREAK_SPACE * (
            1 + round(free / max(1, metrics.horizontalAdvance(NO_BREAK_SPACE)))
        )
        return (
            f"{link}{room}<span style='color:{colour.muted}'>{_no_break_html(entry.value)}</span>"
        )

    def _fit(self) -> None:
        """Set the text's height at this width: a layout alone would squeeze it."""
        self.setMinimumHeight(0)  # a label never needs less than its minimum height
        height = max(0, self.heightForWidth(self.width()))
        self.setMinimumHeight(height)


def _no_break_html(text: str) -> str:
    """Return text without line breaks in it, as HTML."""
    joined = html_text(plain_name(text)).replace("/", f"{WORD_JOINER}/{WORD_JOINER}")  # as in m/s
    return joined.replace(" ", NO_BREAK_SPACE)
