"""The operator's hand: sticks of all kinds on one side, the flight on the other."""

import math
import time
from collections.abc import Callable
from enum import Enum

from PyQt6.QtCore import QObject, Qt, QTimer, pyqtSignal

from workbench.gui.flight_control import barrier_of
from workbench.gui.flight_model import FlightModel
from workbench.gui.joystick.game_pad import GamePads, PadReading
from workbench.gui.joystick.keyboard_sticks import KeyboardSticks
from workbench.gui.joystick.pad_mapping import PadMapping, keep_mapping, read_mapping
from workbench.gui.joystick.piloting import (
    NEUTRAL,
    NOTHING,
    FlightLimits,
    Handling,
    Stick,
    StickCurve,
    Sticks,
    Wish,
)
from workbench.gui.preferences import Preferences
from workbench.gui.signals import ParameterReader
from workbench.link.backplane import Published
from workbench.link.messages import Hand
from workbench.live.view import LiveView

CENTRE = "Let go of the sticks first: they were held while they did not count."
CENTRE_PAD = "let go of its sticks first"

Velocity = tuple[float, float, float]
Send = Callable[[Velocity, float], None]

MOST_A_SECOND = 30.0
"""Commands that are sent, zeros left out: each of them ends a wish, so they are no more."""
REPEAT = 1.0
"""After which a wish that has not changed is said again [s]."""
STEP = 0.005
"""Changes smaller than this are none: a hovering drone's heading trembles [m/s]."""
TURN_STEP = 0.001
"""The same of the yaw rate [rad/s]."""
_STILL = (0.0, 0.0, 0.0)

PERIOD = 16
"""Between two looks at keys and pads [ms]."""
LONGEST_STEP = 0.1
"""By which held keys run up at once [s]."""


class Gate:
    """Lets sticks through, once they were in the middle after whatever barred them."""

    def __init__(self) -> None:
        self._centre_first = False
        self._hand = Hand.NOBODY

    def close(self) -> None:
        """Ask for the middle first: the screen was left, or another flight begins."""
        self._centre_first = True

    def pass_on(self, barred: str, neutral: bool, hand: Hand) -> str:
        """Return why the sticks do not count now, "" if they do.

        Args:
            barred: why the flight does not listen to them, "" if it does.
            neutral: whether they are in the middle.
            hand: who flies; a client that was given the drone does not lose it to a held stick.
        """
        given = hand is Hand.CLIENT and self._hand is not Hand.CLIENT
        self._hand = hand
        if neutral:
            self._centre_first = False
        elif barred or given:
            self._centre_first = True
        return barred or (CENTRE if self._centre_first else "")


class Courier:
    """Sends commands on change.

    Args:
        send: gives the flight a velocity in W [m/s] and a yaw rate [rad/s].
        clock: rises, whatever happens to the date [s].
    """

    def __init__(self, send: Send, clock: Callable[[], float]) -> None:
        self._send, self._clock = send, clock
        self._sent: tuple[Velocity, float] = (_STILL, 0.0)
        self._when = -REPEAT

    @property
    def is_asking(self) -> bool:
        """Whether the last thing sent asked for a motion."""
        return self._sent != (_STILL, 0.0)

    def put(self, velocity: Velocity, yaw_rate: float) -> None:
        """Send what is wished now, if it is due; to be called again until it is another.

        Args:
            velocity: in W [m/s].
            yaw_rate: seen from above to the left [rad/s].
        """
        if not any((*velocity, yaw_rate)):
            self.stop()
            return
        now = self._clock()
        waited = now - self._when
        if waited < 1.0 / MOST_A_SECOND:
            return
        if waited >= REPEAT or self._differs(velocity, yaw_rate):
            self._sent, self._when = (velocity, yaw_rate), now
            self._send(velocity, yaw_rate)

    def stop(self) -> None:
        """Send zero at once, if a motion was asked for."""
        if self.is_asking:
            self._sent = (_STILL, 0.0)
            self._send(*self._sent)

    def forget(self) -> None:
        """Take nothing as sent: another flight begins."""
        self._sent = (_STILL, 0.0)

    def _differs(self, velocity: Velocity, yaw_rate: float) -> bool:
        before, turned = self._sent
        step = max(abs(new - old) for new, old in zip(velocity, before, strict=True))
        return not self.is_asking or step > STEP or abs(yaw_rate - turned) > TURN_STEP


