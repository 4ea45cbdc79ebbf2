"""What a profile would change, line by line, with ticks; nothing of it flies before."""

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import (
    QCheckBox,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from workbench.gains.difference import GainChange
from workbench.gui.gains.gain_rows import gain_label
from workbench.gui.gains.profiles import GainProfiles, ProfileDiff, percent_text
from workbench.gui.preferences import Preferences
from workbench.gui.style import dressed
from workbench.gui.units import unit_for

TALLEST = 240
"""Of the list; longer ones scroll [px]."""


class ProfileDiffView(QFrame):
    """Shows a loaded profile until the user takes some of it, or nothing.

    Args:
        profiles: compares.
        preferences: units.
        parent: owner.

    Attributes:
        ticks: of the lines, by the parameter's name.
    """

    def __init__(
        self, profiles: GainProfiles, preferences: Preferences, parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self._profiles, self._preferences = profiles, preferences
        self.ticks: dict[str, QCheckBox] = {}
        self.setProperty("class", "card")
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Maximum)
        self.said = QLabel(self)
        self.said.setWordWrap(True)
        self._area = QScrollArea(self)
        self._area.setWidgetResizable(True)
        self._area.setFrameShape(QFrame.Shape.NoFrame)
        self._area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.fly = dressed(QPushButton(self), "primary")
        self.none = QPushButton("&Tick none", self)
        self.back = QPushButton("Take &nothing", self)
        self._lay_out()
        self.fly.clicked.connect(self._take)
        self.none.clicked.connect(self._tick_others)
        self.back.clicked.connect(profiles.dismiss)
        profiles.diff_changed.connect(self._show)
        self.hide()

    def _show(self, diff: ProfileDiff | None) -> None:
        if diff is None:
            self.hide()
            return
        origin = f": {diff.origin}" if diff.origin else ""
        self.said.setText(f"<b>{len(diff.changes)} of {diff.name} differ</b>{origin}")
        content = QWidget()
        grid = QGridLayout(content)
        grid.setContentsMargins(0, 0, 4, 0)
        grid.setHorizontalSpacing(10)
        grid.setVerticalSpacing(2)
        grid.setColumnStretch(0, 1)
        self.ticks = {}
        for line, change in enumerate(diff.changes):
            self._add_line(grid, line, change)
        self._area.setWidget(content)
        self._area.setFixedHeight(min(TALLEST, content.sizeHint().height() + 2))
        self._count()
        self.show()
        self.fly.setFocus()

    def _add_line(self, grid: QGridLayout, line: int, change: GainChange) -> None:
        label = gain_label(self._profiles.row(change.name))
        unit = unit_for(change.unit, self._preferences)
        a, b = (f"{unit.shown(value):.4g}" for value in (change.a, change.b))
        tick = QCheckBox(label.text)
        tick.setChecked(True)
        tick.setToolTip(change.name)
        tick.setAccessibleName(f"{label.text}: {a} becomes {b} {unit.symbol}")
        tick.toggled.connect(self._count)
        self.ticks[change.name] = tick
        grid.addWidget(tick, line, 0)
        right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        texts = (a, "→", b, unit.symbol, percent_text(change))
        for column, text in enumerate(texts, start=1):
            part = QLabel(text)
            part.setAlignment(Qt.AlignmentFlag.AlignVCenter if text == unit.symbol else right)
            if text in ("→", unit.symbol):
                part.setProperty("class", "muted")
            grid.addWidget(part, line, column)

    def _count(self) -> None:
        """Say how many are ticked."""
        ticked = sum(tick.isChecked() for tick in self.ticks.values())
        self.fly.setText(f"&Fly {ticked} ticked")
        self.fly.setEnabled(ticked > 0)
        self.none.setText("&Tick none" if ticked else "&Tick all")

    def _tick_others(self) -> None:
        """Tick none, or all where none is."""
        some = any(tick.isChecked() for tick in self.ticks.values())
        for tick in self.ticks.values():
            tick.setChecked(not some)

    def _take(self) -> None:
        self._profiles.take([name for name, tick in self.ticks.items() if tick.isChecked()])

    def _lay_out(self) -> None:
        buttons = QHBoxLayout()
        buttons.setSpacing(6)
        buttons.addWidget(self.none)
        buttons.addStretch()
        buttons.addWidget(self.back)
        buttons.addWidget(self.fly)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(8, 6, 8, 6)
        layout.setSpacing(5)
        layout.addWidget(self.said)
        layout.addWidget(self._area)
        layout.addLayout(buttons)
