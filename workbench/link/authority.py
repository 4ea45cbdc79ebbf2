"""Who flies: one lease, a ladder for a holder that falls silent, and the operator above all.

Time is simulated and told by the caller, so that a flight in slow motion, or one that stands, is
no reason to take the drone from anybody.
"""

import math
import secrets
import struct
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum

from workbench.link.backplane import Command
from workbench.link.codes import DeniedError
from workbench.link.drone_topics import AXES
from workbench.link.messages import ControlState, Hand, Stage

HOLD_AFTER = 0.5
"""Silence after which the drone holds its place, and the lease is renewed no longer [s]."""
LOST_AFTER = 2.0
"""Silence after which anybody may ask for control [s]."""
LAND_AFTER = 5.0
"""Silence after which the drone lands, unless somebody else flies it by then [s]."""
OLDEST_STATE = 1.0
"""A command that acts on an older state is dropped [s]."""
LADDER = "link"
"""Who does what nobody asked for: the ladder of silence."""
NOBODY_YET = "nobody has asked for control yet"
"""Why nobody flies at first."""
SCRIPT_FLIES = "the scenario's script flies"
"""Why a client that flew does so no longer: what a scenario says comes before clients."""
TOO_FAST = 2.0
"""A command beyond a limit by this factor is refused; up to it, it is scaled."""


class Effect(Enum):
    """What the ladder does to the flight."""

    HOLD = "hold"
    LAND = "land"


@dataclass(frozen=True)
class Limits:
    """Largest level speed, climb rate [m/s] and yaw rate [rad/s]."""

    level: float
    climb: float
    turn: float

    def as_sent(self) -> "Limits":
        """Return them as a field of 32 bits has them, so that the limit itself may be asked for."""
        return Limits(*struct.unpack("<3f", struct.pack("<3f", self.level, self.climb, self.turn)))


def new_lease() -> int:
    """Return a number that nobody guesses, never 0."""
    return secrets.randbelow(2**32 - 1) + 1


