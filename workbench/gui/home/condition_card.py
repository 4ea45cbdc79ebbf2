"""The card of the flight mode and the wind."""

import math
from collections.abc import Mapping
from typing import Any

from workbench.control.mode import FlightMode, Reason
from workbench.gui.home.home_card import HomeCard
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.icons import MODE_ICONS, picture
from workbench.gui.instruments.heading import compass_point, direction_of
from workbench.gui.instruments.instrument import Sign
from workbench.gui.labels import Label
from workbench.gui.layout import fill, hbox, label
from workbench.live.messages import Phase
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot

PHASE_NOTES: Mapping[Phase, tuple[str, Sign]] = {
    Phase.PAUSED: ("paused", Sign.WARNING),
    Phase.BROKEN: ("broken: reset to fly again", Sign.BAD),
    Phase.ENDED: ("ended: open a scenario", Sign.BAD),
}
"""Text for a flight that does not advance."""
AUTOPILOT_ENDED_NOTE = ("held: reset to fly again", Sign.BAD)
"""Text for a flight whose autopilot has ended."""
CALM_WIND_M_S = 0.05
"""A slower wind counts as calm [m/s]."""


def wind_text(wind: tuple[float, float, float], units: ShownUnits) -> str:
    """Return a wind in words: its speed, and the direction that it comes from.

    Args:
        wind: velocity of the air in W [m/s].
        units: units of the text.
    """
    if not all(map(math.isfinite, wind)):
        return "wind –"
    east, north, up = wind
    level = math.hypot(east, north)
    parts = []
    if level >= CALM_WIND_M_S:
        source = direction_of(-east, -north)
        said = units.speed.text(level)
        parts.append(f"wind {said} from {source:03.0f}° ({compass_point(source)})")
    if abs(up) >= CALM_WIND_M_S:
        said = units.speed.text(abs(up))
        parts.append(f"{'up' if up > 0.0 else 'down'} {said}")
    return ", ".join(parts) or "no wind"


class ConditionCard(HomeCard):
    """The flight mode, large."""

    name = "condition"
    title = "Flight condition"

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.mode: FlightMode | None = None
        self._shape, self._word = Label(), self.scaled(label(), 1.6, bold=True)
        self._facts = label("", "muted", wraps=True)
        fill(self.body, 1, hbox(self._shape, (self._word, 1), spacing=8), self._facts, 1)
        self.look.changed.connect(self._draw)

    @property
    def spoken(self) -> str:
        """The state as a sentence."""
        return f"{self.mode.label if self.mode is not None else ''}, {self._facts.text()}"

    def show_absence(self, text: str) -> None:
        """Show why there is no flight yet, if there is none."""
        if text and self.mode is None:
            self._facts.setText(text)

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show mode, rotors and wind."""
        ended = now.reason is Reason.AUTOPILOT_ENDED
        rotors = "rotors off" if ended or now.mode is FlightMode.OFF else "rotors on"
        self.set_note(*PHASE_NOTES.get(view.phase, AUTOPILOT_ENDED_NOTE if ended else ("", None)))
        facts = f"{rotors} · {wind_text(now.wind, self.units)}"
        if now.reason.label:
            facts = f"{now.reason.label} · {facts}"
        self._facts.setText(facts)
        if now.mode is not self.mode:
            self.mode = now.mode
            self._draw()

    def set_text_size(self, size: float) -> None:
        """Set the size of the picture, too."""
        super().set_text_size(size)
        self._draw()

    def _draw(self) -> None:
        if self.mode is not None:
            size, ratio = 1.7 * self.text_size, self.devicePixelRatioF()
            colour = self.look.colour("accent")
            self._shape.setPixmap(picture(MODE_ICONS[self.mode], colour, size, ratio))
            self._word.setText(self.mode.label.capitalize())
