"""The complete state of a flight at one time, from which another process can continue it."""

from collections.abc import Mapping
from dataclasses import dataclass

Groups = tuple[tuple[float, ...], ...]
"""Groups of numbers, in order."""


@dataclass(frozen=True)
class SystemState:
    """State of one system of the diagram.

    Attributes:
        state: groups of its discrete state.
        parameters: groups of its numeric parameters: gains, wind, faults.
        continuous: its continuous state.
    """

    state: Groups
    parameters: Groups
    continuous: tuple[float, ...] = ()


@dataclass(frozen=True)
class Checkpoint:
    """Everything that determines the rest of a flight, as plain numbers.

    It excludes sensors, recorder and telemetry, which only observe the flight.

    Attributes:
        time: simulated time [s].
        steps: number of flown physics steps.
        due: requested time until now, of whole steps or not [s].
        acted: number of executed actions of the scenario's script.
        velocity: commanded velocity in W [m/s].
        yaw_rate: commanded yaw rate [rad/s].
        systems: state of each system of the diagram, by its path.
        controller: name of the controller.
        source: SHA-256 of its file.
        parameters: names of its parameters.
        memory: names of its states.
        script_ended: whether the script orders no more.
    """

    time: float
    steps: int
    due: float
    acted: int
    velocity: tuple[float, float, float]
    yaw_rate: float
    systems: Mapping[str, SystemState]
    controller: str = ""
    source: str = ""
    parameters: tuple[str, ...] = ()
    memory: tuple[str, ...] = ()
    script_ended: bool = False
