"""A few words with a shape before them."""

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QHBoxLayout, QLabel, QSizePolicy, QWidget

from workbench.gui.icons import picture
from workbench.gui.style import set_class
from workbench.gui.theme import Look
from workbench.gui.top_bar.wording import PLAIN, Said

ICON = 16


class Chip(QWidget):
    """Shows what was said; it changes only where that changes.

    Args:
        name: of what it tells, for those who hear it.
        look: colours.
        characters: of the longest usual text, so that neighbours stand still.
        parent: in which it stands.
    """

    def __init__(
        self, name: str, look: Look, characters: int = 0, parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self._name, self._look = name, look
        self._said: Said | None = None
        self._shape = QLabel()
        self._text = QLabel()
        self._text.setTextFormat(Qt.TextFormat.PlainText)
        self._text.setMinimumWidth(characters * self._text.fontMetrics().horizontalAdvance("0"))
        self.setSizePolicy(QSizePolicy.Policy.Maximum, QSizePolicy.Policy.Preferred)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(5)
        layout.addWidget(self._shape)
        layout.addWidget(self._text)
        look.changed.connect(self._draw)

    @property
    def text(self) -> str:
        """What is shown."""
        return self._text.text()

    def show_said(self, said: Said) -> None:
        """Show other words."""
        before, self._said = self._said, said
        if said == before:
            return
        if before is None or said.text != before.text:
            self._text.setText(said.text)
        if before is None or (said.icon, said.tone) != (before.icon, before.tone):
            self._draw()
        full = said.full or said.text
        self.setToolTip(f"{self._name}: {full}")
        self.setAccessibleName(f"{self._name}: {full}")

    def _draw(self) -> None:
        if self._said is None:
            return
        tone = self._said.tone
        set_class(self._text, tone)
        colour = self._look.colour(tone if tone != PLAIN else "ink")
        self._shape.setPixmap(picture(self._said.icon, colour, ICON, self.devicePixelRatioF()))
