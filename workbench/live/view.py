"""A live flight as a screen shows it, put together from what its process says."""

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
    """A live flight at one time: all that a screen shows of it.

    Attributes:
        phase: where the flight is.
        said: what is being done while it starts; why it is broken, or has ended; "" else.
        snapshot: the newest, None until the flight has begun.
        pace: how well it keeps up.
        vehicle: what flies, None until the flight has begun.
        values: of the live parameters at the start, by name, or when the controller took over.
        url: of Meshcat's page, "" without.
        scenario: what is flown, None until the flight has begun.
        topics: that it publishes.
        controller: that flies it, None until the flight has begun.
        remarks: on what was read and built.
        network: who watches and who commands.
        exciting: the excitation that is flown, None while none is.
        flight: its number in its process; a reset begins the next one.
        measuring: how much of a measurement is flown, 0 .. 1, None while none is.
        measured: what the last one has measured by now, None before the first.
        excitation_ended: why the last excitation ended before it was over, "" where it did not.
        hit: the last hard hit of this flight, None before the first.
        needed: arguments of its xacro file without which it could not begin.
        autopilot: the program that runs the law, None where none does.
        outlines: of the obstacles around it.
        home: where on the earth the world's origin lies.
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
        """Return the view once a message was heard; itself where that changes nothing."""
        match message:
            case Report():
                return dataclasses.replace(self, **vars(message))
            case Changed(values):
                return dataclasses.replace(self, **values)  # type: ignore[arg-type]
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
        """Return the view of the flight that has ended, and why."""
        return dataclasses.replace(
            self,
            phase=Phase.ENDED,
            said=said,
            network=NetworkView(),
            exciting=None,
            measuring=None,
            needed=needed,
        )
