"""A flight at one time, all of it, so that another process can fly on from there."""

from collections.abc import Mapping
from dataclasses import dataclass

Groups = tuple[tuple[float, ...], ...]
"""Vectors of numbers, one after the other."""


@dataclass(frozen=True)
class SystemState:
    """What one system of the diagram remembers.

    Attributes:
        state: groups of its discrete state.
        parameters: groups of its numeric parameters: gains, wind, faults.
    """

    state: Groups
    parameters: Groups


@dataclass(frozen=True)
class Checkpoint:
    """Everything that determines the rest of a flight, as plain numbers.

    Sensors, recorder and telemetry only observe the flight and are not in it.

    Attributes:
        time: simulated [s].
        steps: of the physics that were flown.
        due: time that was to be flown until now, whole steps or not [s].
        acted: how many actions of the scenario's script were done.
        velocity: that the pilot asks for, in W [m/s].
        yaw_rate: that the pilot asks for [rad/s].
        systems: what each system of the diagram remembers, by its path.
        controller: name of the controller.
        source: SHA-256 of its file.
        parameters: names of its parameters.
        memory: names of what it remembers.
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
