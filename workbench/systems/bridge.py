"""The bridge between a flight and the network: commands in, samples out, without blocking.

`CommandBridge` applies commands just before a control update, `Telemetry` publishes; both are
LeafSystems. They share `Bridge` with the connection to the server.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from pydrake.systems.framework import Context, State

from workbench.control.flight_mode import HOLD_HERE, ModeState
from workbench.control.mode import FlightMode, Request
from workbench.link.authority import (
    NOBODY_YET,
    Authority,
    DeniedError,
    Effect,
    Limits,
)
from workbench.link.backplane import Command, Published, Refused, Sampled
from workbench.systems.pilot import AT_REST, Pilot, Wish, commanded, requested

MOST_COMMANDS = 32
"""Commands that may wait for one update; then the newest replaces the previous one.

The first one stays, as it may be the neutral one that a new holder starts with. All of them may be
refused at once, so the limit is below that of a client's pending answers (64).
"""
MOST_SAMPLES = 4096
"""Samples that may wait; older ones are dropped."""


@dataclass(frozen=True)
class Applied:
    """A command that took effect in a flight.

    Attributes:
        at: the time of the control update that flies it first [s].
        by: its sender.
        what: a command as it is flown, or the reaction to a silent holder.
        aborts: whether the command ends a landing.
    """

    at: float
    by: str
    what: Command | Effect
    aborts: bool = False


class Bridge:
    """The network's side of one flight: control authority, and commands and samples that wait.

    Attributes:
        authority: grants control.
        wanted: whether anybody wants samples; otherwise none are made.
        settings: increases whenever a live parameter is set.
        at_once: receives each sample within the publish event, and must never block.
        scripted: physics steps at which a script acts.
    """

    def __init__(self) -> None:
        self.wanted = True
        self.settings = 0
        self.at_once: Callable[[Published], None] = lambda published: None
        self.scripted: frozenset[int] = frozenset()
        self.authority = Authority(Limits(0.0, 0.0, 0.0))
        self._neutral = True
        self._last_ns = -1  # when something was published
        self._commands: deque[Command] = deque()
        self._samples: deque[Sampled] = deque(maxlen=MOST_SAMPLES)
        self._applied: list[Applied] = []
        self._refused: list[Refused] = []

    def reset(self) -> None:
        """Start a new flight: nobody has control, nothing waits."""
        self.authority.begin(0.0, NOBODY_YET)
        self._neutral = True
        self._last_ns = -1
        for waiting in (self._commands, self._samples, self._applied, self._refused):
            waiting.clear()

    def command(self, command: Command, now: float) -> None:
        """Put a command of the holder into the mailbox; the next update checks it.

        Only the holder's commands enter the mailbox, so a flood from others displaces nothing.
        """
        try:
            self.authority.check(command.peer, command.lease, now)
        except DeniedError as error:
            self.refuse(command, error)
            return
        if len(self._commands) == MOST_COMMANDS:
            self._commands.pop()
        self._commands.append(command)

    def refuse(self, command: Command, error: DeniedError) -> None:
        """Tell the client that a command is refused."""
        self._refused.append(Refused(command.peer, command.seq, error.code, str(error)))

    def publish(self, sampled: Sampled) -> None:
        """Pass a sample on at once, and keep it until `drain`.

        A diagram that takes over publishes its first instant, which was already published.
        """
        if sampled.published.t_ns <= self._last_ns:
            return
        self._last_ns = sampled.published.t_ns
        self.at_once(sampled.published)
        self._samples.append(sampled)

    def drain(self) -> list[Sampled]:
        """Return the samples since the last call."""
        return [self._samples.popleft() for _ in range(len(self._samples))]

    def applied(self) -> list[Applied]:
        """Return the commands that took effect since the last call."""
        applied, self._applied = self._applied, []
        return applied

    def refused(self) -> list[Refused]:
        """Return the commands that were refused or reduced since the last call."""
        refused, self._refused = self._refused, []
        return refused

    def moves(self, *command: float) -> bool:
        """Store velocity and yaw rate of a pilot; return whether a stick leaves neutral.

        That ends a landing. A command that continues from before the landing does not.
        """
        before, self._neutral = self._neutral, not any(command)
        return before and not self._neutral

    def decide(self, now: float, wish: Wish, mode: Callable[[], ModeState]) -> Wish:
        """Return the wish from now on.

        Args:
            now: time of the update [s].
            wish: until now.
            mode: returns the flight mode's state.
        """
        while effect := self.authority.effect_due(now):
            state = mode()
            flying = FlightMode(int(state.mode))
            wish = commanded(wish, AT_REST[:3], 0.0)
            wish = requested(wish, Request[effect.name], 0.0, flying, state.serial)
            self._applied.append(Applied(now, self.authority.effect_by, effect))
        last: Command | None = None
        moves = False
        while self._commands:
            command = self._commands.popleft()
            try:
                flown = self.authority.command(command, now)
            except DeniedError as error:
                self.refuse(command, error)
                continue
            if flown.scaled:
                refusal = Refused(command.peer, command.seq, "scaled", flown.scaled)
                self._refused.append(refusal)
            last = flown
            moves = self.moves(*flown.velocity, flown.yaw_rate) or moves
        if last is None:
            return wish
        aborts = moves and int((state := mode()).mode) == FlightMode.LANDING
        if aborts:
            landing = Request.ABORT_LANDING
            wish = requested(wish, landing, HOLD_HERE, FlightMode.LANDING, state.serial)
        asked = commanded(wish, last.velocity, last.yaw_rate)
        if asked == wish and not aborts:  # only repeated, or -0.0 for 0.0: it renews, no more
            return wish
        self._applied.append(Applied(now, self.authority.state(now).name, last, aborts))
        return asked


class CommandBridge(Pilot):
    """A pilot whose commands may come from the network, through a mailbox.

    Input port:
        mode (10): see `flight_mode.ModeState`.
    """

    def __init__(self, bridge: Bridge, *, period: float, physics_step: float) -> None:
        """Declare the update.

        It is unrestricted, as Drake does such updates before the discrete ones of the same time: a
        command is flown by the control update that follows at once, as a script's action is. An
        update at any other time would end a step of the integrator there, and a flight with a
        bridge would not be that of its scenario to the bit.

        Args:
            bridge: where commands wait.
            period: between control updates [s].
            physics_step: of which all times are multiples [s].
        """
        super().__init__()
        self._bridge = bridge
        self._step = physics_step
        self._mode = self.DeclareVectorInputPort("mode", len(ModeState._fields))
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._update)

    def _update(self, context: Context, state: State) -> None:
        step = round(context.get_time() / self._step)
        if step in self._bridge.scripted:  # a repeated flight would apply a command before it
            return
        before = self.wish(context)
        wish = self._bridge.decide(
            self._step * step, before, lambda: ModeState(*self._mode.Eval(context).tolist())
        )
        if wish is not before:
            self.write(state.get_mutable_discrete_state(), wish)
