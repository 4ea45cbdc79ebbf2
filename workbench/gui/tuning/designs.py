"""The designs that can be compared: the sets of gains there are, and other controllers."""

from collections.abc import Mapping
from dataclasses import dataclass

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.control.controller import COMMON, LIMITS
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.flight_model import FlightModel
from workbench.gui.gains.gain_editor import SLOTS
from workbench.gui.gains.gain_rows import controller_gains
from workbench.gui.home.cards import simulated_text
from workbench.gui.tuning.gains_text import gains_list, gains_text
from workbench.gui.tuning.other_controllers import OtherControllers, controller_label
from workbench.gui.tuning.trial import Trial
from workbench.scenario.parameters import OTHERS, SIGNAL_PATH

KEPT, FLOWN, PROPOSED, TRIED = "kept", "flown", "proposed", "tried"
NAMES = (KEPT, FLOWN, PROPOSED, *SLOTS)
"""Of the sets of gains, in the order in which they stand beside each other."""
STROKES = {
    FLOWN: (CurveStyle.SOLID, 0),
    PROPOSED: (CurveStyle.DASHED, 1),
    KEPT: (CurveStyle.SOLID, 2),
    "A": (CurveStyle.SOLID, 3),
    "B": (CurveStyle.SOLID, 4),
    "C": (CurveStyle.SOLID, 5),
}
"""Style and colour of each set, those of the response for flown and predicted."""
OTHER_COLOURS = (6, 7, 0, 2, 3, 4, 5)
"""Of the other controllers, dashed: no two of seven are alike, and none is like a set."""
SHARED = frozenset(row.name for row in COMMON if row.group == LIMITS) | frozenset(
    row.name for row in OTHERS if row.system in SIGNAL_PATH
)
"""Limits, filters and estimators: they stay as they are when another controller takes over."""
MOST = 300
"""Changes of what flies that are remembered."""
Key = tuple[str, tuple[tuple[str, float], ...]]


@dataclass(frozen=True)
class Design:
    """A controller and its gains.

    Attributes:
        name: everywhere on the screen.
        gains: that are judged, by name; of another controller those that all have.
        style: of its curves.
        colour: of its curves, their number.
        controller: another one than flies, with its own gains; "" for the one that flies.
        short: by which gains it differs from the kept ones, in few words.
        long: the same, a line for each gain, and when it flew.
    """

    name: str
    gains: Mapping[str, float]
    style: CurveStyle
    colour: int
    controller: str = ""
    short: str = ""
    long: tuple[str, ...] = ()

    @property
    def key(self) -> Key:
        """What decides how it flies."""
        return self.controller, tuple(sorted(self.gains.items()))


@dataclass(frozen=True)
class Flown:
    """Gains that flew from a simulated time [s] on, and the controller whose they are."""

    since: float
    controller: str
    gains: Mapping[str, float]


