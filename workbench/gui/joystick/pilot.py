"""The operator's sticks of all kinds, connected to the flight."""

import math
import time
from collections.abc import Callable
from enum import Enum

from PyQt6.QtCore import QObject, Qt, QTimer, pyqtSignal

from workbench.gui.flight_control import flight_denial_reason
from workbench.gui.flight_model import FlightModel
from workbench.gui.joystick.game_pad import GamePads, PadReading
from workbench.gui.joystick.keyboard_sticks import KeyboardSticks
from workbench.gui.joystick.pad_mapping import PadMapping, read_mapping, save_mapping
from workbench.gui.joystick.piloting import (
    CENTRED_STICKS,
    ZERO_STICK_COMMAND,
    FlightLimits,
    Handling,
    StickCommand,
    StickPosition,
    Sticks,
)
from workbench.gui.key_map import KeyMap
from workbench.gui.preferences import Preferences
from workbench.gui.signals import parameter_changes
from workbench.link.backplane import Published
from workbench.link.messages import ControlOwner
from workbench.live.orders import NetworkOrder
from workbench.live.view import LiveView
from workbench.scenario.scenario import Action

CENTRE_STICKS_TEXT = "Release the sticks first: they were held while they did not count."
CENTRE_PAD_TEXT = "release its sticks first"

CommandedVelocity = tuple[float, float, float]
SendStickCommand = Callable[[CommandedVelocity, float], None]

MAX_COMMAND_RATE_HZ = 30.0
"""Largest rate of commands [1/s]; zeros do not count, as each one ends a motion."""
COMMAND_REPEAT_PERIOD_S = 1.0
"""Period after which an unchanged command is repeated [s]."""
MIN_SPEED_CHANGE_M_S = 0.005
"""Smaller changes are ignored, because a hovering drone's heading varies a little [m/s]."""
MIN_YAW_RATE_CHANGE_RAD_S = 0.001
"""The same for the yaw rate [rad/s]."""
_ZERO_VELOCITY = (0.0, 0.0, 0.0)

HANDLING_PREFERENCES = (
    "stick_speed",
    "stick_yaw_rate",
    "stick_sensitivity",
    "stick_expo",
    "stick_dead_band",
)
"""Preferences of the sticks, in the order of the attributes of `Handling`."""
STICK_POLL_MS = 16
"""Period between readings of keys and pads [ms]."""
MAX_KEY_STEP_S = 0.1
"""Longest time by which held keys deflect at once [s]."""


class CentringGate:
    """Blocks the sticks until they have been centred after whatever blocked them."""

    def __init__(self) -> None:
        self._centre_first = False
        self._hand = ControlOwner.NOBODY

    def close(self) -> None:
        """Require centred sticks first: the screen was left, or another flight begins."""
        self._centre_first = True

    def pass_on(self, barred: str, neutral: bool, hand: ControlOwner) -> str:
        """Return why the sticks have no effect now, "" if they have.

        Args:
            barred: why the flight ignores them, "" if it does not.
            neutral: whether they are centred.
            hand: who has control; a held stick does not take it from a client.
        """
        given = hand is ControlOwner.CLIENT and self._hand is not ControlOwner.CLIENT
        self._hand = hand
        if neutral:
            self._centre_first = False
        elif barred or given:
            self._centre_first = True
        return barred or (CENTRE_STICKS_TEXT if self._centre_first else "")


class CommandSender:
    """Sends commands on change.

    Args:
        send: sends a velocity in W [m/s] and a yaw rate [rad/s] to the flight.
        clock: returns a monotonic time [s].
    """

    def __init__(self, send: SendStickCommand, clock: Callable[[], float]) -> None:
        self._send, self._clock = send, clock
        self._sent: tuple[CommandedVelocity, float] = (_ZERO_VELOCITY, 0.0)
        self._when = -COMMAND_REPEAT_PERIOD_S

    @property
    def is_asking(self) -> bool:
        """Whether the last command was a motion."""
        return self._sent != (_ZERO_VELOCITY, 0.0)

    def put(self, velocity: CommandedVelocity, yaw_rate: float) -> None:
        """Send the present command if it is due; must be called again until it changes.

        Args:
            velocity: velocity in W [m/s].
            yaw_rate: yaw rate, counter-clockwise seen from above [rad/s].
        """
        if not any((*velocity, yaw_rate)):
            self.stop()
            return
        now = self._clock()
        waited = now - self._when
        if waited < 1.0 / MAX_COMMAND_RATE_HZ:
            return
        if waited >= COMMAND_REPEAT_PERIOD_S or self._differs(velocity, yaw_rate):
            self._sent, self._when = (velocity, yaw_rate), now
            self._send(velocity, yaw_rate)

    def stop(self) -> None:
        """Send zero at once, if the last command was a motion."""
        if self.is_asking:
            self._sent = (_ZERO_VELOCITY, 0.0)
            self._send(*self._sent)

    def forget(self) -> None:
        """Forget what was sent: another flight begins."""
        self._sent = (_ZERO_VELOCITY, 0.0)

    def _differs(self, velocity: CommandedVelocity, yaw_rate: float) -> bool:
        before, turned = self._sent
        step = max(abs(new - old) for new, old in zip(velocity, before, strict=True))
        return (
            not self.is_asking
            or step > MIN_SPEED_CHANGE_M_S
            or abs(yaw_rate - turned) > MIN_YAW_RATE_CHANGE_RAD_S
        )


