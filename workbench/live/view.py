"""A live flight as a screen shows it, assembled from the messages of its process."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

from workbench.control.controller import Controller
from workbench.link.topics import Topic
from workbench.live.messages import (
    AutopilotView,
    Changed,
    Hit,
    NetworkView,
    Pace,
    Phase,
    Report,
    TakenOver,
    Told,
)
from workbench.plant.formats.xacro import XacroArgument
from workbench.plant.home import DEFAULT_HOME, Home
from workbench.plant.vehicle import Vehicle
from workbench.plant.worlds.outline import Outline
from workbench.scenario.excitation import Exciting
from workbench.scenario.scenario import Scenario
from workbench.session.injected import Injected
from workbench.session.snapshot import Snapshot


@dataclass(frozen=True)
class LiveView:
    """Everything that a screen shows of a live flight at one time.

    Attributes:
        phase: state of the flight.
        said: progress of a start; why the flight is broken, or has ended; else "".
        snapshot: the newest one, None until the flight has begun.
        pace: how well the flight keeps up with the wall clock.
        vehicle: the flying vehicle, None until the flight has begun.
        values: live parameters at the start or when the controller changed, by name.
        url: address of Meshcat's page, "" without one.
        scenario: the flown scenario, None until the flight has begun.
        topics: topics that the flight publishes.
        controller: the flying controller, None until the flight has begun.
        remarks: remarks about files read and parts built.
        network: who is connected and who has control.
        exciting: the present excitation, None without one.
        flight: number of the flight in its process; a reset starts the next one.
        measuring: flown share of a measurement, 0 .. 1, None without one.
        measured: result of the last measurement so far, None before the first.
        excitation_ended: why the last excitation ended early, else "".
        hit: the last hard hit of this flight, None before the first.
        needed: arguments of the xacro file without which the flight could not start.
        autopilot: state of the program that runs the law, None without one.
        outlines: outlines of the obstacles.
        home: geodetic position of the world's origin.
    """

    phase: Phase = Phase.STARTING
    said: str = "starting a process"
    snapshot: Snapshot | None = None
    pace: Pace | None = None
    vehicle: Vehicle | None = None
    values: Mapping[str, float] = dataclasses.field(default_factory=dict)
    url: str = ""
    scenario: Scenario | None = None
    topics: tuple[Topic, ...] = ()
    controller: Controller | None = None
    remarks: tuple[str, ...] = ()
    network: NetworkView = NetworkView()
    exciting: Exciting | None = None
    flight: int = 0
    excitation_ended: str = ""
    measuring: float | None = None
    measured: Injected | None = None
    hit: Hit | None = None
    needed: tuple[XacroArgument, ...] = ()
    autopilot: AutopilotView | None = None
    outlines: tuple[Outline, ...] = ()
    home: Home = DEFAULT_HOME

    def after(self, message: object) -> "LiveView":
        """Return the view after a message; the same object if nothing changes."""
        match message:
            case Report():
                return dataclasses.replace(self, **vars(message))
            case Changed(values):
                return dataclasses.replace(self, **values)
            case TakenOver(controller, values, named, gains) if self.scenario:
                config = dataclasses.replace(self.scenario.vehicle, gains=gains)
                flown = dataclasses.replace(self.scenario, controller=named, vehicle=config)
                return dataclasses.replace(
                    self, controller=controller, values=values, scenario=flown
                )
            case Told(said):
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
