"""What a pilot does in a live flight: one thing each, so that it is done whole or refused whole.

Each knows itself as a script's `Action`, so that a live flight can be repeated as a script.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING

from workbench.scenario import Action, Gust, Push

if TYPE_CHECKING:
    from workbench.session import Session

Triple = tuple[float, float, float]


class Act(ABC):
    """Something a pilot does."""

    @abstractmethod
    def do(self, session: Session) -> None:
        """Do it now; a WorkbenchError says why not."""

    @abstractmethod
    def action(self, at: float) -> Action:
        """Return it as a script has it, at a time [s]."""


@dataclass(frozen=True)
class SetParameter(Act):
    """Give a live parameter a value."""

    name: str
    value: float

    def do(self, session: Session) -> None:
        session.set(self.name, self.value)

    def action(self, at: float) -> Action:
        return Action(at, set={self.name: self.value})


@dataclass(frozen=True)
class Command(Act):
    """Ask for a velocity in W [m/s] and a yaw rate [rad/s]; what is None stays."""

    velocity: Triple | None
    yaw_rate: float | None

    def do(self, session: Session) -> None:
        session.command(self.velocity, self.yaw_rate)

    def action(self, at: float) -> Action:
        velocity = None if self.velocity is None else list(self.velocity)
        return Action(at, velocity=velocity, yaw_rate=self.yaw_rate)


@dataclass(frozen=True)
class GoTo(Act):
    """Ask for a place in W [m]."""

    p_WB: Triple

    def do(self, session: Session) -> None:
        session.go_to(self.p_WB)

    def action(self, at: float) -> Action:
        return Action(at, go_to=list(self.p_WB))


@dataclass(frozen=True)
class RequestMode(Act):
    """Ask the flight mode to arm, take_off to a height [m], land or stop."""

    what: str
    height: float

    def do(self, session: Session) -> None:
        session.request(self.what, self.height)

    def action(self, at: float) -> Action:
        return Action(at, request=self.what, height=self.height)


@dataclass(frozen=True)
class Blow(Act):
    """Let a gust rise to a velocity in W [m/s] and fall, within a duration [s]."""

    velocity: Triple
    duration: float

    def do(self, session: Session) -> None:
        session.gust(self.velocity, self.duration)

    def action(self, at: float) -> Action:
        return Action(at, gust=Gust(list(self.velocity), self.duration))


@dataclass(frozen=True)
class Shove(Act):
    """Push with a force in W [N] at a point in B [m] for a duration [s]."""

    force: Triple
    point: Triple
    duration: float

    def do(self, session: Session) -> None:
        session.push(self.force, self.point, self.duration)

    def action(self, at: float) -> Action:
        return Action(at, push=Push(list(self.force), list(self.point), self.duration))
