"""A live flight as a screen shows it, assembled from the messages of its process."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

from workbench.control.controller import Controller
from workbench.link.topics import Topic
from workbench.live.messages import (
    ControllerChange,
    FlightNotice,
    FlightReport,
    NetworkView,
    Phase,
    ViewChange,
)
from workbench.plant.formats.xacro import XacroArgument
from workbench.plant.home import DEFAULT_HOME, Home
from workbench.plant.vehicle import Vehicle
from workbench.plant.worlds.outline import Outline
from workbench.scenario.scenario import Scenario
from workbench.session.injected import InjectedSignal


@dataclass(frozen=True)
class LiveView(FlightReport):
    """Everything that a screen shows of a live flight at one time: its last report, and more.

    Attributes:
        vehicle: the flying vehicle, None until the flight has begun.
        values: live parameters at the start or when the controller changed, by name.
        url: address of Meshcat's page, "" without one.
        scenario: the flown scenario, None until the flight has begun.
        topics: topics that the flight publishes.
        controller: the flying controller, None until the flight has begun.
        remarks: remarks about files read and parts built.
        measured: result of the last measurement so far, None before the first.
        needed: arguments of the xacro file without which the flight could not start.
        outlines: outlines of the obstacles.
        home: geodetic position of the world's origin.
    """

    vehicle: Vehicle | None = None
    values: Mapping[str, float] = dataclasses.field(default_factory=dict)
    url: str = ""
    scenario: Scenario | None = None
    topics: tuple[Topic, ...] = ()
    controller: Controller | None = None
    remarks: tuple[str, ...] = ()
    measured: InjectedSignal | None = None
    needed: tuple[XacroArgument, ...] = ()
    outlines: tuple[Outline, ...] = ()
    home: Home = DEFAULT_HOME

    @property
    def is_over(self) -> bool:
        """Whether the flight has ended, or is broken."""
        return self.phase in (Phase.ENDED, Phase.BROKEN)

    def after(self, message: object) -> "LiveView":
        """Return the view after a message; the same object if nothing changes."""
        match message:
            case FlightReport():
                return dataclasses.replace(self, **vars(message))
            case ViewChange(values):
                return dataclasses.replace(self, **values)
            case ControllerChange(controller, values, named, gains) if self.scenario:
                config = dataclasses.replace(self.scenario.vehicle, gains=gains)
                flown = dataclasses.replace(self.scenario, controller=named, vehicle=config)
                return dataclasses.replace(
                    self, controller=controller, values=values, scenario=flown
                )
            case FlightNotice(said):
                return dataclasses.replace(self, remarks=(*self.remarks, said))
        return self

    def ended(self, said: str, needed: tuple[XacroArgument, ...] = ()) -> "LiveView":
        """Return the view of the flight after its end, with the reason."""
        return dataclasses.replace(
            self,
            phase=Phase.ENDED,
            said=said,
            network=NetworkView(),
            exciting=None,
            measuring=None,
            needed=needed,
        )
