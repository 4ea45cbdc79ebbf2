"""The designs that can be compared: gains and controllers, and when each flew."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.analysis.replies import Judged, JudgedLoop, Predicted
from workbench.common.plain_text import plain_name
from workbench.common.quantity import significant_text
from workbench.control.controller import COMMON_PARAMETERS, LIMITS_GROUP
from workbench.control.installed_laws import DEFAULT_CONTROLLER, installed_laws
from workbench.design.judge.gang_of_four import GangOfFour
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.flight_model import FlightModel
from workbench.gui.gains.gain_actions import GAIN_SLOTS
from workbench.gui.gains.gain_rows import controller_gains
from workbench.gui.tuning.trial import TuningTrial
from workbench.gui.units import gain_text, simulated_text
from workbench.parameters.flight_parameters import SIGNAL_PATH, flight_parameters

MAX_NAMED_GAINS = 3
"""Largest number of names in a short text."""
KEPT_SET, FLOWN_SET, PROPOSED_SET, TRIED_SET = "kept", "flown", "proposed", "tried"
GAIN_SET_NAMES = (KEPT_SET, FLOWN_SET, PROPOSED_SET, *GAIN_SLOTS)
"""Names of the sets of gains, in the order of their columns."""
GAIN_SET_STROKES = {
    FLOWN_SET: (CurveStyle.SOLID, 0),
    PROPOSED_SET: (CurveStyle.DASHED, 1),
    KEPT_SET: (CurveStyle.SOLID, 2),
    "A": (CurveStyle.SOLID, 3),
    "B": (CurveStyle.SOLID, 4),
    "C": (CurveStyle.SOLID, 5),
}
"""Style and colour of each set, like those of the response for flown and predicted."""
OTHER_CONTROLLER_COLOURS = (6, 7, 0, 2, 3, 4, 5)
"""Colours of the other controllers, dashed: seven differ from each other and from all sets."""
SHARED_PARAMETERS = frozenset(
    row.name for row in COMMON_PARAMETERS if row.group == LIMITS_GROUP
) | frozenset(row.name for row in flight_parameters() if row.system in SIGNAL_PATH)
"""Limits, filters and estimators: another controller does not change them."""
MAX_FLOWN_CHANGES = 300
"""Number of remembered changes of the flown gains."""


def controller_label(name: str) -> str:
    """Return a controller's label: the name of a shipped one, or that of its file."""
    return plain_name(Path(name).stem if name.endswith(".py") else name)


def gain_differences_text(
    gains: Mapping[str, float],
    base: Mapping[str, float],
    *,
    same: str = "gains as now",
    most: int = MAX_NAMED_GAINS,
) -> str:
    """Return the gains in which a set differs from another, as kp_pitch 180, as a short text.

    Args:
        gains: values by name.
        base: values to compare with, for the same names.
        same: text without a difference.
        most: largest number of named gains.
    """
    other = [name for name, value in gains.items() if name in base and base[name] != value]
    if not other:
        return same
    texts = [f"{name} {gain_text(gains[name])}" for name in other[:most]]
    more = len(other) - most
    return ", ".join(texts) + (f" and {more} more" if more > 0 else "")


def gain_differences_list(gains: Mapping[str, float], base: Mapping[str, float]) -> tuple[str, ...]:
    """Return a line for each gain in which a set differs from another, with both values."""
    return tuple(
        f"{name} {significant_text(value, 6)} instead of {significant_text(base[name], 6)}"
        for name, value in gains.items()
        if name in base and base[name] != value
    )


@dataclass(frozen=True)
class Design:
    """A controller and its gains.

    Attributes:
        name: its name on the screen.
        gains: gains to evaluate, by name; for another controller those that all controllers have.
        style: style of its curves.
        colour: number of its colour.
        controller: a controller other than the flying one, with its own gains; "" for the flying
            one.
        short: its differences from the kept gains, as a short text.
        long: the same with a line for each gain, and when it flew.
        predicted: its step response, None if unknown or not requested.
        judged: its margins, None if unknown.
        curves: frequency response of a loop, None if unknown or not requested.
        said: why something is unknown, "" if it is still expected.
    """

    name: str
    gains: Mapping[str, float]
    style: CurveStyle
    colour: int
    controller: str = ""
    short: str = ""
    long: tuple[str, ...] = ()
    predicted: Predicted | None = None
    judged: Judged | None = None
    curves: GangOfFour | None = None
    said: str = ""

    @property
    def label(self) -> str:
        """Its name, with its differences from the kept gains."""
        return f"{self.name} ({self.short})" if self.short else self.name

    def loop(self, name: str) -> JudgedLoop | None:
        """Return one of its loops, None if it does not exist or is unknown."""
        loops = self.judged.loops if self.judged is not None else ()
        return next((loop for loop in loops if loop.name == name), None)


