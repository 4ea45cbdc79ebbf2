"""Ten seconds of one quadrotor in closed loop, compared with other drone simulators.

The flight is a hover, and after a second a step: of velocity for ours and MuJoCo, of position for
simulators whose own controller takes a position (RotorPy and crazyflow get it from the start). Each
simulator runs its own loop with its own controller, at the rates in the table, in a separate
environment, and must reach its target. Real-time factors are simulated time over processor time.
Flights alternate, and ratios are those of neighbouring flights.

Ours are the flight core (plant with contact, rotors, controller and flight mode: a Drake diagram)
and the floor, the plant alone under constant thrusts. Our coarse rates are the nearest to those of
gym-pybullet-drones. RotorPy runs the loop of its `Environment`; gym-pybullet-drones runs
`CtrlAviary` with its PID controller.

MuJoCo and crazyflow are faster than the floor. MuJoCo's step is one compiled function for one kind
of model, over preallocated arrays. A Drake step passes through a framework in which any system can
be wired, logged, linearised and converted to AutoDiff, and through a solver for any contact: the
row of a single body without shapes and forces shows that most of the floor's time is spent there,
and less on rotors and ground. crazyflow has no contact and compiles the whole flight into one call,
without access in between. Where that is enough, our compiled flights do the same, see the sweeps;
a flight with displays, commands and sensors needs the diagram.
"""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass

import numpy as np
from flyers import Flyer, Hangar, speed_of
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from simulators import NoSimulatorError, OtherSimulator, version
from spread import Spread, ratios, spread, text

from workbench.scenario.scenario import Rates

SPEED, DISTANCE, EDGE, DURATION = 1.0, 1.0, 1.0, 10.0
"""Of the step [m/s] or [m], when it comes, and when the flight ends [s]."""
TURNS = 5
MISSED = 0.25
"""What a flight may be off at its end [m] or [m/s]."""
CORE, COARSE_CORE = "flight core", "flight core, coarse"
COARSE = Rates(
    physics_step=1 / 256, control_period=5 / 256, mode_period=5 / 32, record_period=5 / 256
)


@dataclass(frozen=True)
class FlightRow:
    """How fast one simulator flies.

    Attributes:
        simulator: name and loop.
        physics_rate: [Hz].
        control_rate: [Hz]; 0 without a controller.
        real_time_factor: simulated time over processor time.
        core_as_fast: speed of the flight core at its usual rates, relative to this one.
        coarse_core_as_fast: the same, with the flight core at its coarse rates.
    """

    simulator: str
    physics_rate: float
    control_rate: float
    real_time_factor: Spread
    core_as_fast: Spread
    coarse_core_as_fast: Spread


@dataclass(frozen=True)
class Missing:
    """What could not be compared, and why."""

    simulator: str
    reason: str


@dataclass(frozen=True)
class Flight:
    """A flight to repeat: returns the seconds of processor that it took, and what it missed."""

    simulator: str
    physics_rate: float
    control_rate: float
    fly: Callable[[], tuple[float, float]]


def measure(turns: int = TURNS) -> list[FlightRow | Missing]:
    """Fly all in turns, and return a row for each."""
    with ExitStack() as stack:
        flights = [*_own(), *_others(stack)]
        ready = [each for each in flights if isinstance(each, Flight)]
        seconds: dict[str, list[float]] = {each.simulator: [] for each in ready}
        for turn in range(turns + 1):
            for each in ready:
                taken, missed = each.fly()
                if not missed < MISSED:
                    raise RuntimeError(f"{each.simulator} missed its aim by {missed:.2f}")
                if turn:  # the first one warms up
                    seconds[each.simulator].append(taken)
            print(f"  same flight, turn {turn} of {turns}", file=sys.stderr, flush=True)
    core, coarse = seconds[CORE], seconds[COARSE_CORE]
    return [
        FlightRow(
            each.simulator,
            each.physics_rate,
            each.control_rate,
            spread([DURATION / own for own in seconds[each.simulator]]),
            ratios(seconds[each.simulator], core),
            ratios(seconds[each.simulator], coarse),
        )
        if isinstance(each, Flight)
        else each
        for each in flights
    ]


