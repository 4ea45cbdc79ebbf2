"""The line over a chart: its name, its curves, and what can be done."""

from PyQt6.QtCore import QPoint, pyqtSignal
from PyQt6.QtGui import QResizeEvent
from PyQt6.QtWidgets import QVBoxLayout, QWidget

from workbench.gui.charts.head_button import HeadButton, Sign
from workbench.gui.charts.legend import Legend
from workbench.gui.theme import Look


class ChartHead(QWidget):
    """Title and legend, and two buttons in the corner.

    Args:
        look: colours.
        parent: whose life it shares.

    Attributes:
        legend: name of the chart and of its curves.
        pause: lets the picture stand still.
        more: opens the menu.
    """

    menu_wanted = pyqtSignal(QPoint)
    """The menu is to open at this place of the screen."""

    def __init__(self, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.legend = Legend(look)
        self.pause = HeadButton(
            look, Sign.PAUSE, "Pause", "Pause the picture; the flight goes on (Space)", self
        )
        self.pause.setCheckable(True)
        self.more = HeadButton(look, Sign.MENU, "Menu", "What this chart can do", self)
        self.more.clicked.connect(self.open_menu)
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.addWidget(self.legend)
        self._place()

    @property
    def title(self) -> str:
        """Name of the chart."""
        return self.legend.title

    def set_title(self, title: str) -> None:
        """Give the chart a name, "" for none."""
        self.legend.set_title(title)

    def hide_pause(self) -> None:
        """Offer no pause, as nothing moves."""
        self.pause.hide()
        self._place()

    def open_menu(self) -> None:
        """Ask for the menu."""
        self.menu_wanted.emit(self.more.mapToGlobal(self.more.rect().bottomLeft()))

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Keep the buttons in their corner."""
        self._place()

    def _place(self) -> None:
        right = self.width()
        for button in (self.more, self.pause):
            if not button.isHidden():
                button.resize(button.sizeHint())
                right -= button.width()
                button.move(right, 0)
                button.raise_()
        self.legend.keep_free(self.width() - right + 8.0)
