"""The scenario of a flight, as typed dataclasses that define the YAML schema."""

from dataclasses import dataclass, field

from workbench.control.installed_laws import DEFAULT_CONTROLLER
from workbench.estimation.settings import TRUTH
from workbench.plant.variation import Variation
from workbench.scenario.sensors_config import SensorsConfig

DEFAULT_CONTROL_PERIOD_S = 1 / 128
"""Default period of control updates [s]."""
MIN_STEERING_SPEED = 1e-5
"""Velocity from which on a position is no longer held [m/s]."""


@dataclass
class VehicleConfig:
    """The vehicle and its gains.

    The name of a shipped model or the path of a description; arguments for its xacro file; folders
    of packages and models that it refers to, by name; the path of a sidecar, for a description
    without rotors; the path of a gain file; and the variation of the flying vehicle from all that.
    """

    model: str = "dh_drone"
    args: dict[str, str] = field(default_factory=dict)
    packages: dict[str, str] = field(default_factory=dict)
    rotors: str = ""
    gains: str = ""
    variation: Variation = field(default_factory=Variation)


@dataclass
class Rates:
    """Periods [s]; each is a multiple of the physics step, and exact in binary."""

    physics_step: float = 1 / 1024
    control_period: float = DEFAULT_CONTROL_PERIOD_S
    mode_period: float = 1 / 8
    record_period: float = 1 / 128

    @property
    def control_steps(self) -> int:
        """Physics steps in a control period."""
        return round(self.control_period / self.physics_step)


@dataclass
class ScenarioStart:
    """The start of a flight: off on the ground, or in the air with rotors at hover speed.

    Position of the base link [m] (by default on the ground, or in hover 1.5 m above it), roll,
    pitch, yaw [rad], velocity [m/s] and angular velocity [rad/s], both in W.
    """

    mode: str = "hovering"
    position: list[float] | None = None
    roll_pitch_yaw: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    velocity: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    angular_velocity: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])


@dataclass(frozen=True)
class Gust:
    """A gust that rises to a velocity in W [m/s] and falls again, within a duration [s]."""

    velocity: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    duration: float = 1.0


@dataclass(frozen=True)
class Push:
    """A force in W [N] at a point of the body in B [m], and a torque in B [N·m], for a time [s]."""

    force: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    point: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    duration: float = 0.1
    torque: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])


@dataclass(frozen=True)
class Injection:
    """A multisine added to a signal of the law, to measure the response of a loop.

    The name of the loop point ("" ends an injection), the rms amplitude in its unit, the lowest and
    the highest frequency [rad/s], and the number of periods, each of one wave of the lowest
    frequency.
    """

    point: str = ""
    size: float = 0.0
    lowest: float = 0.5
    highest: float = 50.0
    periods: int = 5

    def action(self, *, hold: bool) -> "Action":
        """Return the action that measures a loop in hover.

        Args:
            hold: whether the loop is one that holds a position. For all others the velocity is
                commanded, too small to matter, as in the models used to judge them.
        """
        return Action(
            velocity=[0.0 if hold else MIN_STEERING_SPEED, 0.0, 0.0], yaw_rate=0.0, injection=self
        )


@dataclass(frozen=True)
class AttitudeSetpoint:
    """Setpoints of roll and pitch [rad] and of their rates [rad/s], about x and y of the body.

    Each replaces what the loops outside ask for, so a drone with a roll of 0.1 speeds up sideways.
    They last until the next setpoints; with none given, those of the loops outside return.
    """

    roll: float | None = None
    pitch: float | None = None
    roll_rate: float | None = None
    pitch_rate: float | None = None

    @property
    def given(self) -> dict[str, float]:
        """The setpoints that are given, by name."""
        return {name: value for name, value in vars(self).items() if value is not None}


SCRIPT_ENDING_REQUESTS = ("hold", "land", "stop")
"""Requests after which the script of the scenario gives no more orders; its own do not end it."""


@dataclass(frozen=True)
class Action:
    """An action of the pilot at a time [s]; whatever is not given stays the same.

    A velocity in W [m/s], a yaw rate [rad/s], a point to go to [m], a request (arm, take_off, hold,
    land, stop, abort_landing) with its height [m], setpoints of attitude or rates, a gust, a push,
    an injection into the law, new values of live parameters, or a controller to take over (the name
    of a shipped one, or a file). `end_script`, which is no part of a script, is whether the
    scenario's script orders no more after it; None, the default, means after a hold, a landing or a
    stop. `interpreted` has no effect: files of earlier versions have it.
    """

    at: float = 0.0
    velocity: list[float] | None = None
    yaw_rate: float | None = None
    go_to: list[float] | None = None
    request: str | None = None
    height: float = 1.5
    gust: Gust | None = None
    push: Push | None = None
    injection: Injection | None = None
    setpoint: AttitudeSetpoint | None = None
    set: dict[str, float] = field(default_factory=dict)
    controller: str | None = None
    end_script: bool | None = None
    interpreted: bool = False

    @property
    def ends_script(self) -> bool:
        """Whether the scenario's script orders no more after it."""
        if self.end_script is None:
            return self.request in SCRIPT_ENDING_REQUESTS
        return self.end_script

    @property
    def flies(self) -> bool:
        """Whether it sends the drone somewhere or changes its flight mode."""
        wishes = (self.velocity, self.yaw_rate, self.go_to, self.request, self.setpoint)
        return any(wish is not None for wish in wishes)


@dataclass
class FigureEight:
    """A path in a figure of eight: its centre [m], size [m], time per lap [s] and number of laps.

    Without `feedforward` the law does not get the acceleration along it.
    """

    center: list[float] = field(default_factory=lambda: [0.0, 0.0, 1.5])
    length: float = 4.0
    width: float = 2.0
    period: float = 10.0
    laps: int = 2
    feedforward: bool = True


@dataclass
class Scenario:
    """All settings of a flight; equal scenarios yield flights equal to the bit.

    The controller is the name of a shipped one, or the path of a Python file, which is executed.
    The estimator provides the motion to the controller: one of `ESTIMATORS`, or such a file.
    """

    title: str = ""
    vehicle: VehicleConfig = field(default_factory=VehicleConfig)
    controller: str = DEFAULT_CONTROLLER
    estimator: str = TRUTH
    world: str = "empty"
    sensors: SensorsConfig = field(default_factory=SensorsConfig)
    rates: Rates = field(default_factory=Rates)
    start: ScenarioStart = field(default_factory=ScenarioStart)
    duration: float = 10.0
    script: list[Action] = field(default_factory=list)
    figure_eight: FigureEight | None = None

    @property
    def is_estimated(self) -> bool:
        """Whether the controller gets an estimate of the motion, not the truth."""
        return self.estimator != TRUTH
