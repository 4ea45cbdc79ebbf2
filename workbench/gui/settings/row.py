"""A line of the Settings screen: a label, a control that it belongs to, and what it does."""

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QSizePolicy, QVBoxLayout, QWidget


class Row(QWidget):
    """One setting.

    Args:
        label: in words; the control's accessible name, too.
        help: what it does, a sentence.
        control: with which it is set.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        reset: puts the default back.
    """

    def __init__(
        self, label: str, help: str, control: QWidget, parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self._words = f"{label} {help}".lower()
        self._label, self._help = QLabel(label, self), QLabel(help, self)
        self._mark = QLabel("", self)
        self.reset = QPushButton("Default", self)
        self._label.setBuddy(control)
        self._help.setWordWrap(True)
        self._help.setProperty("class", "muted")
        if not control.accessibleName():
            control.setAccessibleName(label)
        control.setAccessibleDescription(help)
        control.setToolTip(help)
        control.setMinimumWidth(190)
        self.reset.setAccessibleName(f"{label}: put the default back")
        words = QVBoxLayout()
        words.setSpacing(1)
        words.addWidget(self._label)
        words.addWidget(self._help)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 4, 0, 4)
        layout.setSpacing(12)
        layout.addLayout(words, 1)
        for part in (self._mark, control, self.reset):
            layout.addWidget(part, 0, Qt.AlignmentFlag.AlignVCenter)
        self._mark.setFixedWidth(self.fontMetrics().horizontalAdvance("changed  "))
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)

    def mark(self, changed: bool) -> None:
        """Say whether it is not as by default."""
        self._mark.setText("changed" if changed else "")
        self.reset.setEnabled(changed)

    def matches(self, wanted: str) -> bool:
        """Return whether all words that are looked for stand in it."""
        return all(word in self._words for word in wanted.lower().split())
