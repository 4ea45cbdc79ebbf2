"""The Home screen: an overview of the flight, as cards in columns."""

import math
import time
from collections.abc import Callable

from PyQt6.QtCore import QSize, Qt, QTimer
from PyQt6.QtGui import QHideEvent, QResizeEvent, QShowEvent
from PyQt6.QtWidgets import QScrollArea, QWidget

from workbench.gui.home.attitude_card import AttitudeCard
from workbench.gui.home.battery_card import BatteryCard
from workbench.gui.home.card_plan import arrange_cards
from workbench.gui.home.clock_card import ClockCard
from workbench.gui.home.condition_card import ConditionCard
from workbench.gui.home.gps_card import GpsCard
from workbench.gui.home.height_card import HeightCard
from workbench.gui.home.home_card import HomeCard
from workbench.gui.home.imu_card import ImuCard
from workbench.gui.home.lidar_card import LidarCard
from workbench.gui.home.motion_card import MotionCard
from workbench.gui.home.rotor_card import RotorCard
from workbench.gui.home.route import Route
from workbench.gui.home.shown_units import shown_units
from workbench.gui.home.stream_watch import StreamWatch
from workbench.gui.instruments.instrument import DEFAULT_TEXT_HEIGHT_PX
from workbench.gui.layout import NO_MARGINS, SCROLL_BAR_WIDTH_PX, vbox
from workbench.gui.screens import Screen
from workbench.gui.sensor_offer import SensorOffer
from workbench.gui.workspace import Workspace
from workbench.live.messages import Phase
from workbench.live.view import LiveView

NUMBER_UPDATE_PERIOD_S = 0.1
"""Period between updates of a number: digits that change faster are illegible [s]."""
CLOCK_UPDATE_MS = 250
"""Period between updates of the wall clock [ms]."""
SILENT_FLIGHT_TIMEOUT_S = 1.0
"""Silence of a flying flight after which it is reported [s]."""
MIN_DESCRIPTION_PERIOD_S = 1.0
"""Least period between descriptions for a screen reader [s]."""


