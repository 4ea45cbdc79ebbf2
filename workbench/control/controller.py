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

One of `update`, `system` and `program` is required. `update` runs unchanged with floats and
AutoDiffXd, and numba compiles it together with the functions that it calls.
"""

import hashlib
import importlib
import inspect
import math
import types
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from workbench.common.errors import WorkbenchError, find_row, unknown_name
from workbench.common.jitable import mark_functions
from workbench.common.own_file import (
    at_most_lines,
    check_names,
    find_own,
    own_errors,
    read_own,
    record,
    run_own,
    stated_memory,
    stated_parameters,
    stated_update,
    table_of,
)
from workbench.common.parameter import Parameter, State, gain
from workbench.common.resources import controllers_dir
from workbench.control.guidance import (
    Body,
    Guidance,
    KnownRotor,
    KnownVehicle,
    Measured,
    Reference,
    Setpoint,
)
from workbench.control.schedule import Schedule, parse_schedule, split_label, with_label
from workbench.plant.gravity import GRAVITY

if TYPE_CHECKING:
    from workbench.estimation.estimators import Estimator

DEFAULT = "pd"
SHIPPED = (
    "pd",
    "pid",
    "lqi",
    "geometric",
    "indi",
    "crazyflie",
    "mellinger",
    "px4",
    "ardupilot",
    "betaflight",
)
PROGRAMS = ("betaflight-sitl",)
"""Shipped laws that are separate programs: their flights are not repeatable."""
KNOWN = (*SHIPPED, *PROGRAMS)
ARGUMENTS = ("measured", "setpoint", "g", "vehicle", "memory", "dt", "loops")
"""Of `update`, in this order."""
CUTS = ("actuator", "error")
AXES = ("x", "y", "z", "yaw")
TRIAL_BODY = Body(1.0, (0.01, 0.0, 0.0, 0.01, 0.0, 0.02), 0.1, 0.02, 0.01)
TRIAL_VEHICLE = KnownVehicle(
    *TRIAL_BODY,
    tuple(
        KnownRotor(1.0, 0.1 * left, -0.1 * ahead, 0.01 * left * ahead, 0.01, 5.0, 5e-6, 0.0)
        for ahead in (1, -1)
        for left in (1, -1)
    ),
)
TRIAL_PERIOD = 1 / 128
"""Body, vehicle and period [s] of the trial of a file's functions, see `_tried`."""
TRIAL_INJECTION = 1e-3
"""Injection at a loop point in the trial, in its unit: too small to reach any limit of a law."""
_ZERO = (0.0, 0.0, 0.0)


PERIODS = (1 / 4096, 0.05)
"""Smallest and largest period of a law [s]."""
MOST_DIVIDED = 1000
LIMITS = "Limits"
"""Group of the parameters that stay the same when another controller takes over."""
COMMON = (
    gain("max_speed", "m/s", (0.1, 20.0), 8.0, "maximum horizontal speed", LIMITS),
    gain("max_climb_rate", "m/s", (0.1, 10.0), 8.0, "maximum climb and descent rate", LIMITS),
    gain("max_height", "m", (0.5, 500.0), 120.0, "maximum height", LIMITS),
    gain("max_tilt", "rad", (0.05, 1.2), 0.7, "maximum commanded tilt", LIMITS),
    gain("max_yaw_rate", "rad/s", (0.05, 6.0), 0.4, "maximum yaw rate", LIMITS),
    gain("spin_up_feedforward", "1", (0.0, 1.0), 0.0, "spin-up torque feedforward, yaw", "Yaw"),
)
"""Parameters of every controller: limits of the setpoint, and spin-up compensation."""


