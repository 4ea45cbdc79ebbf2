"""How long the drone can fly on."""

from PyQt6.QtCore import QRectF
from PyQt6.QtWidgets import QWidget

from workbench.gui.home.card import Card, put
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.home.stream_watch import StreamWatch
from workbench.gui.instruments.charge_bar import ChargeBar
from workbench.gui.instruments.sign import Sign
from workbench.gui.theme import Look
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot


class BatteryCard(Card):
    """The charge, and the reserve at which it lands by itself."""

    name = "battery"
    title = "Battery"

    def __init__(
        self, look: Look, units: ShownUnits, watch: StreamWatch, parent: QWidget | None = None
    ) -> None:
        super().__init__(look, units, parent)
        self._watch = watch
        self.bar = ChargeBar(look, self)
        self.parts = [self.bar]

    @property
    def spoken(self) -> str:
        """All of it as a sentence."""
        return self.bar.spoken

    def place_parts(self, body: QRectF) -> None:
        """Let the bar fill it."""
        put(self.bar, body)

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the charge."""
        reserve = self._watch.value("battery_reserve")
        self.bar.show_charge(now.charge, reserve)
        word = self.bar.word
        signs = {"good": Sign.GOOD, "low": Sign.WARNING}
        self.set_note(
            f"{word}, reserve {100 * reserve:.0f}\N{NO-BREAK SPACE}%", signs.get(word, Sign.BAD)
        )
