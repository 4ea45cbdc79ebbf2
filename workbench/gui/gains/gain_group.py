"""Lines under a heading that opens and closes."""

from collections.abc import Sequence

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QSizePolicy, QToolButton, QVBoxLayout, QWidget

GAP = 1
"""Between lines [px]."""


class GainGroup(QWidget):
    """A heading and what stands under it; empty lines are not shown.

    Args:
        title: the heading.
        is_open: whether it is open at first.
        parent: owner.

    Attributes:
        heading: opens and closes.
    """

    def __init__(self, title: str, is_open: bool, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.heading = QToolButton(self)
        self.heading.setText(title)
        self.heading.setAccessibleName(f"{title}, show or hide")
        self.heading.setProperty("class", "quiet compact heading")
        self.heading.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.heading.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.heading.setCheckable(False)
        self.heading.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.heading.clicked.connect(lambda: self.set_open(not self.is_open))
        self._body = QWidget(self)
        self._lines = QVBoxLayout(self._body)
        self._lines.setContentsMargins(4, 0, 0, 2)
        self._lines.setSpacing(GAP)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.heading)
        layout.addWidget(self._body)
        self.is_open = is_open
        self._searched: set[QWidget] | None = None
        self._left_out: set[QWidget] = set()
        self.set_open(is_open)

    def add(self, lines: Sequence[QWidget]) -> None:
        """Let lines stand at the end."""
        for line in lines:
            self._lines.addWidget(line)

    def set_open(self, is_open: bool) -> None:
        """Show the lines, or the heading alone."""
        self.is_open = is_open
        self._show()

    def search(self, found: set[QWidget] | None) -> None:
        """Show those lines that were found, open or not; None for no search."""
        self._searched = found
        self._show()

    def leave_out(self, lines: set[QWidget]) -> None:
        """Show these lines in no case."""
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
        """Show those lines; return whether there are any."""
        shown = False
        for index in range(self._lines.count()):
            item = self._lines.itemAt(index)
            line = item.widget() if item else None
            if line is not None:
                seen = line not in self._left_out and (found is None or line in found)
                line.setVisible(seen)
                shown = shown or seen
        return shown