@dataclass(frozen=True)
class Loop:
    """One loop of a controller.

    Attributes:
        name: of the controlled quantity.
        error: the loop point of its error.
        actuator: the loop point of its output to the loop inside it; the error by default.
        hold: whether it is closed only while a position is held.
        axis: x, y, z or yaw: the step that goes through it, "" for none.
        gains: names of the parameters that a search may change for it.
        compares: what it compares, as text.
    """

    name: str
    error: str
    actuator: str = ""
    hold: bool = False
    axis: str = ""
    gains: tuple[str, ...] = ()
    compares: str = ""

    def point(self, cut: str) -> str:
        """Return the loop point of a cut, `actuator` or `error`.

        Raises:
            WorkbenchError: if it is neither.
        """
        if cut not in CUTS:
            raise unknown_name("place to cut a loop", cut, CUTS)
        return self.error if cut == "error" else self.actuator or self.error


class Program(Protocol):
    """A law that a separate program runs, for one flight."""

    def update(
        self, measured: Any, setpoint: Any, g: Any, vehicle: Any, memory: Any, dt: float, loops: Any
    ) -> tuple[Any, Any]:
        """Return what a law's `update` does.

        Raises:
            FlightBrokenError: if the program has ended, or does not answer: the rotors stop, and
                the flight goes on.
        """

    def report(self) -> Mapping[str, float]:
        """Return statistics of the exchange by name: `packets` sent, `lost` ones, and others."""

    def records(self) -> Mapping[str, bytes]:
        """Return its recordings of the flight: files, by the ending of their name."""

    def close(self) -> None:
        """End the program, and remove its files."""


@dataclass(frozen=True, eq=False)
class Controller:
    """A control law with everything that tools need to know about it.

    Attributes:
        name: a shipped one's, or the stem of its file; with a schedule also @ and its label.
        file: its path.
        text: of the file.
        parameters: its own rows of the parameter table, then those of `COMMON`.
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
    """

    name: str
    file: Path
    text: str = field(repr=False)
    parameters: tuple[Parameter, ...] = field(repr=False)
    update: Callable[..., Any] = field(repr=False)
    points: Mapping[str, str] = field(default_factory=dict, repr=False)
    loops: tuple[Loop, ...] = field(default=(), repr=False)
    memory: tuple[State, ...] = field(default=(), repr=False)
    rule: Callable[..., Mapping[str, float]] | None = field(default=None, repr=False)
    designed: tuple[str, ...] = field(default=(), repr=False)
    design: Callable[..., Sequence[float]] | None = field(default=None, repr=False)
    compiles: bool = True
    derivatives: str = "AutoDiff"
    period: float | None = None
    dividers: tuple[int, ...] = ()
    schedule: Schedule | None = field(default=None, repr=False)
    program: Callable[[Any, float], Program] | None = field(default=None, repr=False)
    estimator: "Estimator | None" = field(default=None, repr=False)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the text, so that another process needs no file."""
        return unpickled, (self.name, str(self.file), self.text, self.estimator)

    @property
    def shipped(self) -> bool:
        """Whether it is one of the workbench's own."""
        return self.unscheduled in KNOWN and self.file == _shipped_file(self.unscheduled)

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
        """Name and beginning of the digest, for machine code; see `jitable.unique`."""
        return f"{self.unscheduled.replace('-', '_')}_{self.digest[:12]}"

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
        return find_row("loop", name, self.loops)

    def gains(self, values: Mapping[str, float], body: Any, dt: float) -> list[float]:
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

    def design_with(self, own: Sequence[float], body: Any, dt: float) -> list[float]:
        """Return the designed numbers for values of its parameters, in their order.

        Raises:
            WorkbenchError: if the file's `design` fails.
        """
        if self.design is None:
            return []
        g = record("Gains", [row.name for row in self.parameters])(*own)
        with own_errors(self.file, "design"):
            found = [float(x) for x in self.design(body, g, dt)]
        if len(found) != len(self.designed) or not all(map(math.isfinite, found)):
            raise WorkbenchError(
                f"{self.file}: design returns {found}: let it return {len(self.designed)} finite "
                "numbers, one for each name in DESIGNED"
            )
        return found


