"""The list of changes of a loaded gain file, until the user takes or dismisses it."""

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QCheckBox, QFrame, QWidget

from workbench.common.plain_text import plain_name
from workbench.gains.gain_change import GainChange
from workbench.gui.gains.gain_file_diff import GainFileDiff, percent_text
from workbench.gui.gains.gain_files import GainFiles
from workbench.gui.labels import set_tip
from workbench.gui.layout import button, grid, hbox, label, scroll_area, vbox
from workbench.gui.preferences import Preferences
from workbench.gui.units import gain_text, unit_for

MIN_DIFF_LIST_HEIGHT_PX = 70
"""Least height of the list, of three lines [px]."""
MAX_DIFF_LIST_HEIGHT_PX = 240
"""Largest height of the list; longer ones scroll [px]."""


class GainFileDiffView(QFrame):
    """Shows a loaded gain file until the user takes some of it, or dismisses it.

    Args:
        gain_files: compares gain files.
        preferences: units.

    Attributes:
        ticks: tick boxes of the lines, by the parameter's name.
    """

    def __init__(self, gain_files: GainFiles, preferences: Preferences) -> None:
        super().__init__()
        self._gain_files, self._preferences = gain_files, preferences
        self.ticks: dict[str, QCheckBox] = {}
        self.setProperty("class", "card")
        self.said = label(wraps=True)
        self._area = scroll_area(sideways=False)
        self.fly = button("", self._take, "primary")
        self.none = button("&Tick none", self._tick_others)
        self.back = button("Take &nothing", gain_files.dismiss)
        buttons = hbox(self.none, 0, self.back, self.fly, spacing=6)
        vbox(self.said, self._area, buttons, of=self, margins=(8, 6, 8, 6), spacing=5)
        gain_files.diff_changed.connect(self._show)
        self.hide()

    def _show(self, diff: GainFileDiff | None) -> None:
        if diff is None:
            self.hide()
            return
        origin = f": {diff.origin}" if diff.origin else ""
        differ = "differs" if len(diff.changes) == 1 else "differ"
        said = f"{len(diff.changes)} of {plain_name(diff.name)} {differ}{origin}"
        self.said.setText(said.replace("^2", "²"))
        content = QWidget()
        self.ticks = {}
        rows = map(self._make_row, diff.changes)
        grid(*rows, of=content, margins=(0, 0, 4, 0), spacing=(10, 2), stretches=(1,))
        self._area.setWidget(content)
        wanted = content.sizeHint().height() + 2
        self._area.setMinimumHeight(min(MIN_DIFF_LIST_HEIGHT_PX, wanted))
        self._area.setMaximumHeight(min(MAX_DIFF_LIST_HEIGHT_PX, wanted))
        self._count()
        self.show()
        self.fly.setFocus()

    def _make_row(self, change: GainChange) -> list[QWidget]:
        words = self._gain_files.words(change.name)
        unit = unit_for(change.unit, self._preferences)
        a, b = (gain_text(unit.shown(value)) for value in (change.a, change.b))
        tick = QCheckBox(words)
        refused = self._gain_files.diff.refused if self._gain_files.diff else None
        tick.setChecked(refused is None or change.name in refused)
        set_tip(tick, change.name)
        tick.setAccessibleName(f"{words}: {a} becomes {b} {unit.symbol}")
        tick.toggled.connect(self._count)
        self.ticks[change.name] = tick
        right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        row: list[QWidget] = [tick]
        for text in (a, "→", b, unit.symbol, percent_text(change)):
            part = label(text, "muted" if text in ("→", unit.symbol) else "")
            part.setAlignment(Qt.AlignmentFlag.AlignVCenter if text == unit.symbol else right)
            row.append(part)
        return row

    def _count(self) -> None:
        """Show the number of ticked lines."""
        ticked = sum(tick.isChecked() for tick in self.ticks.values())
        diff = self._gain_files.diff
        writes = diff is not None and diff.target is not None
        self.fly.setText(f"{'&Write' if writes else '&Fly'} {ticked} ticked")
        if diff is not None and diff.refused == set(self._ticked()):
            self.fly.setText(f"&Write {ticked} anyway")
        self.fly.setEnabled(ticked > 0)
        self.none.setText("&Tick none" if ticked else "&Tick all")

    def _tick_others(self) -> None:
        """Tick no line, or all if none is ticked."""
        some = any(tick.isChecked() for tick in self.ticks.values())
        for tick in self.ticks.values():
            tick.setChecked(not some)

    def _take(self) -> None:
        self._gain_files.take(self._ticked())

    def _ticked(self) -> list[str]:
        return [name for name, tick in self.ticks.items() if tick.isChecked()]
