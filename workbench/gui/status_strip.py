"""The line of short texts with icons that shows the state of the flight."""

from PyQt6.QtCore import QSize
from PyQt6.QtWidgets import QFrame, QSizePolicy, QWidget

from workbench.common.plain_text import plain_name
from workbench.gui.icons import picture
from workbench.gui.labels import Label, set_tip
from workbench.gui.layout import NO_MARGINS, hbox
from workbench.gui.status_text import (
    MUTED_TONE,
    PLAIN_TONE,
    StatusText,
    autopilot_status,
    battery_status_text,
    link_status,
    load_status,
    real_time_status,
    script_status,
    time_status,
    warnings_status,
)
from workbench.gui.style import set_class
from workbench.gui.theme import Look
from workbench.live.view import LiveView

CHIP_ICON_PX = 16
LOAD_WIDTH_DIGITS = 18
"""Width of the load's texts, in digits."""
SCRIPT_WIDTH_DIGITS = 14
"""Width of the script's shortest text, its time, in digits."""
WARNING_CHIPS = 2
"""Number of places for warnings."""


class Chip(QWidget):
    """Shows a short text; repainted only if the text changes.

    Args:
        name: name of the quantity, for screen readers.
        look: source of colours.
        characters: length of the longest usual text, so that neighbours do not move.
        shrinks: whether it gives way to neighbours, down to this length, where room is short.
    """

    def __init__(
        self, name: str, look: Look, characters: int = 0, *, shrinks: bool = False
    ) -> None:
        super().__init__()
        self._name, self._look, self._shrinks = name, look, shrinks
        self._said: StatusText | None = None
        self._shape = Label()
        self._text = Label()
        self.setSizePolicy(QSizePolicy.Policy.Maximum, QSizePolicy.Policy.Preferred)
        layout = hbox(self._shape, (self._text, 1), of=self, margins=NO_MARGINS, spacing=5)
        beside = CHIP_ICON_PX + layout.spacing()
        self._reserved = beside + characters * self.fontMetrics().horizontalAdvance("0")
        self._reserves = True
        look.changed.connect(self._draw)

    @property
    def text(self) -> str:
        """The shown text."""
        return self._text.text()

    def reserve(self, reserves: bool) -> None:
        """Reserve room for the longest usual text, or only for the present one."""
        self._reserves = reserves
        self.updateGeometry()

    def sizeHint(self) -> QSize:
        """Return the room for the present text, and for the longest usual one if reserved."""
        return super().sizeHint().expandedTo(QSize(self._reserved if self._reserves else 0, 0))

    def minimumSizeHint(self) -> QSize:
        """Return the same, so that no text is cut, unless it shrinks."""
        wanted = self.sizeHint()
        return QSize(self._reserved, wanted.height()) if self._shrinks else wanted

    def show_said(self, said: StatusText) -> None:
        """Show another text."""
        before, self._said = self._said, said
        if said == before:
            return
        self._text.setText(plain_name(said.text))
        if before is None or (said.icon, said.tone) != (before.icon, before.tone):
            self._draw()
        full = said.full or said.text
        set_tip(self, f"{self._name}: {full}")
        self.setAccessibleName(f"{self._name}: {full}")

    def _draw(self) -> None:
        if self._said is None:
            return
        tone = self._said.tone
        set_class(self._text, tone)
        colour = self._look.colour(tone if tone != PLAIN_TONE else "ink")
        self._shape.setPixmap(
            picture(self._said.icon, colour, CHIP_ICON_PX, self.devicePixelRatioF())
        )


class StatusStrip(QFrame):
    """A line of short texts with icons.

    Args:
        look: source of colours.
    """

    def __init__(self, look: Look) -> None:
        super().__init__()
        self.time = Chip("Simulated time", look, 7)
        self.battery = Chip("Battery", look, 5)
        self.reached = Chip("Speed", look, 20)
        self.link = Chip("Link", look)
        self.script = Chip("Script", look, SCRIPT_WIDTH_DIGITS, shrinks=True)
        self.script.hide()
        self.autopilot = Chip("Autopilot", look)
        self.autopilot.hide()
        self.load = Chip("Load", look, LOAD_WIDTH_DIGITS)
        self.load.hide()
        self.recording = Chip("Recording", look)
        self.recording.hide()
        self.opening = Chip("Opening", look)
        self.opening.hide()
        self.warnings = [Chip("Warning", look) for _ in range(WARNING_CHIPS)]
        hbox(
            self.time,
            self.battery,
            self.reached,
            self.link,
            self.script,
            self.autopilot,
            self.load,
            self.recording,
            self.opening,
            1,
            *self.warnings,
            of=self,
            margins=(20, 1, 12, 7),
            spacing=24,
        )
        self.setMinimumHeight(self.sizeHint().height())

    def show_opening(self, said: str) -> None:
        """Show the progress of starting another flight; "" when it is over."""
        self.opening.setVisible(bool(said))
        if said:
            full = f"another flight is being prepared: {said}; the present one continues until then"
            self.opening.show_said(StatusText(f"opening: {said}", "pace", MUTED_TONE, full))

    def show_view(self, view: LiveView) -> None:
        """Show a view."""
        self.time.show_said(time_status(view))
        self.battery.show_said(battery_status_text(view))
        self.reached.show_said(real_time_status(view))
        self.link.show_said(link_status(view))
        passing = (
            (self.script, script_status(view)),
            (self.autopilot, autopilot_status(view)),
            (self.load, load_status(view)),
        )
        for chip, state in passing:
            chip.setVisible(state is not None)
            if state is not None:
                chip.show_said(state)
        said = warnings_status(view)
        for at, chip in enumerate(self.warnings):
            chip.setVisible(at < len(said))
            if at < len(said):
                chip.show_said(said[at])
