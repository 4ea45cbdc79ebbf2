"""What the buttons of the top bar do to the flight."""

from dataclasses import replace

from PyQt6.QtCore import QObject

from workbench.common.parameter import HOOKS
from workbench.control.installed_laws import installed_programs
from workbench.control.mode import FlightMode
from workbench.gui.flight_model import FlightModel, with_controller
from workbench.gui.preferences import Preferences
from workbench.live.choice import Choice
from workbench.live.messages import Phase
from workbench.live.orders import FlightOrder, FlyOn, SetSpeed
from workbench.live.view import LiveView
from workbench.scenario.scenario import Action, Scenario, VehicleConfig
from workbench.scenario.sensor_choice import for_other_vehicle

NO_FLIGHT_TEXT = "Nothing flies: open a scenario first."
STARTING_TEXT = "The flight is starting."
BROKEN_FLIGHT_TEXT = "The flight cannot continue: reset it first."
AUTOPILOT_ENDED_TEXT = "The autopilot has ended: reset the flight first."
PAUSED_TEXT = "The flight is paused: resume it first."
ON_GROUND_TEXT = "On the ground: take off first."
LANDING_TEXT = "Landing: fly it after the next take-off."
FIGURE_EIGHT_TEXT = "The scenario flies its figure of eight: nobody else can command."
_GROUND_MODES = (FlightMode.OFF, FlightMode.ARMED)


class FlightControl(QObject):
    """Gives the flight its orders.

    Args:
        flight: the flight to control.
        preferences: whether flights are drawn.
        parent: the Qt parent.

    Attributes:
        actions: names of actions that are enabled while they have an effect, see
            `possible_actions`.
    """

    actions = (
        *("arm", "take_off", "hold", "land", "open_hooks"),
        *("pause", "step", "reset", "record"),
    )

    def __init__(
        self, flight: FlightModel, preferences: Preferences, parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._flight = flight
        self._preferences = preferences

    def fly(self, what: Choice | Scenario) -> None:
        """End the present flight and start another."""
        self._flight.fly(what, draw=self._preferences.switch("draw_3d"))

    def fly_scenario(self, path: str) -> None:
        """Fly a scenario, with its own drone and world."""
        self.fly(Choice(path))

    def fly_model(self, path: str) -> None:
        """Fly another drone with all its sensors active, because their names differ."""
        now = self._flight.what
        if isinstance(now, Choice):
            choice = replace(now, model=path, gains="", sensors=("all",), args={}, packages={})
            self.fly(choice)
        else:
            sensors = replace(for_other_vehicle(now.sensors), use=["all"])
            self.fly(replace(now, vehicle=VehicleConfig(model=path), sensors=sensors))

    def fly_controller(self, name: str) -> None:
        """Switch to another controller in flight; if nothing flies, start a flight with it.

        A controller that is a program always starts a new flight. Each starts with its own gains:
        those of a gain file belong to another law.

        Args:
            name: name of a shipped one, or path of a file.
        """
        if self._flight.is_flying and name not in installed_programs():
            self._flight.asks_first(lambda: self._flight.do(Action(controller=name)))
        else:
            self.fly(with_controller(self._flight.what, name))

    def fly_world(self, path: str) -> None:
        """Fly in another world."""
        self.fly(replace(self._flight.what, world=path))

    def request(self, what: str) -> None:
        """Ask the flight mode for something; hold, land and stop end the script, too."""
        self._flight.do(Action(request=what))

    def hold(self) -> None:
        """Brake and stay: a command of zero ends a path, the request a take-off and the script."""
        self._flight.do(Action(velocity=[0.0, 0.0, 0.0], yaw_rate=0.0))
        self.request("hold")

    def toggle_hooks(self) -> None:
        """Drop the loads on cables, or take those that the cables reach."""
        opened = are_hooks_open(self._flight.view)
        self._flight.do(Action(set={HOOKS: float(not opened)}))

    def pause(self) -> None:
        """Pause or resume simulated time."""
        paused = self._flight.view.phase is Phase.PAUSED
        self._flight.do(FlightOrder.RESUME if paused else FlightOrder.PAUSE)

    def step(self) -> None:
        """Fly one control period; only while paused."""
        scenario = self._flight.view.scenario
        if scenario is not None:
            period = scenario.rates.control_period
            self._flight.do(FlyOn(period))

    def reset(self) -> None:
        """Reset the flight; a flight that has ended starts anew."""
        if self._flight.live is None or self._flight.view.phase is Phase.ENDED:
            self._flight.again()
        else:
            self._flight.do(FlightOrder.RESET)

    def set_speed(self, factor: float) -> None:
        """Set the number of simulated seconds per second."""
        self._flight.do(SetSpeed(factor))


def has_hooks(view: LiveView) -> bool:
    """Return whether the vehicle carries loads that it can drop."""
    return view.vehicle is not None and view.vehicle.unloaded is not None


def are_hooks_open(view: LiveView) -> bool:
    """Return whether the hooks of a vehicle that has some are open."""
    if view.vehicle is None or view.snapshot is None:
        return False
    return len(view.snapshot.cables) < len(view.vehicle.cables)


def possible_actions(view: LiveView) -> frozenset[str]:
    """Return the names of the flight's actions that have an effect now."""
    if view.phase is Phase.ENDED:
        return frozenset({"reset"})
    if view.phase is Phase.BROKEN:
        return frozenset({"reset", "speed", "record"})
    if view.snapshot is None or view.phase is Phase.STARTING:
        return frozenset()
    able = {"stop", "pause", "reset", "speed", "record"}
    if has_hooks(view):
        able.add("open_hooks")
    if view.phase is Phase.PAUSED:
        able.add("step")
    if view.autopilot is not None and view.autopilot.ended:  # commands have no effect
        return frozenset(able)
    mode = view.snapshot.mode
    if mode is FlightMode.OFF:
        able.add("arm")
    able |= {"take_off"} if mode in _GROUND_MODES else {"land", "hold"}
    if mode is FlightMode.LANDING:  # it ends the landing
        able.add("take_off")
    return frozenset(able)


def manual_denial_reason(view: LiveView) -> str:
    """Return why a flight cannot be flown by hand now, "" if it can."""
    if view.phase is Phase.ENDED:
        return NO_FLIGHT_TEXT
    if view.phase is Phase.BROKEN:
        return BROKEN_FLIGHT_TEXT
    if view.snapshot is None:
        return STARTING_TEXT
    if view.autopilot is not None and view.autopilot.ended:
        return AUTOPILOT_ENDED_TEXT
    if view.scenario is not None and view.scenario.figure_eight:
        return FIGURE_EIGHT_TEXT
    if view.phase is Phase.PAUSED:
        return PAUSED_TEXT
    if view.snapshot.mode in (FlightMode.OFF, FlightMode.ARMED):
        return ON_GROUND_TEXT
    if view.snapshot.mode is FlightMode.LANDING:
        return LANDING_TEXT
    return ""


def flight_denial_reason(flight: FlightModel) -> str:
    """Return the same for the model of a flight, which may have none."""
    return manual_denial_reason(flight.view) if flight.live is not None else NO_FLIGHT_TEXT
