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

from workbench.link.backplane import VelocityCommand
from workbench.link.codes import DeniedError
from workbench.link.drone_topics import ALL_COMMAND_AXES
from workbench.link.messages import ControlOwner, ControlState, LinkLossStage

HOLD_AFTER_S = 0.5
"""Silence after which the drone holds its position, and the lease cannot be renewed [s]."""
FIRST_HOLD_AFTER_S = 1.5
"""The same until the first sign of life after a grant, as the grant and the first command need a
round trip [s]."""
LOST_AFTER_S = 2.0
"""Silence after which anybody may request control [s]."""
LAND_AFTER_S = 5.0
"""Silence after which the drone lands, unless somebody else flies it [s]."""
MAX_STATE_AGE_S = 1.0
"""Largest age of the state that a command acts on; an older one is dropped [s]."""
SILENCE_CAUSE = "link"
"""Name for the cause of effects of silence."""
NO_HOLDER_YET = "nobody has requested control yet"
"""The reason why nobody flies at first."""
SCRIPT_IN_CONTROL = "the scenario's script flies"
"""The reason for a client's loss of control to the script of the scenario."""
MAX_SPEED_EXCESS = 2.0
"""A command above a limit by more than this factor is rejected; below it, it is scaled."""


class SilenceEffect(Enum):
    """The effects of silence on the flight."""

    HOLD = "hold"
    LAND = "land"


