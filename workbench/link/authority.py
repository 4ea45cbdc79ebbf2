"""The authority to fly: one lease, the effects of a silent holder, and the operator's priority.

Time is simulated and passed in by the caller. So a slow or paused flight does not take control from
anybody.
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
"""Silence after which the drone holds its position, and the lease cannot be renewed [s]."""
FIRST_AFTER = 1.5
"""The same until the first sign of life after a grant, as the grant and the first command need a
round trip [s]."""
LOST_AFTER = 2.0
"""Silence after which anybody may request control [s]."""
LAND_AFTER = 5.0
"""Silence after which the drone lands, unless somebody else flies it [s]."""
OLDEST_STATE = 1.0
"""Largest age of the state that a command acts on; an older one is dropped [s]."""
LADDER = "link"
"""Name for the cause of effects of silence."""
NOBODY_YET = "nobody has requested control yet"
"""The reason why nobody flies at first."""
SCRIPT_FLIES = "the scenario's script flies"
"""The reason for a client's loss of control to the script of the scenario."""
TOO_FAST = 2.0
"""A command above a limit by more than this factor is rejected; below it, it is scaled."""


class Effect(Enum):
    """The effects of silence on the flight."""

    HOLD = "hold"
    LAND = "land"


@dataclass(frozen=True)
class Limits:
    """Largest level speed, climb rate [m/s] and yaw rate [rad/s]."""

    level: float
    climb: float
    turn: float

    def as_sent(self) -> "Limits":
        """Return the limits rounded to 32 bits, so that a command may equal the limit."""
        return Limits(*struct.unpack("<3f", struct.pack("<3f", self.level, self.climb, self.turn)))


def new_lease() -> int:
    """Return a number that cannot be guessed, never 0."""
    return secrets.randbelow(2**32 - 1) + 1


class Authority:
    """Grants and revokes the lease, and checks commands.

    Args:
        limits: of commands; may be replaced in flight.
        lease: creates numbers of leases.

    Attributes:
        limits: see above.
        effect_by: cause of the last effect: the name of a client, or `LADDER`.
    """

    def __init__(self, limits: Limits, lease: Callable[[], int] = new_lease) -> None:
        self.limits = limits
        self.effect_by = LADDER
        self._new_lease = lease
        self.begin(0.0, NOBODY_YET)

    def begin(self, now: float, reason: str) -> None:
        """Start at a time [s], with nobody in control."""
        self._hand, self._peer, self._name, self._lease = Hand.NOBODY, 0, "", 0
        self._stage, self._reason = Stage.LIVE, reason
        self._since, self._hold_after = now, HOLD_AFTER
        self._hold_due = self._land_due = self._neutral_due = False
        self._hold_by = LADDER

    def request(self, peer: int, name: str, now: float) -> int:
        """Grant control to a client, and return its lease number.

        Raises:
            DeniedError: while somebody else flies.
        """
        self._climb(now)
        if self._hand is Hand.OPERATOR:
            raise DeniedError(
                "held", "the operator at the screen flies: wait until control is given back"
            )
        if self._hand is Hand.CLIENT and (self._peer != peer or self._stage is Stage.LIVE):
            who = "you fly already" if self._peer == peer else f"{self._who()} flies"
            raise DeniedError("held", f"{who}: ask again when control is released or lost")
        self.begin(now, f"{name or f'client {peer}'} took control")
        self._hand, self._peer, self._name = Hand.CLIENT, peer, name
        self._lease = self._new_lease()
        self._hold_due = self._neutral_due = True
        self._hold_after = FIRST_AFTER
        self._hold_by = name or f"client {peer}"
        return self._lease

    def release(self, now: float) -> None:
        """Release the control of the holder; the drone holds its position."""
        who = self._who()
        self.begin(now, f"{who} released control")
        self._hold_due, self._hold_by = True, who

    def gone(self, peer: int) -> None:
        """Take control from a disconnected client; the effects of silence continue."""
        if self._hand is not Hand.CLIENT or self._peer != peer:
            return
        if self._stage is Stage.LIVE:
            self._hold_due, self._hold_by = True, LADDER
        self._lose(f"the connection of {self._who()} ended")

    def check(self, peer: int, lease: int, now: float) -> None:
        """Check that a client holds the lease; leases are checked only here.

        Raises:
            DeniedError: if a client is not the holder, or has been silent too long.
        """
        self._climb(now)
        if self._hand is Hand.CLIENT and self._peer == peer and self._lease == lease != 0:
            return
        if self._hand is Hand.CLIENT and self._peer == peer and self._stage is Stage.HOLD:
            silence = f"control was silent for {self._hold_after:g} s"
            said = f"{silence}: ask for it again, begin from neutral"
        elif self._hand is Hand.NOBODY:
            said = f"nobody flies, because {self._reason}: ask for control first"
        else:
            said = f"{self._who()} flies: only the client with the lease may do this"
        raise DeniedError("not_holder", said)

    def renew(self, now: float) -> None:
        """Count an action of the holder as a sign of life."""
        self._since, self._hold_after = now, HOLD_AFTER

    def command(self, command: Command, now: float) -> Command:
        """Return the command to fly for a requested one.

        Raises:
            DeniedError: if it is rejected; it then does not renew the lease.
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
        """Give control to the operator at the screen; this is always granted.

        Returns:
            Whether the drone must first hold its position.
        """
        if self._hand is Hand.OPERATOR:
            return False
        holds = self._hand is Hand.CLIENT or self._hold_due
        self.begin(now, reason)
        self._hand = Hand.OPERATOR
        return holds

    def effect_due(self, now: float) -> Effect | None:
        """Return the effect due at a time [s], if any; each is returned once."""
        self._climb(now)
        if self._hold_due:
            self._hold_due, self.effect_by = False, self._hold_by
            return Effect.HOLD
        if self._land_due:
            self._land_due, self.effect_by = False, LADDER
            return Effect.LAND
        return None

    def state(self, now: float) -> ControlState:
        """Return who flies, to broadcast it."""
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
        """Advance the stages of silence."""
        silence = now - self._since
        limit = self._hold_after
        if self._hand is Hand.CLIENT and self._stage is Stage.LIVE and silence >= limit:
            self._stage, self._lease, self._hold_due = Stage.HOLD, 0, True
            self._hold_by = LADDER
            self._reason = f"{self._who()} was silent for {limit:g} s: the drone holds"
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
    """Return the factor on a speed, and the reason if it is not 1."""
    if asked <= limit:
        return 1.0, ""
    said = f"the {name} is {asked:.4g} {unit}, its limit {limit:.4g} {unit}"
    if asked > TOO_FAST * limit:
        raise DeniedError("too_fast", f"{said}: more than {TOO_FAST:g} times the limit is refused")
    return limit / asked, said
