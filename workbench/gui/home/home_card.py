"""The base class of the Home screen's cards: a frame with a title, a note and parts below."""

from collections.abc import Sequence

from PyQt6.QtGui import QFont
from PyQt6.QtWidgets import QFrame, QWidget

from workbench.gui.help import set_card_help
from workbench.gui.home.sensor_state import SensorState
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.instruments.instrument import DEFAULT_TEXT_HEIGHT_PX, SIGN_SHAPES, Sign
from workbench.gui.instruments.readout import WIDEST_READOUT_NUMBERS, Hint, Readout, ReadoutLine
from workbench.gui.labels import Label, WrappedLabel
from workbench.gui.layout import hbox, label, vbox
from workbench.gui.style import set_class, with_class
from workbench.gui.theme import Look
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot

CARD_PADDING_EM = 0.6
"""Padding inside the frame, relative to plain text."""


class HomeCard(QFrame):
    """A framed group of related instruments.

    Attributes:
        name: name in the layouts of the Home screen.
        title: title at the top.
        sensors: kinds of sensors whose readings it shows.
        parts: contained instruments.
        look: source of colours.
        units: units of the numbers.
        text_size: height of plain text [px].
        state: label of the note beside the title.
        note: its text.
        sign: the state that its shape shows, None without one.
        body: layout of the title and all that is below.
    """

    name = ""
    title = ""
    sensors: tuple[str, ...] = ()

    def __init__(self, look: Look, units: ShownUnits, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        with_class(self, "card")
        self.setAccessibleName(self.title)
        set_card_help(self, self.title)
        self.look, self.units = look, units
        self.text_size = DEFAULT_TEXT_HEIGHT_PX
        self.parts: list[Readout | Hint] = []
        self._scaled: list[tuple[Label, float, bool]] = []
        self._table: Readout | None = None
        self.note = ""
        self.sign: Sign | None = None
        self.state = label(kind="muted")
        self.heading = self.scaled(with_class(WrappedLabel(self.title), "muted"), 1.0, bold=True)
        self._head = hbox((self.heading, 1), self.state, spacing=6)
        self.body = vbox(self._head, of=self)

    @property
    def spoken(self) -> str:
        """The content as a sentence, for a screen reader."""
        return "; ".join(part.spoken for part in self.parts if part.isVisibleTo(self))

    def begin(self, view: LiveView) -> None:
        """A flight begins."""

    def show_dials(self, view: LiveView, now: Snapshot) -> None:
        """Update smoothly moving parts; called for every view."""

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Update numbers; called ten times a second."""

    def lines(self, units: ShownUnits) -> Sequence[ReadoutLine]:
        """Return the lines of the card's table, if it has one, in some units."""
        return ()

    def scaled(self, part: Label, factor: float, *, bold: bool = False) -> Label:
        """Return a label whose text has a size relative to plain text."""
        self._scaled.append((part, factor, bold))
        return part

    def put_in_head(self, part: QWidget) -> None:
        """Put a part behind the title."""
        self._head.insertWidget(1, part)

    def make_table(
        self,
        name: str,
        columns: Sequence[str] = (),
        widest: tuple[str, ...] = WIDEST_READOUT_NUMBERS,
    ) -> Readout:
        """Return a table of the card's `lines`, whose units follow; arguments as for `Readout`."""
        self._table = Readout(name, self.lines(self.units), columns, widest)
        return self._table

    def use_units(self, units: ShownUnits) -> None:
        """Show numbers in other units from now on."""
        self.units = units
        if self._table is not None:
            for index, line in enumerate(self.lines(units)):
                self._table.set_line(index, line)

    def set_note(self, note: str, sign: Sign | None = None) -> None:
        """Show a note beside the title, with a shape before it if it is a state."""
        if (note, sign) != (self.note, self.sign):
            self.note, self.sign = note, sign
            self.state.setText(f"{SIGN_SHAPES[sign]} {note}" if sign is not None else note)
            set_class(self.state, sign.value if sign is not None else "muted")

    def set_state(self, state: SensorState) -> None:
        """Show a sensor's state beside the title."""
        self.set_note(state.note, state.health.sign)

    def set_text_size(self, size: float) -> None:
        """Set the height of plain text [px]; other sizes and margins scale with it."""
        self.text_size = size
        font = QFont(self.font())
        font.setPixelSize(round(size))
        for part in (self, *self.findChildren(QWidget)):  # a style sheet stops inheritance
            part.setFont(font)
        for text, factor, bold in self._scaled:
            font = QFont(font)
            font.setPixelSize(round(factor * size))
            font.setBold(bold)
            text.setFont(font)
        pad = round(CARD_PADDING_EM * size)
        self.body.setContentsMargins(pad, pad // 2, pad, pad // 2)
        self.body.setSpacing(pad // 2)