@dataclass(frozen=True)
class CommandLimits:
    """Largest level speed, climb rate [m/s] and yaw rate [rad/s]."""

    level: float
    climb: float
    turn: float

    def as_sent(self) -> "CommandLimits":
        """Return the limits rounded to 32 bits, so that a command may equal the limit."""
        return CommandLimits(
            *struct.unpack("<3f", struct.pack("<3f", self.level, self.climb, self.turn))
        )


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
        effect_by: cause of the last effect: the name of a client, or `SILENCE_CAUSE`.
    """

    def __init__(self, limits: CommandLimits, lease: Callable[[], int] = new_lease) -> None:
        self.limits = limits
        self.effect_by = SILENCE_CAUSE
        self._new_lease = lease
        self.begin(0.0, NO_HOLDER_YET)

    def begin(self, now: float, reason: str) -> None:
        """Start at a time [s], with nobody in control."""
        self._hand, self._peer, self._name, self._lease = ControlOwner.NOBODY, 0, "", 0
        self._stage, self._reason = LinkLossStage.LIVE, reason
        self._since, self._hold_after = now, HOLD_AFTER_S
        self._hold_due = self._land_due = self._neutral_due = False
        self._hold_by = SILENCE_CAUSE

    def request(self, peer: int, name: str, now: float) -> int:
        """Grant control to a client, and return its lease number.

        Raises:
            DeniedError: while somebody else flies.
        """
        self._climb(now)
        if self._hand is ControlOwner.OPERATOR:
            raise DeniedError(
                "held", "the operator at the screen flies: wait until control is given back"
            )
        if self._hand is ControlOwner.CLIENT and (
            self._peer != peer or self._stage is LinkLossStage.LIVE
        ):
            who = "you fly already" if self._peer == peer else f"{self._who()} flies"
            raise DeniedError("held", f"{who}: ask again when control is released or lost")
        self.begin(now, f"{name or f'client {peer}'} took control")
        self._hand, self._peer, self._name = ControlOwner.CLIENT, peer, name
        self._lease = self._new_lease()
        self._hold_due = self._neutral_due = True
        self._hold_after = FIRST_HOLD_AFTER_S
        self._hold_by = name or f"client {peer}"
        return self._lease

    def release(self, now: float) -> None:
        """Release the control of the holder; the drone holds its position."""
        who = self._who()
        self.begin(now, f"{who} released control")
        self._hold_due, self._hold_by = True, who

    def gone(self, peer: int) -> None:
        """Take control from a disconnected client; the effects of silence continue."""
        if self._hand is not ControlOwner.CLIENT or self._peer != peer:
            return
        if self._stage is LinkLossStage.LIVE:
            self._hold_due, self._hold_by = True, SILENCE_CAUSE
        self._lose(f"the connection of {self._who()} ended")

    def check(self, peer: int, lease: int, now: float) -> None:
        """Check that a client holds the lease; leases are checked only here.

        Raises:
            DeniedError: if a client is not the holder, or has been silent too long.
        """
        self._climb(now)
        if self._hand is ControlOwner.CLIENT and self._peer == peer and self._lease == lease != 0:
            return
        if (
            self._hand is ControlOwner.CLIENT
            and self._peer == peer
            and self._stage is LinkLossStage.HOLD
        ):
            silence = f"control was silent for {self._hold_after:g} s"
            said = f"{silence}: ask for it again, begin from neutral"
        elif self._hand is ControlOwner.NOBODY:
            said = f"nobody flies, because {self._reason}: ask for control first"
        else:
            said = f"{self._who()} flies: only the client with the lease may do this"
        raise DeniedError("not_holder", said)

    def renew(self, now: float) -> None:
        """Count an action of the holder as a sign of life."""
        self._since, self._hold_after = now, HOLD_AFTER_S

    def command(self, command: VelocityCommand, now: float) -> VelocityCommand:
        """Return the command to fly: unused axes at zero, and reduced to the limits.

        Raises:
            DeniedError: if it is rejected; it then does not renew the lease.
        """
        self.check(command.peer, command.lease, now)
        if not all(map(math.isfinite, (*command.velocity, command.yaw_rate))):
            raise DeniedError("not_finite", "a number of the command is not finite: all must be")
        if not 1 <= command.axes <= ALL_COMMAND_AXES:
            raise DeniedError("no_axes", f"the command's axes are {command.axes}: set bits 0 to 3")
        used = [
            number if command.axes >> bit & 1 else 0.0
            for bit, number in enumerate((*command.velocity, command.yaw_rate))
        ]
        limits = self.limits.as_sent()
        level, level_said = _speed_factor("level speed", math.hypot(*used[:2]), limits.level, "m/s")
        climb, climb_said = _speed_factor("climb rate", abs(used[2]), limits.climb, "m/s")
        turn, turn_said = _speed_factor("yaw rate", abs(used[3]), limits.turn, "rad/s")
        age = now - command.t_ns * 1e-9
        if not -1e-6 <= age <= MAX_STATE_AGE_S:
            when = f"{age:.2f} s old" if age > 0.0 else f"{-age:.2f} s ahead of the flight"
            raise DeniedError(
                "stale", f"the command acts on a state that is {when}: send the newest"
            )
        if self._neutral_due and any(used):
            raise DeniedError(
                "neutral_first", "the first command of a lease must be zero on all axes"
            )
        self._neutral_due = False
        self.renew(now)
        return replace(
            command,
            velocity=(level * used[0], level * used[1], climb * used[2]),
            yaw_rate=turn * used[3],
            scaled=", ".join(said for said in (level_said, climb_said, turn_said) if said),
        )

    def take_over(self, now: float, reason: str = "the operator took over") -> bool:
        """Give control to the operator at the screen; this is always granted.

        Returns:
            Whether the drone must first hold its position.
        """
        if self._hand is ControlOwner.OPERATOR:
            return False
        holds = self._hand is ControlOwner.CLIENT or self._hold_due
        self.begin(now, reason)
        self._hand = ControlOwner.OPERATOR
        return holds

    def effect_due(self, now: float) -> SilenceEffect | None:
        """Return the effect due at a time [s], if any; each is returned once."""
        self._climb(now)
        if self._hold_due:
            self._hold_due, self.effect_by = False, self._hold_by
            return SilenceEffect.HOLD
        if self._land_due:
            self._land_due, self.effect_by = False, SILENCE_CAUSE
            return SilenceEffect.LAND
        return None

    def state(self, now: float) -> ControlState:
        """Return who flies, to broadcast it."""
        nobody = self._hand is ControlOwner.NOBODY and self._stage is LinkLossStage.LIVE
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
        if (
            self._hand is ControlOwner.CLIENT
            and self._stage is LinkLossStage.LIVE
            and silence >= limit
        ):
            self._stage, self._lease, self._hold_due = LinkLossStage.HOLD, 0, True
            self._hold_by = SILENCE_CAUSE
            self._reason = f"{self._who()} was silent for {limit:g} s: the drone holds"
        if (
            self._hand is ControlOwner.CLIENT
            and self._stage is LinkLossStage.HOLD
            and silence >= LOST_AFTER_S
        ):
            self._lose(f"{self._who()} was silent for {LOST_AFTER_S:g} s: control is lost")
        if self._stage is LinkLossStage.LOST and silence >= LAND_AFTER_S:
            self._stage, self._land_due = LinkLossStage.LAND, True
            self._reason += f"; nobody flew for {LAND_AFTER_S:g} s: the drone lands"

    def _lose(self, reason: str) -> None:
        self._hand, self._peer, self._name, self._lease = ControlOwner.NOBODY, 0, "", 0
        self._stage, self._reason = LinkLossStage.LOST, reason

    def _who(self) -> str:
        if self._hand is ControlOwner.OPERATOR:
            return "the operator at the screen"
        return self._name or f"client {self._peer}"


def _speed_factor(name: str, asked: float, limit: float, unit: str) -> tuple[float, str]:
    """Return the factor on a speed, and the reason if it is not 1."""
    if asked <= limit:
        return 1.0, ""
    said = f"the {name} is {asked:.4g} {unit}, its limit {limit:.4g} {unit}"
    if asked > MAX_SPEED_EXCESS * limit:
        raise DeniedError(
            "too_fast", f"{said}: more than {MAX_SPEED_EXCESS:g} times the limit is refused"
        )
    return limit / asked, said
