"""Way-points that the operator sets, flown one after the other."""

import math
from collections.abc import Iterable
from functools import partial

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.control.mode import FlightMode
from workbench.gui.flight_control import barrier_of
from workbench.gui.flight_model import FlightModel
from workbench.gui.instruments.map_frame import Place
from workbench.gui.notices import Notices
from workbench.live.messages import Phase
from workbench.live.view import LiveView
from workbench.plant.worlds.outline import Outline

ARRIVED = 0.3
"""At this distance from a way-point the next one is flown to [m]."""
SETTLING = 0.2
"""After an order, until it shows in what is asked of the drone [s]."""
FOLLOWS = slice(4, 8)
"""Of a `Reference`: the place, and whether it is gone to."""


class Route(QObject):
    """Way-points of the flight; each is an order to go to a place, which the log has.

    The last one is held. Any other command ends the route, whoever gives it: the drone does not
    fly on by itself after a stick was moved.

    Args:
        flight: which flies it.
        notices: where its end is told.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        places: in W [m], in the order in which they are flown.
        present: index of the one that is flown to, or held.
    """

    changed = pyqtSignal()

    def __init__(
        self, flight: FlightModel, notices: Notices, parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._flight, self._notices = flight, notices
        self._orders = 0
        self._forget()
        flight.viewed.connect(self._follow)

    @property
    def barred(self) -> str:
        """Why no way-point can be flown now, "" if one can."""
        return barrier_of(self._flight)

    def begin(self) -> None:
        """Forget all: another flight begins."""
        self._forget()
        self.changed.emit()

    def add(self, place: Place, *, more: bool) -> None:
        """Fly to a place at the present height, at once or after those that there are.

        Args:
            place: in W.
            more: whether it comes after the others, and not in their place.
        """
        view = self._flight.view
        if self.barred or view.snapshot is None:
            self._notices.warn(self.barred)
            return
        goes = view.snapshot.reference[FOLLOWS][3] > 0.0
        height = view.snapshot.reference[FOLLOWS][2] if goes else view.snapshot.p_WB[2]
        if self.places:
            height = self.places[-1][2]
        outlines = (each.at(view.snapshot.time) for each in view.outlines)
        if name := inside(place, height, outlines):
            self._notices.warn(
                f"this place is inside '{name}' at a height of {height:.1f} m",
                "Choose another one, or climb above it first.",
            )
            return
        if not more:
            self._forget()
        self.places.append((place.east, place.north, height))
        if len(self.places) == 1:
            self._go()
        self.changed.emit()

    def remove(self, index: int) -> None:
        """Take a way-point away; the drone flies to the next one, or holds where there is none."""
        flown = index == self.present
        del self.places[index]
        self.present -= index < self.present
        if flown and self.present < len(self.places):
            self._go()
        elif flown:
            self._forget()
            self._flight.order(lambda live: live.command((0.0, 0.0, 0.0), 0.0))
        self.changed.emit()

    def _forget(self) -> None:
        self.places: list[tuple[float, float, float]] = []
        self.present = 0
        self._in_force = math.inf

    def _go(self) -> None:
        """Fly to the present way-point."""
        place = self.places[self.present]
        self._in_force = math.inf
        self._orders += 1
        self._flight.order(
            lambda live: live.go_to(place), partial(self._wait, self._orders), self._refuse
        )

    def _wait(self, order: int, time: float) -> None:
        """Look from then on whether it is still asked for; a newer order has its own time."""
        if order == self._orders:
            self._in_force = time + SETTLING

    def _refuse(self, said: str) -> None:
        self._forget()
        self._notices.warn(said)
        self.changed.emit()

    def _follow(self, view: LiveView) -> None:
        now = view.snapshot
        if not self.places or now is None or now.time < self._in_force:
            return
        place = self.places[self.present]
        landing = now.mode in (FlightMode.OFF, FlightMode.LANDING)
        if landing or view.phase in (Phase.BROKEN, Phase.ENDED):
            self._end("the drone lands" if landing else "the flight has ended")
        elif now.reference[FOLLOWS] != (*place, 1.0):
            self._end("something else is asked of the drone")
        elif math.dist(now.p_WB, place) < ARRIVED and self.present + 1 < len(self.places):
            self.present += 1
            self._go()
            self.changed.emit()

    def _end(self, why: str) -> None:
        self._forget()
        self._notices.inform(f"the way-points are given up, as {why}")
        self.changed.emit()


def inside(place: Place, height: float, outlines: Iterable[Outline]) -> str:
    """Return the name of the obstacle that a place at a height [m] is inside of, "" for none."""
    return next(
        (
            each.name
            for each in outlines
            if each.low <= height <= each.high and each.holds(place.east, place.north)
        ),
        "",
    )