class Designs(QObject):
    """Knows the designs there are, and when each flew.

    Args:
        flight: whose gains are tuned.
        trial: what is tried.
        parent: the Qt parent; this object is deleted with it.
    """

    changed = pyqtSignal()
    """One is other now, or there are more or fewer."""

    def __init__(self, flight: FlightModel, trial: Trial, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._flight, self._trial = flight, trial
        self._others = OtherControllers(flight)
        self._flown: list[Flown] = []
        trial.changed.connect(self._follow)
        trial.gains.state_changed.connect(self._follow)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all sets that have gains, and of the controllers that do not fly."""
        return (*self._sets(), *self._others.names)

    def all(self) -> tuple[Design, ...]:
        """Return all designs, in their order; none before a flight has begun."""
        sets = self._sets()
        if not sets:
            return ()
        made = [self._of_gains(name, values) for name, values in sets.items()]
        return (*made, *map(self._of_controller, self._others.names))

    def begin(self) -> None:
        """Forget when gains flew: another flight begins."""
        self._flown = []
        self.take_over()

    def take_over(self) -> None:
        """Take note of the controller that flies now."""
        self._others.note_flight()
        self._follow()

    def profile(self, name: str) -> dict[str, float]:
        """Return the values of a set that its profile has."""
        gains = self._trial.gains
        stored = {KEPT: gains.kept, PROPOSED: gains.proposed_profile, **gains.slots}
        return dict(stored[name]) if name in stored else gains.ordered_profile

    def differs(self, gains: Mapping[str, float]) -> str:
        """Return in few words by which gains a set differs from the kept ones."""
        kept = controller_gains(self._trial.gains.kept)
        return gains_text(gains, kept, same="as kept", most=1)

    def flight_name(self, time: float, gains: Mapping[str, float]) -> str:
        """Return how gains are called that flew at a simulated time [s], and when that was.

        By the slot or the kept set that has the same gains now, else as tried, with what differs
        from the kept ones; by their controller where that is another one now.
        """
        before = [each for each in self._flown if each.since <= time]
        controller = before[-1].controller if before else self._others.present
        name, note = TRIED, ""
        if controller != self._others.present:
            name = controller_label(controller)
        else:
            for each, values in self._sets().items():
                if each not in (FLOWN, PROPOSED) and values == gains:
                    name = each
                    break
            else:
                note = f" ({self.differs(gains)})"
        return f"{name} at {simulated_text(time, 1)}{note}"

    def gains_list(self, gains: Mapping[str, float]) -> tuple[str, ...]:
        """Return a line for each gain by which a set differs from the kept ones."""
        kept = controller_gains(self._trial.gains.kept)
        return gains_list(gains, kept) or ("gains as kept",)

    def _sets(self) -> dict[str, dict[str, float]]:
        """Return the controller's gains of each set that there is, by its name."""
        gains, flown = self._trial.gains, self._trial.flown
        if not flown:
            return {}
        stored = {KEPT: gains.kept, **gains.slots}
        # filters are no part of a profile: they stay
        found = {name: flown | controller_gains(values) for name, values in stored.items()}
        found |= {FLOWN: flown, PROPOSED: self._trial.proposed}
        return {name: found[name] for name in NAMES if name in found}

    def _of_gains(self, name: str, values: Mapping[str, float]) -> Design:
        differs = self.gains_list(values) if name != KEPT else ()
        return Design(
            name,
            self._trial.gains.of_set(values),
            *STROKES[name],
            short="" if name == KEPT else self.differs(values),
            long=(*differs, self._when(values)),
        )

    def _of_controller(self, name: str) -> Design:
        colour = OTHER_COLOURS[self._others.all.index(name) % len(OTHER_COLOURS)]
        gains = {key: value for key, value in self._trial.flown.items() if key in SHARED}
        said = f"The controller {name}, with its own gains for this vehicle"
        return Design(
            controller_label(name),
            gains,
            CurveStyle.DASHED,
            colour,
            name,
            "own gains",
            (said, "limits and filters as they fly"),
        )

    def _follow(self) -> None:
        """Take note of what flies now."""
        flown, view = self._trial.flown, self._flight.view
        present = self._others.present
        last = self._flown[-1] if self._flown else None
        if flown and (last is None or last.gains != flown or last.controller != present):
            time = view.snapshot.time if view.snapshot is not None else 0.0
            self._flown = [*self._flown[1 - MOST :], Flown(time, present, flown)]
        self.changed.emit()

    def _when(self, values: Mapping[str, float]) -> str:
        """Return when gains flew last, in words."""
        present = self._others.present
        ends = [*(each.since for each in self._flown[1:]), None]
        for each, end in reversed([*zip(self._flown, ends, strict=True)]):
            if each.controller == present and each.gains == values:
                since = simulated_text(each.since, 1)
                if end is None:
                    return f"flies since {since}"
                return f"flew from {since} to {simulated_text(end, 1)}"
        return "has not flown"
