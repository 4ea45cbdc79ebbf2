"""A controller: its record, and the reader and checker of its file.

The file is Python, see docs/controllers.md. It defines

    PARAMETERS   its gains, made by `gain`
    POINTS       loop points: name and unit
    LOOPS        loops that can be opened there
    MEMORY       states that it keeps between updates, `State`s
    update       the control law
    rule         gains that suit a vehicle
    DESIGNED, design    numbers that follow from gains and vehicle
    PERIOD, DIVIDERS    time between updates, and parts that run only in every n-th one
    system       a Drake system, in place of `update`
    program      starts a separate program, in place of `update`
    SERVOS       joints whose servos it commands

One of `update`, `system` and `program` is required. `update` runs unchanged with floats and
AutoDiffXd, and numba compiles it together with the functions that it calls.
"""

import hashlib
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.common.errors import WorkbenchError, find_named_row
from workbench.common.own_file import (
    user_code_errors,
    user_record_type,
)
from workbench.common.parameter import Parameter, State, gain
from workbench.control.guidance import (
    Gains,
    Guidance,
    KnownBody,
    KnownRotor,
    KnownVehicle,
    LawResult,
    LawSetpoint,
    MeasuredMotion,
    Memory,
    Reference,
)
from workbench.control.installed_laws import is_shipped, shipped_file
from workbench.control.law_program import LawProgram
from workbench.control.loop import Loop
from workbench.control.loop_points import Probes
from workbench.control.schedule import GainSchedule, split_label, with_label
from workbench.parameters.flight_parameters import flight_parameters
from workbench.parameters.parameter_table import ParameterTable
from workbench.plant.gravity import GRAVITY

if TYPE_CHECKING:
    from workbench.estimation.estimators import Estimator
    from workbench.plant.vehicle import Vehicle

LAW_TRIAL_BODY = KnownBody(1.0, (0.01, 0.0, 0.0, 0.01, 0.0, 0.02), 0.1, 0.02, 0.01)
LAW_TRIAL_VEHICLE = KnownVehicle(
    *LAW_TRIAL_BODY,
    tuple(
        KnownRotor(1.0, 0.1 * left, -0.1 * ahead, 0.01 * left * ahead, 0.01, 5.0, 5e-6, 0.0)
        for ahead in (1, -1)
        for left in (1, -1)
    ),
)
LAW_TRIAL_PERIOD_S = 1 / 128
"""Body, vehicle and period [s] of the trial of a file's functions, see `_check_law_by_trial`."""
LAW_TRIAL_INJECTION = 1e-3
"""Injection at a loop point in the trial, in its unit: too small to reach any limit of a law."""
ZERO_VECTOR = (0.0, 0.0, 0.0)


LIMITS_GROUP = "Limits"
"""Group of the parameters that stay the same when another controller takes over."""
COMMON_PARAMETERS = (
    gain("max_speed", "m/s", (0.1, 20.0), 8.0, "maximum horizontal speed", LIMITS_GROUP),
    gain("max_climb_rate", "m/s", (0.1, 10.0), 8.0, "maximum climb and descent rate", LIMITS_GROUP),
    gain("max_height", "m", (0.5, 500.0), 120.0, "maximum height", LIMITS_GROUP),
    gain("max_tilt", "rad", (0.05, 1.2), 0.7, "maximum commanded tilt", LIMITS_GROUP),
    gain("max_yaw_rate", "rad/s", (0.05, 6.0), 0.4, "maximum yaw rate", LIMITS_GROUP),
    gain("spin_up_feedforward", "1", (0.0, 1.0), 0.0, "spin-up torque feedforward, yaw", "Yaw"),
)
"""Parameters of every controller: limits of the setpoint, and spin-up compensation."""


Law = Callable[[MeasuredMotion, LawSetpoint, Gains, KnownBody, Memory, float, Probes], LawResult]
"""`update` of a law."""


