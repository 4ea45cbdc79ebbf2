"""Wishes as lines: each completes what is typed, and says what is wrong with it."""

from collections.abc import Sequence

from PyQt6.QtCore import Qt, pyqtSignal
from PyQt6.QtWidgets import QCompleter, QLabel, QLineEdit, QVBoxLayout, QWidget

from workbench.control.controller import Controller, load_controller
from workbench.gui.style import dressed, set_class
from workbench.gui.tuning.card import wrapped
from workbench.gui.tuning.wish_text import completions, what_is_wrong, with_point

MOST = 6
"""Wishes that there is room for."""


class WishLine(QWidget):
    """One wish, and below it what is wrong with it."""

    changed = pyqtSignal()
    """Something else is typed."""

    def __init__(self, number: int, law: Controller) -> None:
        super().__init__()
        self._law = law
        self.field = QLineEdit()
        self.field.setAccessibleName(f"Wish {number}, as x.rise_time <= 0.4 s")
        self.field.setPlaceholderText("another wish, as x.rise_time <= 0.4 s")
        self.set_controller(law)
        self.fault = wrapped("bad")
        self.fault.setVisible(False)
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.setSpacing(1)
        box.addWidget(self.field)
        box.addWidget(self.fault)
        self.field.textChanged.connect(lambda _: self._check(typing=True))
        self.field.editingFinished.connect(lambda: self._check(typing=False))

    @property
    def text(self) -> str:
        """The wish, "" for none."""
        return with_point(self.field.text())

    @property
    def is_good(self) -> bool:
        """Whether nothing is seen to be wrong."""
        return not self.text or not what_is_wrong(self.text, self._law)

    def set_controller(self, law: Controller) -> None:
        """Take wishes about the loops of a controller."""
        self._law = law
        completer = QCompleter(list(completions(law)), self)
        completer.setFilterMode(Qt.MatchFlag.MatchContains)
        completer.setCaseSensitivity(Qt.CaseSensitivity.CaseInsensitive)
        self.field.setCompleter(completer)

    def blame(self, said: str) -> None:
        """Say what is wrong, "" for nothing."""
        self.fault.setText(f"✕ {said}" if said else "")
        self.fault.setVisible(bool(said))
        self.field.setAccessibleDescription(said)
        set_class(self.field, "bad" if said else "")

    def _check(self, *, typing: bool) -> None:
        """Say what is wrong once the line is left; take it back as soon as it is mended."""
        if self.is_good:
            self.blame("")
        elif not typing:
            self.blame(what_is_wrong(self.text, self._law))
        if typing:
            self.changed.emit()


class WishLines(QWidget):
    """Wishes below each other, always with an empty line for another one.

    Args:
        wishes: at first.
    """

    changed = pyqtSignal()
    """Something else is wished."""

    def __init__(self, wishes: Sequence[str]) -> None:
        super().__init__()
        self._law = load_controller()
        self._box = QVBoxLayout(self)
        self._box.setContentsMargins(0, 0, 0, 0)
        self._box.setSpacing(3)
        self.lines: list[WishLine] = []
        label = dressed(QLabel("&Wishes"), "muted")
        self._box.addWidget(label)
        for wish in wishes:
            self._add(wish)
        self._add("")
        label.setBuddy(self.lines[0].field)

    @property
    def wishes(self) -> tuple[str, ...]:
        """What is wished, without empty lines."""
        return tuple(line.text for line in self.lines if line.text)

    @property
    def are_good(self) -> bool:
        """Whether there is a wish, and nothing wrong with any."""
        return bool(self.wishes) and all(line.is_good for line in self.lines)

    def set_controller(self, law: Controller) -> None:
        """Take wishes about the loops of a controller; say which cannot be about it."""
        self._law = law
        for line in self.lines:
            line.set_controller(law)
            line.blame(what_is_wrong(line.text, law) if line.text else "")

    def _add(self, wish: str) -> None:
        line = WishLine(len(self.lines) + 1, self._law)
        line.field.setText(wish)
        line.changed.connect(self._grow)
        self.lines.append(line)
        self._box.addWidget(line)

    def _grow(self) -> None:
        if self.lines[-1].text and len(self.lines) < MOST:
            self._add("")
        self.changed.emit()