def load_controller(name_or_path: str | Path = DEFAULT) -> Controller:
    """Return a shipped controller by name, or the one in a file or an installed module.

    The file's code runs, with the rights of whoever calls this.

    Args:
        name_or_path: `pd` or another of `SHIPPED`; the path of a file that ends in .py; or the
            name of an importable module, with a dot in it. A schedule of its gains may follow, as
            in `pd@speed=0,4,8`, see `control.schedule`.

    Raises:
        WorkbenchError: naming file and line of what is wrong.
    """
    name, label = split_label(str(name_or_path))
    if label:
        return scheduled(load_controller(name), label)
    if name in KNOWN:
        return _shipped(name)
    path = find_own(name, "controller")
    if path is not None:
        for shipped in KNOWN:
            if path.resolve() == _shipped_file(shipped):
                return _shipped(shipped)
        return _from_text(path.stem, path.resolve(), read_own(path, "controller"))
    if "@" in name:
        raise WorkbenchError(
            f"controller {name}: there is no schedule after the @: write it as pd@speed=0,4,8"
        )
    raise unknown_name("controller", name, KNOWN)


def is_shipped(name: str) -> bool:
    """Return whether a name is that of a shipped controller, scheduled or not."""
    return split_label(name)[0] in KNOWN


def find_loop(name: str, controller: Controller | None = None) -> Loop:
    """Return a loop of a controller, the default one where none is given.

    Raises:
        WorkbenchError: if there is none of that name.
    """
    return (controller or load_controller()).loop(name)


@lru_cache(maxsize=len(KNOWN))
def _shipped(name: str) -> Controller:
    path = _shipped_file(name)
    module = importlib.import_module(f"workbench.controllers.{path.stem}")
    return _from_module(name, path, path.read_text(encoding="utf-8"), module)


def _shipped_file(name: str) -> Path:
    return controllers_dir() / f"{name.replace('-', '_')}.py"


@lru_cache(maxsize=32)
def with_estimator(controller: Controller, estimator: "Estimator | None") -> Controller:
    """Return a controller with the user's own estimator, or without one."""
    if estimator is controller.estimator:
        return controller
    return replace(controller, estimator=estimator)


def unpickled(name: str, file: str, text: str, estimator: "Estimator | None" = None) -> Controller:
    """Return the controller of a text, in another process.

    Raises:
        WorkbenchError: naming file and line of what is wrong.
    """
    if estimator:
        return with_estimator(unpickled(name, file, text), estimator)
    name, label = split_label(name)
    if label:
        return scheduled(unpickled(name, file, text), label)
    in_folder = Path(file).parent.name == "controllers"
    if name in KNOWN and in_folder and text == _shipped(name).text:
        return _shipped(name)
    return _from_text(name, Path(file), text)


@lru_cache(maxsize=32)
def scheduled(controller: Controller, label: str) -> Controller:
    """Return a controller with sets of its gains over a quantity; limits have one value.

    Raises:
        WorkbenchError: if the label is not a schedule, or the gains are already scheduled, or
            cannot change in flight.
    """
    schedule = parse_schedule(label)
    if controller.schedule:
        raise WorkbenchError(
            f"{controller.name}@{label}: gains are scheduled over one quantity: leave one out"
        )
    if controller.program:
        raise WorkbenchError(
            f"{controller.name}@{label}: its gains are in a program of its own, and cannot be "
            "scheduled: leave out the schedule"
        )
    if not controller.compiles:
        raise WorkbenchError(
            f"{controller.file}: is made for its gains once, so they cannot be scheduled: let the "
            "system itself hear what they depend on"
        )
    common = [row.name for row in COMMON]
    own = [row for row in controller.parameters if row.name not in common]
    rows = [
        replace(row, name=name, help=f"{row.help}, {schedule.where(number)}")
        for row in own
        for number, name in enumerate(schedule.names(row.name))
    ]
    fields = [row.name for row in own]

    def all_sets(names: Iterable[str]) -> tuple[str, ...]:
        """Return names of parameters, each in all of its sets."""
        return tuple(
            each for name in names for each in (schedule.names(name) if name in fields else (name,))
        )

    def rule(vehicle: Any) -> dict[str, float]:
        values = controller.rule(vehicle) if controller.rule else {}
        return {each: value for name, value in values.items() for each in all_sets([name])}

    def design(vehicle: Any, g: Any, dt: float) -> list[float]:
        sets = [
            controller.design_with(
                [getattr(g, name + suffix) for name in fields]
                + [getattr(g, name) for name in common],
                vehicle,
                dt,
            )
            for suffix in schedule.suffixes
        ]
        return [x for designed in zip(*sets, strict=True) for x in designed]

    made = replace(
        controller,
        name=with_label(controller.name, schedule.label),
        parameters=(*rows, *(row for row in controller.parameters if row.name in common)),
        loops=tuple(replace(loop, gains=all_sets(loop.gains)) for loop in controller.loops),
        rule=rule if controller.rule else None,
        designed=tuple(each for name in controller.designed for each in schedule.names(name)),
        design=design if controller.design else None,
        schedule=schedule,
    )
    gains = record(f"Gains_{controller.key}", controller.gain_names)
    law = schedule.update(controller.update, gains, [*fields, *controller.designed], made.key)
    check_names(controller.file, "parameter", made.gain_names)
    return replace(made, update=law)