@dataclass(frozen=True, eq=False)
class Controller:
    """A control law with everything that tools need to know about it.

    Attributes:
        name: a shipped one's, or the stem of its file; with a schedule also @ and its label.
        file: its path.
        text: of the file.
        parameters: its own rows of the parameter table, then those of `COMMON_PARAMETERS`.
        update: the law, see docs/controllers.md.
        points: names of the loop points, and their units.
        loops: in the order of the cascade, for each axis the outer ones first.
        memory: its states.
        rule: from a vehicle to values of parameters by name; None for the defaults.
        designed: names of numbers that follow from gains and vehicle.
        design: computes them.
        compiles: whether it can be compiled; a Drake system cannot.
        derivatives: how linear models differentiate it: "AutoDiff" or "differences".
        period: required time between updates [s]; None for any.
        dividers: n for each part of the law that runs only in every n-th update.
        schedule: of its gains; None if they are not scheduled.
        program: starts the program that runs the law, for a `KnownVehicle` and the time between
            updates [s]; None if the law is `update`. With a program, `update` raises an error.
        estimator: the user's own estimator, None without one: its parameters are live in the same
            flights.
        servos: names of the joints whose servos it commands.
        setpoints: parameters of a vehicle's other servos, see `servo_parameters`.
    """

    name: str
    file: Path
    text: str = field(repr=False)
    parameters: tuple[Parameter, ...] = field(repr=False)
    update: Law = field(repr=False)
    points: Mapping[str, str] = field(default_factory=dict, repr=False)
    loops: tuple[Loop, ...] = field(default=(), repr=False)
    memory: tuple[State, ...] = field(default=(), repr=False)
    rule: "Callable[[Vehicle], Mapping[str, float]] | None" = field(default=None, repr=False)
    designed: tuple[str, ...] = field(default=(), repr=False)
    design: Callable[[KnownVehicle, Gains, float], Sequence[float]] | None = field(
        default=None, repr=False
    )
    compiles: bool = True
    derivatives: str = "AutoDiff"
    period: float | None = None
    dividers: tuple[int, ...] = ()
    schedule: GainSchedule | None = field(default=None, repr=False)
    program: Callable[[KnownVehicle, float], LawProgram] | None = field(default=None, repr=False)
    estimator: "Estimator | None" = field(default=None, repr=False)
    servos: tuple[str, ...] = ()
    setpoints: tuple[Parameter, ...] = field(default=(), repr=False)

    @property
    def shipped(self) -> bool:
        """Whether it is known by its name: the workbench's own, or an installed package's."""
        return is_shipped(self.name) and self.file == shipped_file(self.unscheduled)

    @property
    def reference(self) -> str:
        """The argument with which `load_controller` reads it, from the present file."""
        label = self.schedule.label if self.schedule else ""
        return self.name if self.shipped else with_label(str(self.file), label)

    @property
    def unscheduled(self) -> str:
        """The name without a schedule."""
        return split_label(self.name)[0]

    @property
    def digest(self) -> str:
        """SHA-256 of its text and its schedule."""
        label = self.schedule.label if self.schedule else ""
        return hashlib.sha256(with_label(self.text, label).encode()).hexdigest()

    @property
    def key(self) -> str:
        """Name and beginning of the digest, for machine code; see `give_unique_name`."""
        return f"{self.unscheduled.replace('-', '_')}_{self.digest[:12]}"

    @cached_property
    def table(self) -> ParameterTable:
        """The parameters of a flight with it: its own, those of every flight, estimator and servos.

        Raises:
            WorkbenchError: if a name is stated twice.
        """
        taken = {row.name: "one of every flight" for row in flight_parameters()}
        last = self.estimator.parameters if self.estimator else ()
        for of in filter(None, (self, self.estimator)):
            for row in of.parameters:
                if row.name in taken:
                    raise WorkbenchError(
                        f"{of.file}: the parameter {row.name} is {taken[row.name]}: give it "
                        "another name"
                    )
            taken |= {row.name: f"one of {of.name}" for row in of.parameters}
        last = (*last, *self.setpoints)
        if self.schedule is None:
            return ParameterTable(self.parameters, last)
        return ParameterTable(self.parameters, last, self.schedule.names)

    @property
    def gain_names(self) -> tuple[str, ...]:
        """Names of all numbers of its `g`: parameters, then designed numbers."""
        return (*(row.name for row in self.parameters), *self.designed)

    def gain_of(self, name: str) -> str:
        """Return the gain that a parameter is a set of, or the name itself without a schedule."""
        number = self.schedule.number_of(name) if self.schedule else None
        if self.schedule is None or number is None:
            return name
        return name.removesuffix(self.schedule.suffixes[number])

    @property
    def point_names(self) -> tuple[str, ...]:
        """Names of the loop points, in their order."""
        return tuple(self.points)

    @cached_property
    def point_dividers(self) -> Mapping[str, int]:
        """For each loop point, n if its signal is read only in every n-th update.

        A trial finds it: an injection has no effect in an update in which no part reads it.
        """
        return {name: _divider_of(self, place) for place, name in enumerate(self.points)}

    @property
    def closed(self) -> list[float]:
        """Gates and injections of a normal flight, see `loop_points`."""
        return [1.0] * len(self.points) + [0.0] * len(self.points)

    @property
    def initial_memory(self) -> list[float]:
        """Its initial memory."""
        return [each.initial for each in self.memory]

    def loop(self, name: str) -> Loop:
        """Return a loop.

        Raises:
            WorkbenchError: if there is none of that name.
        """
        if not self.loops:
            raise WorkbenchError(
                f"{self.name} states no LOOPS: add them to its file (docs/controllers.md), or look "
                "at all loops together, as by `workbench linearize`"
            )
        return find_named_row("loop", name, self.loops)

    def gains(self, values: Mapping[str, float], body: KnownVehicle, dt: float) -> list[float]:
        """Return all numbers of its `g`: the parameters' values, and the designed numbers.

        Args:
            values: of parameters by name.
            body: the vehicle as the law knows it, see `guidance.KnownVehicle`.
            dt: between updates [s].

        Raises:
            WorkbenchError: if the file's `design` fails.
        """
        own = [values[row.name] for row in self.parameters]
        return [*own, *self.design_with(own, body, dt)]

    def design_with(self, own: Sequence[float], body: KnownVehicle, dt: float) -> list[float]:
        """Return the designed numbers for values of its parameters, in their order.

        Raises:
            WorkbenchError: if the file's `design` fails.
        """
        if self.design is None:
            return []
        g = user_record_type("Gains", [row.name for row in self.parameters])(*own)
        with user_code_errors(self.file, "design"):
            found = [float(x) for x in self.design(body, g, dt)]
        if len(found) != len(self.designed) or not all(map(math.isfinite, found)):
            raise WorkbenchError(
                f"{self.file}: design returns {found}: let it return {len(self.designed)} finite "
                "numbers, one for each name in DESIGNED"
            )
        return found