class Authority:
    """Grants and takes the lease, and judges commands.

    Args:
        limits: of what may be asked for; may be replaced while flying.
        lease: makes numbers of leases.

    Attributes:
        limits: see above.
        effect_by: who caused the effect that was told last: a client's name, or `LADDER`.
    """

    def __init__(self, limits: Limits, lease: Callable[[], int] = new_lease) -> None:
        self.limits = limits
        self.effect_by = LADDER
        self._new_lease = lease
        self.begin(0.0, NOBODY_YET)

    def begin(self, now: float, reason: str) -> None:
        """Let nobody fly from now on [s]."""
        self._hand, self._peer, self._name, self._lease = Hand.NOBODY, 0, "", 0
        self._stage, self._reason = Stage.LIVE, reason
        self._since = now
        self._hold_due = self._land_due = self._neutral_due = False
        self._hold_by = LADDER

    def request(self, peer: int, name: str, now: float) -> int:
        """Grant control to a client, and return the number of its lease.

        Raises:
            DeniedError: while somebody else flies.
        """
        self._climb(now)
        if self._hand is Hand.OPERATOR:
            raise DeniedError(
                "held", "the operator at the screen flies: wait until the drone is given"
            )
        if self._hand is Hand.CLIENT and (self._peer != peer or self._stage is Stage.LIVE):
            who = "you fly already" if self._peer == peer else f"{self._who()} flies"
            raise DeniedError("held", f"{who}: ask again when control is released or lost")
        self.begin(now, f"{name or f'client {peer}'} took control")
        self._hand, self._peer, self._name = Hand.CLIENT, peer, name
        self._lease = self._new_lease()
        self._hold_due = self._neutral_due = True
        self._hold_by = name or f"client {peer}"
        return self._lease

    def release(self, now: float) -> None:
        """Let the holder give control back; the drone holds its place."""
        who = self._who()
        self.begin(now, f"{who} released control")
        self._hold_due, self._hold_by = True, who

    def gone(self, peer: int) -> None:
        """Take control from a client whose connection ended; the ladder goes on without it."""
        if self._hand is not Hand.CLIENT or self._peer != peer:
            return
        if self._stage is Stage.LIVE:
            self._hold_due, self._hold_by = True, LADDER
        self._lose(f"the connection of {self._who()} ended")

    def check(self, peer: int, lease: int, now: float) -> None:
        """Refuse what only the holder may do: the one place where a lease is looked at.

        Raises:
            DeniedError: if a client is not the holder, or has been silent too long.
        """
        self._climb(now)
        if self._hand is Hand.CLIENT and self._peer == peer and self._lease == lease != 0:
            return
        if self._hand is Hand.CLIENT and self._peer == peer and self._stage is Stage.HOLD:
            said = f"control was silent for {HOLD_AFTER:g} s: ask for it again, begin from neutral"
        elif self._hand is Hand.NOBODY:
            said = f"nobody flies, as {self._reason}: ask for control first"
        else:
            said = f"{self._who()} flies: only who holds the lease may do this"
        raise DeniedError("not_holder", said)

    def renew(self, now: float) -> None:
        """Count what the holder just did as a sign of life."""
        self._since = now

    def command(self, command: Command, now: float) -> Command:
        """Return what is flown of a command.

        Raises:
            DeniedError: if it is not flown at all; then it renews nothing.
        """
        self.check(command.peer, command.lease, now)
        flown = self._within_limits(command)
        age = now - command.t_ns * 1e-9
        if not -1e-6 <= age <= OLDEST_STATE:
            when = f"{age:.2f} s old" if age > 0.0 else f"{-age:.2f} s ahead of the flight"
            raise DeniedError(
                "stale", f"the command acts on a state that is {when}: send the newest"
            )
        if self._neutral_due and any((*flown.velocity, flown.yaw_rate)):
            raise DeniedError(
                "neutral_first", "the first command of a lease must be zero on all axes"
            )
        self._neutral_due = False
        self.renew(now)
        return flown

    def take_over(self, now: float, reason: str = "the operator took over") -> bool:
        """Let the operator at the screen fly: always granted.

        Returns:
            whether the drone is to hold now, before anything else.
        """
        if self._hand is Hand.OPERATOR:
            return False
        holds = self._hand is Hand.CLIENT or self._hold_due
        self.begin(now, reason)
        self._hand = Hand.OPERATOR
        return holds

    def effect_due(self, now: float) -> Effect | None:
        """Return what the flight has to do now [s], if anything; each is told once."""
        self._climb(now)
        if self._hold_due:
            self._hold_due, self.effect_by = False, self._hold_by
            return Effect.HOLD
        if self._land_due:
            self._land_due, self.effect_by = False, LADDER
            return Effect.LAND
        return None

    def state(self, now: float) -> ControlState:
        """Return who flies, for all to know."""
        nobody = self._hand is Hand.NOBODY and self._stage is Stage.LIVE
        return ControlState(
            hand=self._hand,
            peer=self._peer,
            name=self._name,
            stage=self._stage,
            age=math.inf if nobody else now - self._since,
            reason=self._reason,
        )

    def _climb(self, now: float) -> None:
        """Go up the ladder of silence."""
        silence = now - self._since
        if self._hand is Hand.CLIENT and self._stage is Stage.LIVE and silence >= HOLD_AFTER:
            self._stage, self._lease, self._hold_due = Stage.HOLD, 0, True
            self._hold_by = LADDER
            self._reason = f"{self._who()} was silent for {HOLD_AFTER:g} s: the drone holds"
        if self._hand is Hand.CLIENT and self._stage is Stage.HOLD and silence >= LOST_AFTER:
            self._lose(f"{self._who()} was silent for {LOST_AFTER:g} s: control is lost")
        if self._stage is Stage.LOST and silence >= LAND_AFTER:
            self._stage, self._land_due = Stage.LAND, True
            self._reason += f"; nobody flew for {LAND_AFTER:g} s: the drone lands"

    def _lose(self, reason: str) -> None:
        self._hand, self._peer, self._name, self._lease = Hand.NOBODY, 0, "", 0
        self._stage, self._reason = Stage.LOST, reason

    def _who(self) -> str:
        if self._hand is Hand.OPERATOR:
            return "the operator at the screen"
        return self._name or f"client {self._peer}"

    def _within_limits(self, command: Command) -> Command:
        """Return a command with its unused axes at zero, reduced to the limits."""
        if not all(map(math.isfinite, (*command.velocity, command.yaw_rate))):
            raise DeniedError("not_finite", "a number of the command is not finite: all must be")
        if not 1 <= command.axes <= AXES:
            raise DeniedError("no_axes", f"the command's axes are {command.axes}: set bits 0 to 3")
        used = [
            number if command.axes >> bit & 1 else 0.0
            for bit, number in enumerate((*command.velocity, command.yaw_rate))
        ]
        limits = self.limits.as_sent()
        level, level_said = _share("level speed", math.hypot(*used[:2]), limits.level, "m/s")
        climb, climb_said = _share("climb rate", abs(used[2]), limits.climb, "m/s")
        turn, turn_said = _share("yaw rate", abs(used[3]), limits.turn, "rad/s")
        return replace(
            command,
            velocity=(level * used[0], level * used[1], climb * used[2]),
            yaw_rate=turn * used[3],
            scaled=", ".join(said for said in (level_said, climb_said, turn_said) if said),
        )


def _share(name: str, asked: float, limit: float, unit: str) -> tuple[float, str]:
    """Return by what a speed is multiplied, and why if that is not 1."""
    if asked <= limit:
        return 1.0, ""
    said = f"the {name} is {asked:.4g} {unit}, its limit {limit:.4g} {unit}"
    if asked > TOO_FAST * limit:
        raise DeniedError("too_fast", f"{said}: more than {TOO_FAST:g} times that is refused")
    return limit / asked, said