def show(rows: list[FlightRow | Missing]) -> None:
    """Print the table."""
    print(f"{'the same flight':48} physics law     RTF     flight core as fast; coarse")
    for row in rows:
        if isinstance(row, Missing):
            print(f"{row.simulator:48} {row.reason}")
        else:
            print(
                f"{row.simulator:48} {row.physics_rate:6.0f} {row.control_rate:4.0f} "
                f"{row.real_time_factor.median:9.1f}   {text(row.core_as_fast)}; "
                f"{text(row.coarse_core_as_fast)}"
            )


def _own() -> Iterator[Flight]:
    usual = Rates()
    yield _flight(CORE, usual, lambda hangar: hangar.core(usual), SPEED)
    yield _flight(COARSE_CORE, COARSE, lambda hangar: hangar.core(COARSE), SPEED)
    yield _flight("floor: the plant alone", usual, lambda hangar: hangar.floor(usual), 0.0)
    yield _flight("Drake: a body, no shapes, no forces", usual, lambda _: _lone_body(usual), 0.0)


def _flight(name: str, rates: Rates, make: Callable[[Hangar], Flyer], speed: float) -> Flight:
    hangar = Hangar()

    def fly() -> tuple[float, float]:
        flyer = make(hangar)
        begun = time.process_time()
        flyer.simulator.AdvanceTo(EDGE)
        if speed:
            _command(flyer, speed)
        flyer.simulator.AdvanceTo(DURATION)
        seconds = time.process_time() - begun
        return seconds, abs(flyer.speed() - speed)

    return Flight(name, 1 / rates.physics_step, 1 / rates.control_period if speed else 0.0, fly)


def _lone_body(rates: Rates) -> Flyer:
    """Return a weightless body that drifts: the least that a discrete plant can be."""
    builder = DiagramBuilder()
    plant = builder.AddSystem(MultibodyPlant(rates.physics_step))
    plant.AddRigidBody("base", SpatialInertia.SolidBoxWithMass(1.5, 0.3, 0.3, 0.1))
    plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
    plant.Finalize()
    simulator = Simulator(builder.Build())
    context = plant.GetMyContextFromRoot(simulator.get_context())
    body = plant.GetBodyByName("base")
    return Flyer(simulator, lambda: 0.0, lambda: speed_of(plant, context, body))


def _command(flyer: Flyer, speed: float) -> None:
    """Ask law and flight mode for a velocity along x."""
    root = flyer.simulator.get_mutable_context()
    for name in ("controller", "modes"):
        system = flyer.simulator.get_system().GetSubsystemByName(name)
        context = system.GetMyMutableContextFromRoot(root)
        system.GetInputPort("reference").FixValue(context, [speed, *[0.0] * 7])


def _others(stack: ExitStack) -> Iterator[Flight | Missing]:
    mujoco, bullet = f"MuJoCo {version('mujoco', 'mujoco')}", "gym-pybullet-drones"
    rotorpy = f"RotorPy {version('rotorpy', 'rotorpy')}"
    crazyflow = f"crazyflow {version('crazyflow', 'crazyflow')}"
    step = {"edge": EDGE, "duration": DURATION}
    aim = {"distance": DISTANCE, "duration": DURATION}
    for name, environment, task, physics, control, arguments in (
        (f"{rotorpy}, its own loop", "rotorpy", "flight", 100, 100, aim),
        *(
            (f"{bullet}, {a}/{b}", "pybullet_drones", "flight", a, b, {**step, **aim, **pair})
            for a, b in ((240, 48), (240, 240))
            for pair in ({"physics": a, "control": b},)
        ),
        (f"{mujoco}, law in Python", "mujoco", "flight", 1000, 250, {**step, "speed": SPEED}),
        (f"{mujoco}, no Python in the loop", "mujoco", "bare", 1000, 0, {"duration": DURATION}),
        (f"{crazyflow}, one compiled call", "crazyflow", "flight", 500, 500, aim),
    ):
        try:
            simulator = stack.enter_context(OtherSimulator(environment))
            yield Flight(name, physics, control, _asking(simulator, task, arguments))
        except NoSimulatorError as error:
            yield Missing(name, str(error))


def _asking(
    simulator: OtherSimulator, task: str, arguments: dict[str, float]
) -> Callable[[], tuple[float, float]]:
    def fly() -> tuple[float, float]:
        answer = simulator.ask(task, **arguments)
        return answer["seconds"], answer["missed"]

    return fly


if __name__ == "__main__":
    show(measure())
