"""Waypoints set by the operator, flown one after the other."""

import math
from collections.abc import Iterable
from functools import partial

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.control.mode import FlightMode
from workbench.gui.flight_control import flight_denial_reason
from workbench.gui.flight_model import FlightModel
from workbench.gui.instruments.map_frame import MapPlace
from workbench.gui.notices import Notices
from workbench.live.view import LiveView
from workbench.plant.worlds.outline import Outline
from workbench.scenario.scenario import Action

WAYPOINT_RADIUS_M = 0.3
"""Distance from a waypoint at which the next one is flown to [m]."""
ROUTE_ORDER_DELAY_S = 0.2
"""Time after an order until the command shows it [s]."""
REFERENCE_PLACE_SLICE = slice(4, 8)
"""Part of a `Reference`: the place, and whether it is flown to."""


class Route(QObject):
    """Waypoints of the flight; each is an order to go to a place, which the log records.

    The drone holds at the last one. Any other command ends the route, whoever gives it: the drone
    does not continue by itself after a stick was moved.

    Args:
        flight: the flight to fly.
        notices: takes the reason of its end.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        places: waypoints in W [m], in order.
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
        """Why no waypoint can be flown now, "" if one can."""
        return flight_denial_reason(self._flight)

    def begin(self) -> None:
        """Clear the route: another flight begins."""
        self._forget()
        self.changed.emit()

    def add(self, place: MapPlace, *, more: bool) -> None:
        """Fly to a place at the present height, at once or after the existing waypoints.

        Args:
            place: place in W.
            more: whether it is appended, instead of replacing the others.
        """
        view = self._flight.view
        if self.barred or view.snapshot is None:
            self._notices.warn(self.barred)
            return
        goes = view.snapshot.reference[REFERENCE_PLACE_SLICE][3] > 0.0
        height = (
            view.snapshot.reference[REFERENCE_PLACE_SLICE][2] if goes else view.snapshot.p_WB[2]
        )
        if self.places:
            height = self.places[-1][2]
        outlines = (each.at(view.snapshot.time) for each in view.outlines)
        if name := containing_obstacle(place, height, outlines):
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
        """Remove a waypoint; the drone flies to the next one, or holds without one."""
        flown = index == self.present
        del self.places[index]
        self.present -= index < self.present
        if flown and self.present < len(self.places):
            self._go()
        elif flown:
            self._forget()
            self._flight.do(Action(velocity=[0.0, 0.0, 0.0], yaw_rate=0.0))
        self.changed.emit()

    def _forget(self) -> None:
        self.places: list[tuple[float, float, float]] = []
        self.present = 0
        self._in_force = math.inf

    def _go(self) -> None:
        """Fly to the present waypoint."""
        place = self.places[self.present]
        self._in_force = math.inf
        self._orders += 1
        self._flight.do(Action(go_to=[*place]), partial(self._wait, self._orders), self._refuse)

    def _wait(self, order: int, time: float) -> None:
        """Check from a time on whether the order is in force; a newer order sets a new time."""
        if order == self._orders:
            self._in_force = time + ROUTE_ORDER_DELAY_S

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
        if landing or view.is_over:
            self._end("the drone lands" if landing else "the flight has ended")
        elif now.reference[REFERENCE_PLACE_SLICE] != (*place, 1.0):
            self._end("the drone got another command")
        elif math.dist(now.p_WB, place) < WAYPOINT_RADIUS_M and self.present + 1 < len(self.places):
            self.present += 1
            self._go()
            self.changed.emit()

    def _end(self, why: str) -> None:
        self._forget()
        self._notices.inform(f"the waypoints are dropped, because {why}")
        self.changed.emit()


def containing_obstacle(place: MapPlace, height: float, outlines: Iterable[Outline]) -> str:
    """Return the name of the obstacle that contains a place at a height [m], "" for none."""
    return next(
        (
            each.name
            for each in outlines
            if each.low <= height <= each.high and each.holds(place.east, place.north)
        ),
        "",
    )