class Designs(QObject):
    """The existing designs, and when each flew.

    Args:
        flight: the flight whose gains are tuned.
        trial: the gains that are being tried.
        parent: the Qt parent; this object is deleted with it.
    """

    changed = pyqtSignal()
    """A design changed, appeared or disappeared."""

    def __init__(
        self, flight: FlightModel, trial: TuningTrial, parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._flight, self._trial = flight, trial
        self._files: list[str] = []  # controllers that have flown since the window was opened
        self._flown: list[tuple[float, str, Mapping[str, float]]] = []
        trial.changed.connect(self._follow)
        trial.gains.state_changed.connect(self._follow)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all existing sets of gains, and of the controllers that do not fly."""
        return (*self._sets(), *self.others)

    @property
    def present(self) -> str:
        """The flying controller: name of a shipped one, or path of a file."""
        scenario = self._flight.view.scenario
        return scenario.controller if scenario is not None else DEFAULT_CONTROLLER

    @property
    def controllers(self) -> tuple[str, ...]:
        """Installed controllers, and files that have flown, in a fixed order."""
        return (*installed_laws(), *self._files)

    @property
    def others(self) -> tuple[str, ...]:
        """All controllers except the flying one."""
        return tuple(name for name in self.controllers if name != self.present)

    def all(self) -> tuple[Design, ...]:
        """Return all designs, in order; none before a flight has begun."""
        sets = self._sets()
        if not sets:
            return ()
        made = [self._of_gains(name, values) for name, values in sets.items()]
        return (*made, *map(self._of_controller, self.others))

    def begin(self) -> None:
        """Clear the flown gains: another flight begins."""
        self._flown = []
        self.take_over()

    def take_over(self) -> None:
        """Record the flying controller."""
        if self.present not in self.controllers:
            self._files.append(self.present)
        self._follow()

    def gains_of(self, name: str) -> dict[str, float]:
        """Return the values of a set that a gain file has."""
        gains = self._trial.gains
        stored = {KEPT_SET: gains.kept, PROPOSED_SET: gains.proposed_gains, **gains.slots}
        return dict(stored[name]) if name in stored else gains.ordered_gains

    def differs(self, gains: Mapping[str, float]) -> str:
        """Return the differences of a set from the kept gains, as a short text."""
        kept = controller_gains(self._trial.gains.kept)
        return gain_differences_text(gains, kept, same="as kept", most=1)

    def flight_name(self, time: float, gains: Mapping[str, float]) -> str:
        """Return the name of the gains that flew at a simulated time [s], and when that was.

        The name is that of a slot or the kept set with the same gains now, else "tried" with the
        differences from the kept gains; or that of their controller if another one flies now.
        """
        before = [controller for since, controller, _ in self._flown if since <= time]
        controller = before[-1] if before else self.present
        name, note = TRIED_SET, ""
        if controller != self.present:
            name = controller_label(controller)
        else:
            for each, values in self._sets().items():
                if each not in (FLOWN_SET, PROPOSED_SET) and values == gains:
                    name = each
                    break
            else:
                note = f" ({self.differs(gains)})"
        return f"{name} at {simulated_text(time)}{note}"

    def gains_list(self, gains: Mapping[str, float]) -> tuple[str, ...]:
        """Return a line for each gain in which a set differs from the kept gains."""
        kept = controller_gains(self._trial.gains.kept)
        return gain_differences_list(gains, kept) or ("gains as kept",)

    def _sets(self) -> dict[str, dict[str, float]]:
        """Return the controller's gains of each existing set, by its name."""
        gains, flown = self._trial.gains, self._trial.flown
        if not flown:
            return {}
        stored = {KEPT_SET: gains.kept, **gains.slots}
        # filters are not in a gain file: they stay
        found = {name: flown | controller_gains(values) for name, values in stored.items()}
        found |= {FLOWN_SET: flown, PROPOSED_SET: self._trial.proposed}
        return {name: found[name] for name in GAIN_SET_NAMES if name in found}

    def _of_gains(self, name: str, values: Mapping[str, float]) -> Design:
        differs = self.gains_list(values) if name != KEPT_SET else ()
        return Design(
            name,
            self._trial.gains.of_set(values),
            *GAIN_SET_STROKES[name],
            short="" if name == KEPT_SET else self.differs(values),
            long=(*differs, self._when(values)),
        )

    def _of_controller(self, name: str) -> Design:
        colour = OTHER_CONTROLLER_COLOURS[
            self.controllers.index(name) % len(OTHER_CONTROLLER_COLOURS)
        ]
        gains = {key: value for key, value in self._trial.flown.items() if key in SHARED_PARAMETERS}
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
        """Record what flies now."""
        flown, view = self._trial.flown, self._flight.view
        if flown and (not self._flown or self._flown[-1][1:] != (self.present, flown)):
            time = view.snapshot.time if view.snapshot is not None else 0.0
            self._flown = [*self._flown[1 - MAX_FLOWN_CHANGES :], (time, self.present, flown)]
        self.changed.emit()

    def _when(self, values: Mapping[str, float]) -> str:
        """Return when gains last flew, in words."""
        end = ""
        for since, controller, gains in reversed(self._flown):
            begun = simulated_text(since)
            if controller == self.present and gains == values:
                return f"flew from {begun} to {end}" if end else f"flies since {begun}"
            end = begun
        return "has not flown"