@lru_cache(maxsize=32)
def _from_text(name: str, file: Path, text: str) -> Controller:
    """Return the controller of a text; the same one for the same text."""
    module = run_own("controller", name, file, text)
    controller = _from_module(name, file, text, module)
    if controller.program is None:
        with own_errors(file, "update"), at_most_lines(file):
            _tried(controller)
    return controller


def _from_module(name: str, file: Path, text: str, module: types.ModuleType) -> Controller:
    """Return the controller that a file states, checked."""
    own = vars(module)
    if "system" in own:
        return _from_system(name, file, text, own)
    if "program" in own:
        return _from_program(name, file, text, own)
    controller = Controller(
        name=name,
        file=file,
        text=text,
        parameters=(*stated_parameters(file, own), *COMMON),
        update=stated_update(file, own, ARGUMENTS),
        points=own.get("POINTS", {}),
        loops=table_of(file, own, "LOOPS", Loop, "Loop(...)"),
        memory=stated_memory(file, own),
        rule=own.get("rule"),
        designed=table_of(file, own, "DESIGNED", str, '"k_speed"'),
        design=own.get("design"),
        period=_stated_period(file, own),
        dividers=_stated_dividers(file, own),
    )
    check_names(file, "parameter", controller.gain_names)
    _check_loops(controller)
    if bool(controller.designed) != callable(controller.design):
        raise WorkbenchError(
            f"{file}: DESIGNED and design(vehicle, g, dt) belong together: write both or none"
        )
    mark_functions(module)
    return controller


def _check_loops(controller: Controller) -> None:
    """Check the loop points and loops that a file states.

    Raises:
        WorkbenchError: if one is not valid, or a loop has an unknown point, axis or gain.
    """
    file, points = controller.file, controller.points
    if not isinstance(points, dict) or not all(
        isinstance(key, str) and isinstance(unit, str) for key, unit in points.items()
    ):
        raise WorkbenchError(f'{file}: POINTS is not a table: write {{"roll_error": "rad", ...}}')
    check_names(file, "loop", [each.name for each in controller.loops])
    rows = [row.name for row in controller.parameters]
    for loop in controller.loops:
        asked = [("loop point", point, list(points)) for point in (loop.error, loop.actuator)]
        asked += [("axis", loop.axis, list(AXES))]
        asked += [("gain", gain_name, rows) for gain_name in loop.gains]
        for what, name, known in asked:
            if name and name not in known:
                raise WorkbenchError(
                    f"{file}: the loop {loop.name} has {unknown_name(what, name, known)}"
                )


def _stated_period(file: Path, own: Mapping[str, Any]) -> float | None:
    """Return a file's `PERIOD` [s].

    Raises:
        WorkbenchError: if it is not a number in range that is exact in binary, because flights
            count whole steps.
    """
    period = own.get("PERIOD")
    if period is None:
        return None
    least, most = PERIODS
    stated = float(period) if isinstance(period, int | float) else math.nan
    if not least <= stated <= most or not (stated / least).is_integer():
        raise WorkbenchError(
            f"{file}: PERIOD is {period!r:.40}: give it a multiple of 1/4096 s up to {most:g} s, "
            "as 1 / 512"
        )
    return stated


