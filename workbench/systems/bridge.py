"""The bridge between a flight and the network: commands in, samples out, without blocking.

`CommandBridge` applies commands just before a control update, `Telemetry` publishes; both are
LeafSystems. They share `Bridge` with the connection to the server.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from pydrake.systems.framework import Context, State

from workbench.control.flight_mode import HOLD_HEIGHT_M, ModeState
from workbench.control.mode import FlightMode, ModeRequest
from workbench.link.authority import (
    NO_HOLDER_YET,
    SCRIPT_IN_CONTROL,
    Authority,
    CommandLimits,
    DeniedError,
    SilenceEffect,
)
from workbench.link.backplane import CommandRefusal, Published, Sampled, VelocityCommand
from workbench.systems.pilot import (
    ZERO_REFERENCE,
    PilotSystem,
    with_mode_request,
    with_velocity_command,
)

MAX_WAITING_COMMANDS = 32
"""Commands that may wait for one update; then the newest replaces the previous one.

The first one stays, as it may be the neutral one that a new holder starts with. All of them may be
refused at once, so the limit is below that of a client's pending answers (64).
"""
MAX_WAITING_SAMPLES = 4096
"""Samples that may wait; older ones are dropped."""


@dataclass(frozen=True)
class AppliedCommand:
    """A command that took effect in a flight.

    Attributes:
        at: the time of the control update that flies it first [s].
        by: its sender.
        what: a command as it is flown, or the reaction to a silent holder.
        aborts: whether the command ends a landing.
    """

    at: float
    by: str
    what: VelocityCommand | SilenceEffect
    aborts: bool = False


class Bridge:
    """The network's side of one flight: control authority, and commands and samples that wait.

    Attributes:
        authority: grants control.
        wanted: whether anybody wants samples; otherwise none are made.
        settings: increases whenever a live parameter is set.
        at_once: receives each sample within the publish event, and must never block.
        scripted: physics steps at which a script acts.
        commands: the mailbox: commands of the holder for the next update.
    """

    def __init__(self) -> None:
        self.wanted = True
        self.settings = 0
        self.at_once: Callable[[Published], None] = lambda published: None
        self.scripted: frozenset[int] = frozenset()
        self.authority = Authority(CommandLimits(0.0, 0.0, 0.0))
        self._neutral = True
        self._last_ns = -1  # when something was published
        self.commands: deque[VelocityCommand] = deque()
        self._samples: deque[Sampled] = deque(maxlen=MAX_WAITING_SAMPLES)
        self._applied: list[AppliedCommand] = []
        self._refused: list[CommandRefusal] = []

    def reset(self) -> None:
        """Start a new flight: nobody has control, nothing waits."""
        self.authority.begin(0.0, NO_HOLDER_YET)
        self._neutral = True
        self._last_ns = -1
        for waiting in (self.commands, self._samples, self._applied, self._refused):
            waiting.clear()

    def parameters_changed(self, value: Callable[[str], float]) -> None:
        """Apply the present limits to commands of clients.

        Args:
            value: returns the value of a live parameter by name.
        """
        self.settings += 1
        limits = map(value, ("max_speed", "max_climb_rate", "max_yaw_rate"))
        self.authority.limits = CommandLimits(*limits)

    def script_flies(self, now: float) -> None:
        """Take control from a client: a script precedes clients, as the operator does."""
        self.authority.begin(now, SCRIPT_IN_CONTROL)

    def command(self, command: VelocityCommand, now: float) -> None:
        """Put a command of the holder into the mailbox; the next update checks it.

        Only the holder's commands enter the mailbox, so a flood from others displaces nothing.
        """
        try:
            self.authority.check(command.peer, command.lease, now)
        except DeniedError as error:
            self.refuse(command, error.code, str(error))
            return
        if len(self.commands) == MAX_WAITING_COMMANDS:
            self.commands.pop()
        self.commands.append(command)

    def refuse(self, command: VelocityCommand, code: str, reason: str) -> None:
        """Tell the client that a command is refused, or reduced."""
        self._refused.append(CommandRefusal(command.peer, command.seq, code, reason))

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

    def apply(
        self, now: float, by: str, what: VelocityCommand | SilenceEffect, *, aborts: bool = False
    ) -> None:
        """Note that a command, or an effect of silence, takes effect at a time [s]."""
        self._applied.append(AppliedCommand(now, by, what, aborts))

    @property
    def has_landed(self) -> bool:
        """Whether silence has landed the drone since the last call of `applied`."""
        return any(each.what is SilenceEffect.LAND for each in self._applied)

    def applied(self) -> list[AppliedCommand]:
        """Return the commands that took effect since the last call."""
        applied, self._applied = self._applied, []
        return applied

    def refused(self) -> list[CommandRefusal]:
        """Return the commands that were refused or reduced since the last call."""
        refused, self._refused = self._refused, []
        return refused

    def moves(self, *command: float) -> bool:
        """Store velocity and yaw rate of a pilot; return whether a stick leaves neutral.

        That ends a landing. A command that continues from before the landing does not.
        """
        before, self._neutral = self._neutral, not any(command)
        return before and not self._neutral


class CommandBridge(PilotSystem):
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
        """Fly the effects of silence that are due, then the newest command that may fly."""
        bridge, step = self._bridge, round(context.get_time() / self._step)
        if step in bridge.scripted:  # a repeated flight would apply a command before it
            return
        now = self._step * step
        before = command = self.command(context)
        while effect := bridge.authority.effect_due(now):
            mode = self._mode_state(context)
            command = with_velocity_command(command, ZERO_REFERENCE[:3], 0.0)
            flying = FlightMode(int(mode.mode))
            command = with_mode_request(command, ModeRequest[effect.name], 0.0, flying, mode.serial)
            bridge.apply(now, bridge.authority.effect_by, effect)
        last: VelocityCommand | None = None
        moves = False
        while bridge.commands:
            received = bridge.commands.popleft()
            try:
                last = bridge.authority.command(received, now)
            except DeniedError as error:
                bridge.refuse(received, error.code, str(error))
                continue
            if last.scaled:
                bridge.refuse(received, "scaled", last.scaled)
            moves = bridge.moves(*last.velocity, last.yaw_rate) or moves
        if last is not None:
            mode = self._mode_state(context)
            aborts = moves and int(mode.mode) == FlightMode.LANDING
            if aborts:
                command = with_mode_request(
                    command,
                    ModeRequest.ABORT_LANDING,
                    HOLD_HEIGHT_M,
                    FlightMode.LANDING,
                    mode.serial,
                )
            asked = with_velocity_command(command, last.velocity, last.yaw_rate)
            # what is only repeated, or is -0.0 for 0.0, renews, and no more
            if asked != command or aborts:
                bridge.apply(now, bridge.authority.state(now).name, last, aborts=aborts)
                command = asked
        if command is not before:
            self.write(state.get_mutable_discrete_state(), command)

    def _mode_state(self, context: Context) -> ModeState:
        return ModeState(*self._mode.Eval(context).tolist())