def law_trial(controller: Controller) -> Callable[..., Any]:
    """Return the update with default gains, of motion, commanded velocity, memory and probes."""
    numbers = controller.gains(
        {row.name: row.default for row in controller.parameters},
        LAW_TRIAL_VEHICLE,
        LAW_TRIAL_PERIOD_S,
    )
    g = user_record_type("Gains", controller.gain_names)(*numbers)
    remembers = user_record_type("Memory", [state.name for state in controller.memory])
    guidance = Guidance(1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0)

    def trial(
        measured: MeasuredMotion,
        asked: Sequence[float],
        memory: Sequence[float],
        probes: list[float],
    ) -> LawResult:
        v_x, v_y, v_z = asked
        reference = Reference(v_x, v_y, v_z, 0.1 * v_x, *ZERO_VECTOR, 0.0)
        setpoint = LawSetpoint(reference, guidance, ZERO_VECTOR)
        loops = [*probes, *[0.0] * len(controller.points)]
        return controller.update(
            measured, setpoint, g, LAW_TRIAL_BODY, remembers(*memory), LAW_TRIAL_PERIOD_S, loops
        )

    return trial


def hovering_motion(elapsed: tuple[float, ...], servos: int = 0) -> MeasuredMotion:
    """Return the measurement at rest in hover, with joints at zero."""
    return MeasuredMotion(
        ZERO_VECTOR,
        ZERO_VECTOR,
        ZERO_VECTOR,
        (1.0, 0.0, 0.0, 0.0),
        ZERO_VECTOR,
        ZERO_VECTOR,
        (GRAVITY, *ZERO_VECTOR),
        elapsed=elapsed,
        joints=(0.0,) * (2 * servos),
    )


def _divider_of(controller: Controller, place: int) -> int:
    """Return n if the signal of the point with this index is read only in every n-th update."""
    dividers = controller.dividers
    if not dividers:
        return 1
    trial = law_trial(controller)
    _, memory = trial(
        hovering_motion((LAW_TRIAL_PERIOD_S,) * len(dividers), len(controller.servos)),
        ZERO_VECTOR,
        controller.initial_memory,
        controller.closed,
    )
    injected = controller.closed
    injected[len(controller.points) + place] = LAW_TRIAL_INJECTION
    for divider in (1, *sorted(dividers)):
        measured = hovering_motion(
            tuple(LAW_TRIAL_PERIOD_S if n == divider else 0.0 for n in dividers),
            len(controller.servos),
        )
        plain, changed = (
            trial(measured, ZERO_VECTOR, memory, probes) for probes in (controller.closed, injected)
        )
        if plain != changed:
            return divider
    return 1