def _stated_dividers(file: Path, own: Mapping[str, Any]) -> tuple[int, ...]:
    """Return a file's `DIVIDERS`.

    Raises:
        WorkbenchError: if one is not a whole number in range.
    """
    dividers = table_of(file, own, "DIVIDERS", int, "5")
    for divider in dividers:
        if not 1 <= divider <= MOST_DIVIDED:
            raise WorkbenchError(
                f"{file}: DIVIDERS has {divider}: give it numbers from 1 to {MOST_DIVIDED}"
            )
    return dividers


def _from_system(name: str, file: Path, text: str, own: Mapping[str, Any]) -> Controller:
    """Return the controller of a file that states a Drake system."""
    from workbench.control.system_law import AXES, POINTS, SystemLaw  # it loads Drake

    make = own["system"]
    if not inspect.isfunction(make) or len(inspect.signature(make).parameters) != 3:
        raise WorkbenchError(f"{file}: system is not a function: write def system(vehicle, g, dt)")
    for stated in ("update", "MEMORY", "POINTS", "DESIGNED", "design"):
        if stated in own:
            raise WorkbenchError(
                f"{file}: states system and {stated}: a system has states and ports of its own, so "
                f"leave {stated} out"
            )
    gains = tuple(row.name for row in stated_parameters(file, own))
    rows = (*stated_parameters(file, own), *COMMON)
    check_names(file, "parameter", [row.name for row in rows])
    g = record("Gains", [row.name for row in rows])(*(row.default for row in rows))
    with own_errors(file, "system"):
        system = make(TRIAL_BODY, g, TRIAL_PERIOD)
    law = SystemLaw(file, make, system, TRIAL_PERIOD)

    def update(
        measured: Any, setpoint: Any, g: Any, vehicle: Any, memory: Any, dt: float, loops: Any
    ) -> tuple[Any, Any]:
        return law.update(measured, setpoint, g, vehicle, memory, dt, loops)

    return Controller(
        name=name,
        file=file,
        text=text,
        parameters=rows,
        update=update,
        points=POINTS,
        loops=tuple(Loop(point, point, axis=AXES[point], gains=gains) for point in POINTS),
        memory=tuple(State(f"x_{k + 1}", "1", value) for k, value in enumerate(law.memory)),
        rule=own.get("rule"),
        compiles=False,
        derivatives="AutoDiff" if law.converts else "differences",
    )


def not_repeatable(name: str) -> WorkbenchError:
    """Return why a law that is a program cannot be used where flights must be repeatable."""
    return WorkbenchError(
        f"{name} is a program of its own, which has no linear model, and flies in `fly`, `step`, "
        "`hover`, `serve` and the app alone, from a flight's beginning: no flight of it is like "
        "another to the bit, so it cannot be compiled, forked, replayed, swept, tuned or pinned"
    )


def _from_program(name: str, file: Path, text: str, own: Mapping[str, Any]) -> Controller:
    """Return the controller of a file whose law is a separate program."""
    rows = (*stated_parameters(file, own), *COMMON)
    check_names(file, "parameter", [row.name for row in rows])

    def update(
        measured: Any, setpoint: Any, g: Any, vehicle: Any, memory: Any, dt: float, loops: Any
    ) -> tuple[Any, Any]:
        raise not_repeatable(name)

    return Controller(
        name=name,
        file=file,
        text=text,
        parameters=rows,
        update=update,
        memory=stated_memory(file, own),
        rule=own.get("rule"),
        compiles=False,
        period=_stated_period(file, own),
        dividers=_stated_dividers(file, own),
        program=own["program"],
    )


