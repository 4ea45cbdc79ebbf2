"""The card of the local and the simulated time, and of the pace of the flight."""

import time
from typing import Any

from workbench.common.plain_text import plain_name
from workbench.gui.home.home_card import HomeCard
from workbench.gui.instruments.instrument import Sign
from workbench.gui.layout import fill, hbox, label, vbox
from workbench.gui.units import age_text, simulated_text
from workbench.live.messages import Phase
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot


class ClockCard(HomeCard):
    """The large clock, and the simulated time, each above its name."""

    name = "clock"
    title = "Clock"

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.heading.hide()
        self._wall = self.scaled(label(), 2.2, bold=True)
        self._simulated = self.scaled(label("–"), 1.65)
        self.state.setWordWrap(True)
        self.set_note("nothing flies yet", Sign.OFF)
        times = hbox(self._simulated, (label("simulated", "muted"), 1), spacing=6)
        left = vbox(1, self._wall, label("Local time", "muted"), 1, spacing=0)
        right = vbox(1, times, self.state, 1, spacing=2)
        fill(self.body, (hbox((left, 1), (right, 1)), 1))

    @property
    def wall(self) -> str:
        """The shown time of day."""
        return self._wall.text()

    @property
    def simulated(self) -> str:
        """The shown simulated time."""
        return self._simulated.text()

    @property
    def spoken(self) -> str:
        """The times as a sentence."""
        return f"local time {self.wall}, simulated time {self.simulated}, {self.note}"

    def set_text_size(self, size: float) -> None:
        """Set the text size; without a title, the times need no space below one."""
        super().set_text_size(size)
        self.body.setSpacing(0)
        self.state.setMinimumHeight(self.state.fontMetrics().height())  # one line is enough

    def show_wall(self) -> None:
        """Show the present time of day."""
        self._wall.setText(time.strftime("%H:%M:%S"))

    def show_silence(self, seconds: float) -> None:
        """Show that the flight has sent nothing for a time [s]."""
        self.set_note(f"no news for {age_text(seconds)}", Sign.WARNING)

    def show_phase(self, view: LiveView) -> None:
        """Show the state of the flight."""
        match view.phase:
            case Phase.STARTING:
                self.set_note(plain_name(view.said) or "starting", Sign.OFF)
            case Phase.PAUSED:
                self.set_note("paused", Sign.WARNING)
            case Phase.BROKEN:
                self.set_note("broken: last values", Sign.BAD)
            case Phase.ENDED:
                self.set_note("ended: last values", Sign.BAD)
            case Phase.FLYING:
                pace = view.pace
                if pace is None:
                    self.set_note("flying", Sign.GOOD)
                elif pace.too_slow:
                    self.set_note(f"too slow: {pace.text}", Sign.WARNING)
                else:
                    self.set_note(f"{pace.text} real time", Sign.GOOD)

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the simulated time; with milliseconds while it is paused."""
        self.show_phase(view)
        self._simulated.setText(simulated_text(now.time, paused=view.phase is not Phase.FLYING))
