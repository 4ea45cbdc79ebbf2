"""The card of the battery: its charge, and the reserve at which the drone lands by itself."""

import math

from PyQt6.QtWidgets import QProgressBar, QWidget

from workbench.gui.home.home_card import HomeCard
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.home.stream_watch import StreamWatch
from workbench.gui.instruments.instrument import Sign
from workbench.gui.layout import fill, hbox, label, named
from workbench.gui.style import set_class
from workbench.gui.theme import Look
from workbench.gui.units import SHARE_UNIT
from workbench.live.announcer import LOW_CHARGE_MARGIN
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot


def charge_word(charge: float, reserve: float) -> str:
    """Return a charge 0 .. 1 as a word: empty, at the reserve, low, or good."""
    if math.isnan(charge):
        return "unknown"
    if charge <= 0.0:
        return "empty"
    if charge <= reserve:
        return "reserve: lands"
    return "low" if charge <= reserve + LOW_CHARGE_MARGIN else "good"


class BatteryCard(HomeCard):
    """The charge as a bar and in per cent, and the reserve at which it lands by itself."""

    name = "battery"
    title = "Battery"

    def __init__(
        self, look: Look, units: ShownUnits, watch: StreamWatch, parent: QWidget | None = None
    ) -> None:
        super().__init__(look, units, parent)
        self._watch = watch
        self.bar = named(QProgressBar(), "Battery")
        self.bar.setTextVisible(False)
        self.bar.setRange(0, 1000)
        self._percent = self.scaled(label("–"), 1.5, bold=True)
        fill(self.body, (hbox((self.bar, 1), self._percent), 1))

    @property
    def text(self) -> str:
        """The charge in per cent, as text."""
        return self._percent.text()

    @property
    def spoken(self) -> str:
        """The charge as a sentence."""
        return f"{self.text}, {self.note}"

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the charge."""
        charge, reserve = now.charge, self._watch.value("battery_reserve")
        word = charge_word(charge, reserve)
        known = not math.isnan(charge)
        self.bar.setValue(round(1000 * min(1.0, max(0.0, charge))) if known else 0)
        self._percent.setText(SHARE_UNIT.text(charge))
        sign = {"good": Sign.GOOD, "low": Sign.WARNING}.get(word, Sign.BAD)
        set_class(self.bar, sign.value)
        self.set_note(f"{word}, reserve {SHARE_UNIT.text(reserve)}", sign)
