"""A pilot's orders as methods, for a flight of any kind: each is an `Action`."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Generic, TypeVar, cast

from workbench.scenario.scenario import Action, AttitudeSetpoint, Gust, Push

Answer = TypeVar("Answer")


class PilotOrders(ABC, Generic[Answer]):
    """A flight that takes an `Action`, and a method for each order that it may have.

    Numbers and names are checked where the action takes effect.
    """

    @abstractmethod
    def do(self, action: Action, /) -> Answer:
        """Execute an action now; its `at` is ignored."""

    def set(self, name: str, value: float) -> Answer:
        """Set a live parameter; it takes effect at the next control update."""
        return self.do(Action(set={str(name): value}))

    def set_all(self, values: Mapping[str, float]) -> Answer:
        """Set live parameters by name at one step; if one is refused, none is set."""
        return self.do(Action(set={str(name): value for name, value in values.items()}))

    def command(
        self, velocity: Sequence[float] | None = None, yaw_rate: float | None = None
    ) -> Answer:
        """Command a velocity in W [m/s] and a yaw rate [rad/s]; None leaves a value unchanged."""
        wanted = None if velocity is None else _unchecked(velocity)
        return self.do(Action(velocity=wanted, yaw_rate=yaw_rate))

    def attitude(
        self,
        roll: float | None = None,
        pitch: float | None = None,
        roll_rate: float | None = None,
        pitch_rate: float | None = None,
    ) -> Answer:
        """Give setpoints of attitude [rad] or rates [rad/s] in place of those of the loops outside.

        Without any, those of the loops outside return.
        """
        return self.do(Action(setpoint=AttitudeSetpoint(roll, pitch, roll_rate, pitch_rate)))

    def go_to(self, p_WB: Sequence[float]) -> Answer:
        """Fly to a position in W [m] and stay there."""
        return self.do(Action(go_to=_unchecked(p_WB)))

    def request(self, what: str, height: float = Action.height) -> Answer:
        """Request arm, take_off (to a height [m]), hold, land, or stop (at once).

        In a landing only "stop" and "abort_landing" have an effect. The latter climbs to the
        height, or holds the position if the drone is higher.
        """
        return self.do(Action(request=str(what), height=height))

    def gust(self, velocity: Sequence[float], duration: float = 1.0) -> Answer:
        """Start a gust that rises to a velocity in W [m/s] and falls, within a duration [s].

        It is added to the wind, and replaces a gust that has not ended.
        """
        return self.do(Action(gust=Gust(_unchecked(velocity), duration)))

    def push(
        self,
        force: Sequence[float],
        point: Sequence[float] = (0.0, 0.0, 0.0),
        duration: float = 0.1,
        torque: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> Answer:
        """Push with a force in W [N] at a point of the body, in B [m], and a torque in B [N·m].

        It starts with the next control update, lasts for a duration [s], and replaces a push that
        has not ended.
        """
        push = Push(_unchecked(force), _unchecked(point), duration, _unchecked(torque))
        return self.do(Action(push=push))


def _unchecked(numbers: Sequence[float]) -> list[float]:
    """Return numbers for `checked_action`, which refuses wrong ones, as None."""
    return cast(list[float], [None] if numbers is None else numbers)