def _tried(controller: Controller) -> None:
    """Run a file's functions twice with plain numbers: at rest in hover, and in motion.

    Raises:
        WorkbenchError: if a result is not what the interface requires.
    """
    where = f"{controller.file}:{controller.update.__code__.co_firstlineno}: update returns"
    trial = _trial(controller)
    elapsed = (TRIAL_PERIOD,) * len(controller.dividers)
    v, q = (0.3, -0.2, 0.1), (0.97, 0.1, -0.2, 0.1)
    moving = Measured(v, v, v, q, v, _ZERO, (1.1 * GRAVITY, 0.01, -0.02, 0.01))
    moves = moving._replace(elapsed=(0.0,) * len(elapsed))
    memory: Sequence[Any] = controller.initial_memory
    for measured, asked in ((_hovering(elapsed), _ZERO), (moves, (1.0, -0.5, 0.2))):
        found = trial(measured, asked, memory, controller.closed)
        if not isinstance(found, tuple) or len(found) != 2:
            raise WorkbenchError(
                f"{where} {found!r:.60}: let it return (F, m_x, m_y, m_z) and the memory"
            )
        memory = _finite(where, found[1], [state.name for state in controller.memory], "memory")
        _finite(where, found[0], ("F", "m_x", "m_y", "m_z"), "wrench")


def _trial(controller: Controller) -> Callable[..., Any]:
    """Return the update with default gains, of motion, commanded velocity, memory and probes."""
    numbers = controller.gains(
        {row.name: row.default for row in controller.parameters}, TRIAL_VEHICLE, TRIAL_PERIOD
    )
    g = record("Gains", controller.gain_names)(*numbers)
    remembers = record("Memory", [state.name for state in controller.memory])
    guidance = Guidance(1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0)

    def trial(
        measured: Measured, asked: Sequence[float], memory: Sequence[Any], probes: list[float]
    ) -> Any:
        v_x, v_y, v_z = asked
        reference = Reference(v_x, v_y, v_z, 0.1 * v_x, *_ZERO, 0.0)
        setpoint = Setpoint(reference, guidance, _ZERO)
        loops = [*probes, *[0.0] * len(controller.points)]
        return controller.update(
            measured, setpoint, g, TRIAL_BODY, remembers(*memory), TRIAL_PERIOD, loops
        )

    return trial


def _hovering(elapsed: tuple[float, ...]) -> Measured:
    """Return the measurement at rest in hover."""
    return Measured(
        _ZERO, _ZERO, _ZERO, (1.0, 0.0, 0.0, 0.0), _ZERO, _ZERO, (GRAVITY, *_ZERO), elapsed=elapsed
    )


def _divider_of(controller: Controller, place: int) -> int:
    """Return n if the signal of the point with this index is read only in every n-th update."""
    dividers = controller.dividers
    if not dividers:
        return 1
    trial = _trial(controller)
    _, memory = trial(
        _hovering((TRIAL_PERIOD,) * len(dividers)),
        _ZERO,
        controller.initial_memory,
        controller.closed,
    )
    injected = controller.closed
    injected[len(controller.points) + place] = TRIAL_INJECTION
    for divider in (1, *sorted(dividers)):
        measured = _hovering(tuple(TRIAL_PERIOD if n == divider else 0.0 for n in dividers))
        plain, changed = (
            trial(measured, _ZERO, memory, probes) for probes in (controller.closed, injected)
        )
        if plain != changed:
            return divider
    return 1


def _finite(where: str, found: Any, names: Sequence[str], what: str) -> tuple[Any, ...]:
    """Return a result of `update`, which must be a tuple of one finite number for each name."""
    if not isinstance(found, tuple) or len(found) != len(names):
        count = f" with {len(found)} places" if isinstance(found, tuple) else ""
        raise WorkbenchError(
            f"{where} {found!r:.60}{count} as {what}: let it be a tuple of {len(names)} numbers"
            + (f", {', '.join(names)}" if names else "")
        )
    for name, value in zip(names, found, strict=True):
        if not isinstance(value, Real) or not math.isfinite(value):
            raise WorkbenchError(
                f"{where} {value!r:.60} as {name} of the {what}: let it be a finite number, also "
                "at rest in hover"
            )
    return found