class Device(Enum):
    """What moves the sticks."""

    NONE = "nothing"
    MOUSE = "mouse"
    KEYBOARD = "keyboard"
    PAD = "game pad"


class Pilot(QObject):
    """Reads sticks while it is on duty, and sends what they ask for.

    Args:
        flight: that is flown.
        preferences: how strongly sticks are felt.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        sticks: where they are, whatever moves them.
        wish: what they ask for now; nothing while they do not count.
        barred: why they do not count, "" if they do.
        device: what moves them.
        keyboard: keys that are held.
        pad_name: of the game pad that flies, "" without one.
        pads_waiting: how many are plugged in besides.
        hand_over: why a pad that wanted to fly does not, "" where none was refused.
        limits: of the flight.
        handling: how strongly sticks are felt.
        key_handling: how strongly keys are, which are gentler near an obstacle.
        clearance: from the nearest obstacle [m], infinite without.
    """

    changed = pyqtSignal()
    """Something of the above is another."""

    def __init__(
        self, flight: FlightModel, preferences: Preferences, parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._flight, self._preferences = flight, preferences
        self.keyboard, self.pads = KeyboardSticks(), GamePads(self.mapping)
        self.pads_waiting, self.hand_over = 0, ""
        self._mappings: dict[str, PadMapping] = {}
        self.sticks, self.wish, self.barred = NEUTRAL, NOTHING, ""
        self.device, self.pad_name, self.limits = Device.NONE, "", FlightLimits()
        self.handling = self.key_handling = read_handling(preferences)
        self.clearance = math.inf
        self._mouse: dict[str, Stick] = {}
        self._gate, self._courier = Gate(), Courier(self._send, time.monotonic)
        self._reader = ParameterReader()
        self._listens_to_pads = False
        self._looked = time.monotonic()
        self._timer = QTimer(self)
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.setInterval(PERIOD)
        self._timer.timeout.connect(self.look)
        preferences.changed.connect(self._prefer)
        flight.streamed.connect(self._hear)

    def start(self) -> None:
        """Go on duty: the screen is seen."""
        self.pads.open()
        self._gate.close()
        self._looked = time.monotonic()
        self._timer.start()
        self.look()

    def stop(self) -> None:
        """Go off duty, with all sticks let go."""
        self.release()
        self._timer.stop()

    def close(self) -> None:
        """Let go of the game pad, too; the last call."""
        self.stop()
        self.pads.close()

    def begin(self, view: LiveView) -> None:
        """Take note that a flight has begun: it was asked for nothing yet."""
        self._courier.forget()
        self._gate.close()
        self.limits = FlightLimits().after(view.values)
        self._reader.begin(view.topics)
        self.changed.emit()

    def listen_to_pads(self, listens: bool) -> None:
        """Let game pads count or not: a window in the background does not fly."""
        if listens and not self._listens_to_pads:
            self._gate.close()
        self._listens_to_pads = listens
        self.look()

    def hold_stick(self, side: str, stick: Stick | None) -> None:
        """Move the left or right stick with the mouse; None lets go of it."""
        if stick is None:
            self._mouse.pop(side, None)
        else:
            self._mouse[side] = stick
        self.look()

    def release(self) -> None:
        """Let go of everything, and let the drone stop at once; a pad must be centred first."""
        self._mouse.clear()
        self.keyboard.release_all()
        self._gate.close()
        self._courier.stop()
        self.look()

    def mapping(self, guid: str) -> PadMapping:
        """Return what the axes of a pad move."""
        if guid not in self._mappings:
            self._mappings[guid] = read_mapping(self._preferences.store, guid)
        return self._mappings[guid]

    def map_pad(self, guid: str, mapping: PadMapping) -> None:
        """Let the axes of a pad move something else, and keep that; sticks must be centred then."""
        self._mappings[guid] = mapping
        keep_mapping(self._preferences.store, guid, mapping)
        self._gate.close()

    def hand_to(self, number: int) -> None:
        """Let another pad fly, if its sticks are centred."""
        for each in self.pads.readings:
            if each.number == number and number != self.pads.flying:
                centred = each.sticks.are_neutral
                self.hand_over = "" if centred else f"{each.name} cannot take over: {CENTRE_PAD}."
                if centred:
                    self.pads.fly(number)
                    self._gate.close()
                self.changed.emit()

    def give_back(self) -> None:
        """Let clients ask for control again."""
        self.release()
        self._flight.order(lambda live: live.give_back())

    def look(self) -> None:
        """Read the sticks, and send what they ask for."""
        now = time.monotonic()
        passed, self._looked = min(now - self._looked, LONGEST_STEP), now
        sticks, device = self._read(passed)
        view = self._flight.view
        control = view.network.control
        hand = control.hand if control else Hand.NOBODY
        barred = self._gate.pass_on(barrier_of(self._flight), sticks.are_neutral, hand)
        self._look_around(view)
        handling = self.key_handling if device is Device.KEYBOARD else self.handling
        wish = NOTHING if barred else handling.wish(sticks)
        if wish == NOTHING or view.snapshot is None:
            self._courier.stop()
        else:
            yaw = view.snapshot.roll_pitch_yaw[2]
            self._courier.put(wish.velocity(yaw), wish.yaw_rate)
        self._show(sticks, wish, barred, device)

    def _look_around(self, view: LiveView) -> None:
        """Let keys be gentle near an obstacle."""
        found = view.snapshot.clearance if view.snapshot is not None else None
        self.clearance = found.distance if found is not None else math.inf
        self.key_handling = self.handling.near(self.clearance)

    def _read(self, passed: float) -> tuple[Sticks, Device]:
        """Return where the sticks are after a time [s], and what moves them."""
        reading = self.pads.read()
        if self._listens_to_pads:
            for each in self.pads.readings:
                if each.asks:
                    self.hand_to(each.number)
        self._name_pads(reading)
        keys = self.keyboard.advance(passed)
        if self._mouse:
            left, right = self._mouse.get("left", keys.left), self._mouse.get("right", keys.right)
            return Sticks(left, right), Device.MOUSE
        if self.keyboard.is_held:
            return keys, Device.KEYBOARD
        if reading and self._listens_to_pads:
            for button in reading.pressed:
                self._request(button.request)
            if not reading.sticks.are_neutral:
                return reading.sticks, Device.PAD
        return NEUTRAL, Device.NONE

    def _name_pads(self, reading: PadReading | None) -> None:
        """Take note of which pad flies, and how many wait."""
        name = reading.name if reading else ""
        waiting = sum(each.number != self.pads.flying for each in self.pads.readings)
        if (name, waiting) != (self.pad_name, self.pads_waiting):
            self.pad_name, self.pads_waiting, self.hand_over = name, waiting, ""
            self.changed.emit()

    def _request(self, what: str) -> None:
        self._flight.order(lambda live: live.request(what))

    def _send(self, velocity: Velocity, yaw_rate: float) -> None:
        if self._flight.live is not None:
            self._flight.order(lambda live: live.command(velocity, yaw_rate))

    def _show(self, sticks: Sticks, wish: Wish, barred: str, device: Device) -> None:
        new = sticks, wish, barred, device
        if new != (self.sticks, self.wish, self.barred, self.device):
            self.sticks, self.wish, self.barred, self.device = new
            self.changed.emit()

    def _prefer(self, name: str) -> None:
        if name.startswith("stick_"):
            self.handling = read_handling(self._preferences)
            self.changed.emit()

    def _hear(self, published: list[Published]) -> None:
        """Take note of limits that are changed in flight."""
        told = {change.name: change.value for change in self._reader.read(published)}
        limits = self.limits.after(told)
        if limits != self.limits:
            self.limits = limits
            self.changed.emit()


def read_handling(preferences: Preferences) -> Handling:
    """Return how strongly sticks are felt."""
    return Handling(
        preferences.number("stick_speed"),
        preferences.number("stick_yaw_rate"),
        StickCurve(
            preferences.number("stick_sensitivity"),
            preferences.number("stick_expo"),
            preferences.number("stick_dead_band"),
        ),
    )
