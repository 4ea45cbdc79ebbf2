"""The Home screen: an overview of the flight, as cards in columns."""

import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from PyQt6.QtCore import QRectF, QSize, QSizeF, Qt, QTimer
from PyQt6.QtGui import QFontInfo, QHideEvent, QResizeEvent, QShowEvent
from PyQt6.QtWidgets import QApplication, QScrollArea, QWidget

from workbench.gui.charts.ticks import number_text
from workbench.gui.home.attitude_card import AttitudeCard
from workbench.gui.home.cards import BatteryCard, Card, ClockCard, ConditionCard, RotorCard
from workbench.gui.home.gps_card import GpsCard
from workbench.gui.home.lidar_card import LidarCard
from workbench.gui.home.route import Route
from workbench.gui.home.sensor_state import Health, SensorState, sensor_state
from workbench.gui.home.shown_units import ShownUnits, shown_units
from workbench.gui.home.stream_watch import StreamWatch
from workbench.gui.instruments.readout import NOTHING, Line
from workbench.gui.layout import BAR, NO_MARGINS, vbox
from workbench.gui.screens import Screen
from workbench.gui.units import MICROTESLA
from workbench.gui.workspace import Workspace
from workbench.live.messages import Phase
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot

PASCALS = 100.0
"""Pascals per hectopascal."""
SILENT = "Neither is on in this flight. Switch them on in Settings, Sensors."
MARGIN = 10.0
"""Margin around all cards, at scale 1 [px]."""
GAP = 8.0
"""Space between cards, at scale 1 [px]."""
SMALLEST = 0.8
"""Least scale with legible text: below it the screen scrolls."""
WIDE_ENOUGH = 0.75
"""Three columns are used if their text is at least this share of the size in two columns..."""
LARGE_ENOUGH = 0.95
"""...and at least of this scale, unless it would be smaller in two columns as well."""
PERIOD = 0.1
"""Period between updates of a number: digits that change faster are illegible [s]."""
MOST = 3
"""Largest number of updates per frame, those that wait longest first..."""
LATEST = 0.2
"""...plus all that have waited for longer than this [s]."""
TEXT = (11.0, 12.0)
"""Limits of the height of plain text at scale 1, within which the desktop's size is used [px]."""
TICK = 250
"""Period between updates of the wall clock [ms]."""
SILENCE = 1.0
"""Silence of a flying flight after which it is reported [s]."""
SPEAKING = 1.0
"""Least period between descriptions for a screen reader [s]."""


class MotionCard(Card):
    """A table: components along x, y, z of the world, and magnitude."""

    name = "motion"
    title = "Motion"

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.table = self.make_table("Motion in W", ("x east", "y north", "z up", "total"))
        self.parts = [self.table]

    @property
    def spoken(self) -> str:
        """The table as a sentence."""
        return f"in the world frame: {self.table.spoken}"

    def lines(self, units: ShownUnits) -> Sequence[Line]:
        """Return a line for each vector."""
        return (
            ("Displacement", units.length.symbol),
            ("Velocity", units.speed.symbol),
            ("Acceleration", units.acceleration.symbol),
        )

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show all three."""
        units = self.units
        for index, (vector, shown) in enumerate(
            (
                (now.displacement, units.length),
                (now.v_WB, units.speed),
                (now.vdot_WB, units.acceleration),
            )
        ):
            self.table.show_row(index, *shown.texts(*vector, math.hypot(*vector)))
        self.set_note("world frame W")


class ImuCard(Card):
    """Angular velocity, specific force and magnetic field along the sensors' axes."""

    name = "imu"
    title = "IMU, magnetometer"

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.table = self.make_table("IMU", ("x", "y", "z"))
        self.hint = self.make_hint("IMU")
        self.parts = [self.table, self.hint]

    @property
    def spoken(self) -> str:
        """The readings as a sentence."""
        return f"{self.note}; {super().spoken}"

    def lines(self, units: ShownUnits) -> Sequence[Line]:
        """Return a line for each reading."""
        return (
            ("Turn rate", units.rate.symbol),
            ("Specific force", units.acceleration.symbol),
            ("Magnetic field", MICROTESLA.symbol),
        )

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the newest readings, and the worse of the two states beside the title."""
        state = sensor_state(view, now, "imu")
        compass = sensor_state(view, now, "magnetometer")
        silent = now.imu is None and now.magnetometer is None
        self.table.setVisible(not silent)
        self.hint.setVisible(silent)
        self.set_state(max(state, compass, key=_concern))
        if silent:
            self.hint.say(state.note, state.advice)
            return
        rate = force = _unmeasured(state)
        field = _unmeasured(compass)
        if now.imu is not None:
            rate = self.units.rate.texts(*now.imu.angular_velocity)
            force = self.units.acceleration.texts(*now.imu.specific_force)
        if now.magnetometer is not None:
            field = tuple(
                number_text(MICROTESLA.shown(each), 2) for each in now.magnetometer.magnetic_field
            )
        self.table.show_row(0, *rate)
        self.table.show_row(1, *force)
        self.table.show_row(2, *field)


def _unmeasured(state: SensorState) -> tuple[str, ...]:
    """Return the text instead of x, y, z for a sensor without a reading."""
    off = state.health in (Health.OFF, Health.ABSENT)
    return ("", "", state.note if off else NOTHING)


def range_text(height: float) -> str:
    """Return a range finder's reading [m] as text, in words if it is out of range."""
    if math.isinf(height):
        return "too far" if height > 0.0 else "too near"
    return number_text(height, 2)