class HomeScreen(Screen):
    """Cards in two or three columns, depending on the size.

    Dials follow every view, numbers change ten times a second, and unchanged parts are not painted.

    Args:
        workspace: services that all screens share.
        clock: returns a monotonic time [s].

    Attributes:
        cards: by name.
        offers: buttons that switch on the sensors of a card, by its name.
    """

    def __init__(self, workspace: Workspace, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__(workspace)
        self._clock = clock
        self._watch = StreamWatch()
        self._last: LiveView | None = None
        self._heard = -math.inf
        self._spoken: dict[str, float] = {}
        self._scroll = QScrollArea(self)
        self._scroll.setFrameShape(QScrollArea.Shape.NoFrame)
        self._scroll.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._board = QWidget()
        self._scroll.setWidget(self._board)
        vbox(self._scroll, of=self, margins=NO_MARGINS)
        self._clock_card, self.cards = self._make_cards()
        self.offers: dict[str, SensorOffer] = {}
        for name, card in self.cards.items():
            if card.sensors:
                self.offers[name] = SensorOffer(workspace, *card.sensors, small=True)
                card.put_in_head(self.offers[name])
        self._numbers_due = -math.inf
        self._timer = QTimer(self)
        self._timer.setInterval(CLOCK_UPDATE_MS)
        self._timer.timeout.connect(self._tick)
        workspace.flight.streamed.connect(self._watch.hear)
        workspace.preferences.changed.connect(self._use_preference)
        workspace.look.changed.connect(self._colour)
        self._colour()

    def begin(self, view: LiveView) -> None:
        """Clear the last flight, and show the rotors and sensors of this one."""
        self._watch.begin(view)
        for part in (*self.cards.values(), *self.offers.values()):
            part.begin(view)
        self._numbers_due = -math.inf
        self.show_view(view)

    def show_view(self, view: LiveView) -> None:
        """Show a view."""
        now = self._clock()
        self._last, self._heard = view, now
        if view.snapshot is None:
            self._clock_card.show_phase(view)
            return
        for card in self.cards.values():
            card.show_dials(view, view.snapshot)
        if view.phase is not Phase.FLYING:  # while views are rare, show each one
            self._numbers_due = -math.inf
        if now >= self._numbers_due:
            self._numbers_due = max(self._numbers_due, now - 0.5 * NUMBER_UPDATE_PERIOD_S)
            self._numbers_due += NUMBER_UPDATE_PERIOD_S
            for name, card in self.cards.items():
                card.show_numbers(view, view.snapshot)
                self._speak(name, now)

    def sizeHint(self) -> QSize:
        """Return the size without scroll bars."""
        return QSize(1190, 600)

    def minimumSizeHint(self) -> QSize:
        """Return the least size; the screen then scrolls."""
        return QSize(360, 240)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Lay out the cards again."""
        super().resizeEvent(event)
        self._arrange()

    def showEvent(self, event: QShowEvent | None) -> None:
        """Start the wall clock."""
        super().showEvent(event)
        self._clock_card.show_wall()
        self._timer.start()
        self._numbers_due = -math.inf

    def hideEvent(self, event: QHideEvent | None) -> None:
        """Stop the wall clock while hidden."""
        self._timer.stop()
        super().hideEvent(event)

    def _make_cards(self) -> tuple[ClockCard, dict[str, HomeCard]]:
        look, board, watch = self.workspace.look, self._board, self._watch
        units = shown_units(self.workspace.preferences)
        clock = ClockCard(look, units, board)
        route = Route(self.workspace.flight, self.workspace.notices, self)
        condition = ConditionCard(look, units, board)
        self.workspace.absence.changed.connect(condition.show_absence)
        condition.show_absence(self.workspace.absence.text)
        cards: list[HomeCard] = [
            clock,
            condition,
            MotionCard(look, units, board),
            BatteryCard(look, units, watch, board),
            RotorCard(look, units, watch, board),
            AttitudeCard(look, units, board),
            ImuCard(look, units, board),
            HeightCard(look, units, board),
            LidarCard(look, units, watch, board),
            GpsCard(look, units, self.workspace.signals, route, board),
        ]
        return clock, {card.name: card for card in cards}

    def _arrange(self) -> None:
        room = self._scroll.maximumViewportSize()
        scale, total, spots = arrange_cards(room.width(), room.height())
        if total.height() > room.height():  # width of the scroll bar
            scale, total, spots = arrange_cards(room.width() - SCROLL_BAR_WIDTH_PX, room.height())
        self._board.resize(total.toSize())
        for name, spot in spots.items():
            self.cards[name].set_text_size(scale * DEFAULT_TEXT_HEIGHT_PX)
            self.cards[name].setGeometry(spot.toRect())

    def _tick(self) -> None:
        """Show the time of day, and whether the flight is silent."""
        self._clock_card.show_wall()
        if self._last is not None and self._last.phase is Phase.FLYING:
            silence = self._clock() - self._heard
            if silence >= SILENT_FLIGHT_TIMEOUT_S:
                self._clock_card.show_silence(silence)

    def _speak(self, name: str, now: float) -> None:
        """Describe a card to a screen reader, unless it was described just now."""
        if now - self._spoken.get(name, -math.inf) >= MIN_DESCRIPTION_PERIOD_S:
            self._spoken[name] = now
            self.cards[name].setAccessibleDescription(self.cards[name].spoken)

    def _use_preference(self, name: str) -> None:
        if name not in ("angle_unit", "speed_unit"):
            return
        units = shown_units(self.workspace.preferences)
        for card in self.cards.values():
            card.use_units(units)
        self._numbers_due = -math.inf
        if self._last is not None:
            self.show_view(self._last)

    def _colour(self) -> None:
        """Paint the board in the background colour."""
        palette = self._board.palette()
        palette.setColor(palette.ColorRole.Window, self.workspace.look.colour("ground"))
        self._board.setAutoFillBackground(True)
        self._board.setPalette(palette)
        self._scroll.setPalette(palette)