class StickDevice(Enum):
    """Source of the sticks' motion."""

    NONE = "nothing"
    MOUSE = "mouse"
    KEYBOARD = "keyboard"
    PAD = "game pad"


GENTLE_DEVICES = (StickDevice.MOUSE, StickDevice.KEYBOARD)
"""Devices whose commands are smaller near an obstacle; a thumb holds a pad's stick part-way."""


class StickPilot(QObject):
    """Reads sticks while active, and sends their commands.

    Args:
        flight: the flight to control.
        preferences: source of the sticks' sensitivity.
        keys: keys of all actions.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        sticks: their positions, from any device.
        wish: their present command; zero while they have no effect.
        barred: why they have no effect, "" if they have.
        device: the device that moves them.
        keyboard: held keys.
        pad_name: name of the game pad that flies, "" without one.
        pads_waiting: number of other plugged-in pads.
        hand_over: why a pad that asks to fly may not, "" without a refusal.
        limits: limits of the flight.
        handling: sensitivity of the sticks.
        gentle_handling: sensitivity of keys and mouse, which is lower near an obstacle.
        clearance: distance from the nearest obstacle [m], infinite without one.
    """

    changed = pyqtSignal()
    """One of the attributes has changed."""

    def __init__(
        self,
        flight: FlightModel,
        preferences: Preferences,
        keys: KeyMap,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._flight, self._preferences = flight, preferences
        self.keyboard, self.pads = KeyboardSticks(keys, self), GamePads(self.mapping)
        self.pads_waiting, self.hand_over = 0, ""
        self._mappings: dict[str, PadMapping] = {}
        self.sticks, self.wish, self.barred = CENTRED_STICKS, ZERO_STICK_COMMAND, ""
        self.device, self.pad_name, self.limits = StickDevice.NONE, "", FlightLimits()
        self.handling = self.gentle_handling = read_handling(preferences)
        self.clearance = math.inf
        self._mouse: dict[str, StickPosition] = {}
        self._gate, self._courier = CentringGate(), CommandSender(self._send, time.monotonic)
        self._listens_to_pads = False
        self._looked = time.monotonic()
        self._timer = QTimer(self)
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.setInterval(STICK_POLL_MS)
        self._timer.timeout.connect(self.look)
        self.keyboard.changed.connect(self.look)
        preferences.changed.connect(self._prefer)
        flight.streamed.connect(self._hear)

    def start(self) -> None:
        """Start: the screen is visible."""
        self.pads.open()
        self._gate.close()
        self._looked = time.monotonic()
        self._timer.start()
        self.look()

    def stop(self) -> None:
        """Stop, and release all sticks."""
        self.release()
        self._timer.stop()

    def close(self) -> None:
        """Close the game pads, too; must be the last call."""
        self.stop()
        self.pads.close()

    def begin(self, view: LiveView) -> None:
        """Note that a flight has begun, without a command yet."""
        self._courier.forget()
        self._gate.close()
        self.limits = FlightLimits().after(view.values)
        self.changed.emit()

    def listen_to_pads(self, listens: bool) -> None:
        """Enable or disable game pads: they do not fly from an inactive window."""
        if listens and not self._listens_to_pads:
            self._gate.close()
        self._listens_to_pads = listens
        self.look()

    def hold_stick(self, side: str, stick: StickPosition | None) -> None:
        """Move the left or right stick with the mouse; None releases it."""
        if stick is None:
            self._mouse.pop(side, None)
        else:
            self._mouse[side] = stick
        self.look()

    def release(self) -> None:
        """Release everything, and stop the drone at once; a pad must then be centred first."""
        self._mouse.clear()
        self.keyboard.release_all()
        self._gate.close()
        self._courier.stop()
        self.look()

    def mapping(self, guid: str) -> PadMapping:
        """Return the mapping of a pad's axes."""
        if guid not in self._mappings:
            self._mappings[guid] = read_mapping(self._preferences.store, guid)
        return self._mappings[guid]

    def map_pad(self, guid: str, mapping: PadMapping) -> None:
        """Change and store the mapping of a pad's axes; sticks must then be centred."""
        self._mappings[guid] = mapping
        save_mapping(self._preferences.store, guid, mapping)
        self._gate.close()

    def hand_to(self, number: int) -> None:
        """Let another pad fly, if its sticks are centred."""
        for each in self.pads.readings:
            if each.number == number and number != self.pads.flying:
                centred = not any(each.sticks)
                self.hand_over = (
                    "" if centred else f"{each.name} cannot take over: {CENTRE_PAD_TEXT}."
                )
                if centred:
                    self.pads.fly(number)
                    self._gate.close()
                self.changed.emit()

    def give_back(self) -> None:
        """Allow clients to request control again."""
        self.release()
        self._flight.do(NetworkOrder.GIVE_BACK)

    def look(self) -> None:
        """Read the sticks, and send their command."""
        now = time.monotonic()
        passed, self._looked = min(now - self._looked, MAX_KEY_STEP_S), now
        sticks, device = self._read(passed)
        view = self._flight.view
        control = view.network.control
        hand = control.hand if control else ControlOwner.NOBODY
        barred = self._gate.pass_on(flight_denial_reason(self._flight), not any(sticks), hand)
        self._look_around(view)
        handling = self.gentle_handling if device in GENTLE_DEVICES else self.handling
        wish = ZERO_STICK_COMMAND if barred else handling.wish(sticks)
        if wish == ZERO_STICK_COMMAND or view.snapshot is None:
            self._courier.stop()
        else:
            yaw = view.snapshot.roll_pitch_yaw[2]
            self._courier.put(wish.velocity(yaw), wish.yaw_rate)
        self._show(sticks, wish, barred, device)

    def _look_around(self, view: LiveView) -> None:
        """Reduce the sensitivity of keys and mouse near an obstacle."""
        found = view.snapshot.clearance if view.snapshot is not None else None
        self.clearance = found.distance if found is not None else math.inf
        self.gentle_handling = self.handling.near(self.clearance)

    def _read(self, passed: float) -> tuple[Sticks, StickDevice]:
        """Return the sticks after a time [s], and the device that moves them."""
        reading = self.pads.read()
        if self._listens_to_pads:
            for each in self.pads.readings:
                if each.asks:
                    self.hand_to(each.number)
        self._name_pads(reading)
        keys = self.keyboard.advance(passed)
        if self._mouse:
            left, right = self._mouse.get("left", keys[:2]), self._mouse.get("right", keys[2:])
            return Sticks(*left, *right), StickDevice.MOUSE
        if self.keyboard.is_held:
            return keys, StickDevice.KEYBOARD
        if reading and self._listens_to_pads:
            for button in reading.pressed:
                self._request(button.request)
            if any(reading.sticks):
                return reading.sticks, StickDevice.PAD
        return CENTRED_STICKS, StickDevice.NONE

    def _name_pads(self, reading: PadReading | None) -> None:
        """Note which pad flies, and how many wait."""
        name = reading.name if reading else ""
        waiting = sum(each.number != self.pads.flying for each in self.pads.readings)
        if (name, waiting) != (self.pad_name, self.pads_waiting):
            self.pad_name, self.pads_waiting, self.hand_over = name, waiting, ""
            self.changed.emit()

    def _request(self, what: str) -> None:
        self._flight.do(Action(request=what))

    def _send(self, velocity: CommandedVelocity, yaw_rate: float) -> None:
        if self._flight.live is not None:
            self._flight.do(Action(velocity=[*velocity], yaw_rate=yaw_rate))

    def _show(self, sticks: Sticks, wish: StickCommand, barred: str, device: StickDevice) -> None:
        new = sticks, wish, barred, device
        if new != (self.sticks, self.wish, self.barred, self.device):
            self.sticks, self.wish, self.barred, self.device = new
            self.changed.emit()

    def _prefer(self, name: str) -> None:
        if name.startswith("stick_"):
            self.handling = read_handling(self._preferences)
            self.changed.emit()

    def _hear(self, published: list[Published]) -> None:
        """Note limits that change in flight."""
        told = {name: value for _, name, value in parameter_changes(published)}
        limits = self.limits.after(told)
        if limits != self.limits:
            self.limits = limits
            self.changed.emit()


def read_handling(preferences: Preferences) -> Handling:
    """Return the sticks' sensitivity."""
    return Handling(*map(preferences.number, HANDLING_PREFERENCES))