class HeightCard(Card):
    """The height from two sensors."""

    name = "height"
    title = "Barometer, range finder"

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.table = self.make_table("Heights", widest="88888.88")
        self.hint = self.make_hint("Heights")
        self.parts = [self.table, self.hint]

    @property
    def spoken(self) -> str:
        """The heights as a sentence."""
        return f"{self.note}; {super().spoken}"

    def lines(self, units: ShownUnits) -> Sequence[Line]:
        """Return a line for each reading."""
        return ("Altitude", "m"), ("Pressure", "hPa"), ("Range finder", "m")

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the newest readings, and the worse of the two states beside the title."""
        air = sensor_state(view, now, "barometer")
        way = sensor_state(view, now, "range_finder")
        silent = now.barometer is None and now.height is None
        self.table.setVisible(not silent)
        self.hint.setVisible(silent)
        self.set_state(max(air, way, key=_concern))
        if silent:
            self.hint.say(air.note, SILENT if Health.OFF in (air.health, way.health) else "")
            return
        if now.barometer is not None:
            self.table.show_row(0, number_text(now.barometer.altitude, 2))
            self.table.show_row(1, number_text(now.barometer.pressure / PASCALS, 2))
        else:
            self.table.show_row(0, air.word)
            self.table.show_row(1, air.word)
        self.table.show_row(2, way.word if now.height is None else range_text(now.height))


def _concern(state: SensorState) -> int:
    """Return the severity of a state."""
    return list(Health).index(state.health) if state.measures else 0


Plan = tuple[float, float, Sequence[Mapping[str, tuple[float, float]]]]
"""Width and height at scale 1 [px], and columns of equal width: for each card from top to bottom
its least height at scale 1 [px], and its share of the remaining height."""
THREE: Plan = (
    1190.0,
    600.0,
    (
        {
            "clock": (76.0, 0.0),
            "condition": (92.0, 0.0),
            "motion": (132.0, 0.0),
            "battery": (62.0, 0.0),
            "rotors": (140.0, 1.0),
        },
        {"attitude": (290.0, 0.7), "imu": (138.0, 0.15), "height": (112.0, 0.15)},
        {"lidar": (290.0, 1.2), "gps": (230.0, 1.0)},
    ),
)
TWO: Plan = (
    760.0,
    600.0,
    (
        {
            "clock": (62.0, 0.0),
            "attitude": (174.0, 1.0),
            "motion": (118.0, 0.0),
            "imu": (104.0, 0.0),
            "height": (86.0, 0.0),
        },
        {
            "condition": (82.0, 0.0),
            "battery": (48.0, 0.0),
            "lidar": (160.0, 1.0),
            "gps": (130.0, 0.6),
            "rotors": (126.0, 0.4),
        },
    ),
)


def scale_of(plan: Plan, width: float, height: float) -> float:
    """Return the scale at which a plan fits a number of pixels."""
    return min(width / plan[0], height / plan[1])


def choose_plan(width: float, height: float) -> Plan:
    """Return the plan with the best use of a number of pixels."""
    three, two = scale_of(THREE, width, height), scale_of(TWO, width, height)
    return THREE if three >= min(two, max(LARGE_ENOUGH, WIDE_ENOUGH * two)) else TWO


def arrange(width: float, height: float) -> tuple[float, QSizeF, dict[str, QRectF]]:
    """Return the scale of text and margins, the size of all cards, and the area of each [px].

    Args:
        width: width to fill [px]; the cards need more if it is too small.
        height: height to fill [px], likewise.
    """
    plan = choose_plan(width, height)
    scale = max(SMALLEST, scale_of(plan, width, height))
    width, height = max(width, SMALLEST * plan[0]), max(height, SMALLEST * plan[1])
    columns = plan[2]
    margin, gap = scale * MARGIN, scale * GAP
    across = (width - 2 * margin - (len(columns) - 1) * gap) / len(columns)
    spots: dict[str, QRectF] = {}
    for index, column in enumerate(columns):
        left, top = margin + index * (across + gap), margin
        spare = height - 2 * margin - (len(column) - 1) * gap
        spare -= sum(scale * least for least, _ in column.values())
        total = sum(share for _, share in column.values())
        for name, (least, share) in column.items():
            tall = scale * least + max(0.0, spare) * share / total
            spots[name] = QRectF(left, top, across, tall)
            top += tall + gap
    return scale, QSizeF(width, height), spots


class Turns:
    """Tells which of some names are due for an update.

    Args:
        names: names that take turns.
    """

    def __init__(self, names: Iterable[str]) -> None:
        self._names = tuple(names)
        self._due: dict[str, float] = {}

    def reset(self) -> None:
        """Make all names due at once."""
        self._due.clear()

    def due(self, time: float) -> list[str]:
        """Return the names that are due at a time [s]; they then wait for their next turn."""
        if not self._due:  # from here on they are due one after the other
            share = PERIOD / len(self._names)
            self._due = {n: time + PERIOD + k * share for k, n in enumerate(self._names)}
            return list(self._names)
        waiting = [name for name in self._names if self._due[name] <= time + 1e-9]
        waiting.sort(key=lambda name: self._due[name])
        late = [name for name in waiting if self._due[name] < time - LATEST]
        taken = waiting[: max(MOST, len(late))]
        for name in taken:
            self._due[name] = max(self._due[name] + PERIOD, time + PERIOD / 2)
        return taken


class HomeScreen(Screen):
    """Cards in two or three columns, depending on the size.

    Dials follow every view, numbers change ten times a second, and unchanged parts are not painted.

    Args:
        workspace: services that all screens share.
        clock: returns a monotonic time [s].
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
        self._turns = Turns(self.cards)
        self._timer = QTimer(self)
        self._timer.setInterval(TICK)
        self._timer.timeout.connect(self._tick)
        workspace.flight.streamed.connect(self._watch.hear)
        workspace.preferences.changed.connect(self._use_preference)
        workspace.look.changed.connect(self._colour)
        self._colour()

    def begin(self, view: LiveView) -> None:
        """Clear the last flight, and show the rotors and sensors of this one."""
        self._watch.begin(view)
        for card in self.cards.values():
            card.begin(view)
        self._turns.reset()
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
            self._turns.reset()
        for name in self._turns.due(now):
            self.cards[name].show_numbers(view, view.snapshot)
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
        self._turns.reset()

    def hideEvent(self, event: QHideEvent | None) -> None:
        """Stop the wall clock while hidden."""
        self._timer.stop()
        super().hideEvent(event)

    def _make_cards(self) -> tuple[ClockCard, dict[str, Card]]:
        look, board, watch = self.workspace.look, self._board, self._watch
        units = shown_units(self.workspace.preferences)
        clock = ClockCard(look, units, board)
        route = Route(self.workspace.flight, self.workspace.notices, self)
        cards: list[Card] = [
            clock,
            ConditionCard(look, units, board),
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
        scale, total, spots = arrange(room.width(), room.height())
        if total.height() > room.height():  # width of the scroll bar
            scale, total, spots = arrange(room.width() - BAR, room.height())
        self._board.resize(total.toSize())
        size = scale * min(TEXT[1], max(TEXT[0], QFontInfo(QApplication.font()).pixelSize()))
        for name, spot in spots.items():
            self.cards[name].set_text_size(size)
            self.cards[name].setGeometry(spot.toRect())

    def _tick(self) -> None:
        """Show the time of day, and whether the flight is silent."""
        self._clock_card.show_wall()
        if self._last is not None and self._last.phase is Phase.FLYING:
            silence = self._clock() - self._heard
            if silence >= SILENCE:
                self._clock_card.show_silence(silence)

    def _speak(self, name: str, now: float) -> None:
        """Describe a card to a screen reader, unless it was described just now."""
        if now - self._spoken.get(name, -math.inf) >= SPEAKING:
            self._spoken[name] = now
            self.cards[name].setAccessibleDescription(self.cards[name].spoken)

    def _use_preference(self, name: str) -> None:
        if name not in ("angle_unit", "speed_unit"):
            return
        units = shown_units(self.workspace.preferences)
        for card in self.cards.values():
            card.use_units(units)
        self._turns.reset()
        if self._last is not None:
            self.show_view(self._last)

    def _colour(self) -> None:
        """Paint the board in the background colour."""
        palette = self._board.palette()
        palette.setColor(palette.ColorRole.Window, self.workspace.look.colour("ground"))
        self._board.setAutoFillBackground(True)
        self._board.setPalette(palette)
        self._scroll.setPalette(palette)
