"""A python-control system as a part of a control law: sampled, with its states in the memory."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from workbench.common.errors import WorkbenchError
from workbench.common.jitable import (
    give_unique_name,
    make_attribute_reader,
    make_results_tuple,
    make_tuple_reader,
    register_jitable,
)
from workbench.common.parameter import State
from workbench.control.guidance import Gains, Memory

if TYPE_CHECKING:
    import control

DISCRETISATION_METHODS = ("tustin", "zoh", "foh", "euler", "backward_diff")
"""Discretisation methods, as in `control.sample_system`."""
MAX_COMPENSATOR_ORDER = 12
"""Order of a compensator."""

Run = Callable[[float, Gains, Memory], tuple[float, tuple[float, ...]]]


@dataclass(frozen=True)
class Compensator:
    """The parts of a controller's file for a compensator.

    Attributes:
        memory: its states, for `MEMORY`.
        designed: names of its coefficients, for `DESIGNED`.
        design: from the time between updates [s] to the coefficients, for `design`.
        run: from an input, `g` and the memory to the output and the next states, a tuple. A law
            calls it by a name of its module: `pitch = PITCH.run`.
    """

    memory: tuple[State, ...]
    designed: tuple[str, ...]
    design: Callable[[float], list[float]]
    run: Run


def compensator(
    name: str, system: "control.StateSpace | control.TransferFunction", method: str = "tustin"
) -> Compensator:
    """Return a part of a law that filters its input with a python-control system.

    With the system sampled at the law's rate, x' = A x + B u and y = C x + D u.

    Args:
        name: of its states and coefficients, with a number each.
        system: `control.StateSpace` or `TransferFunction` of one input and one output; continuous,
            or sampled at the law's own rate.
        method: how to discretise a continuous system, one of `DISCRETISATION_METHODS`: "tustin"
            keeps poles and zeros well below half the rate; "zoh" is exact for a held input.

    Raises:
        WorkbenchError: if it is not such a system, or has more zeros than poles.
    """
    import control  # takes a second to load

    where = f"compensator {name}"
    if not name.isidentifier():
        raise WorkbenchError(f"{where}: call it by letters, digits and _")
    if method not in DISCRETISATION_METHODS:
        raise WorkbenchError(
            f"{where}: {method} is not a method: choose one of {', '.join(DISCRETISATION_METHODS)}"
        )
    if not isinstance(system, control.StateSpace | control.TransferFunction):
        raise WorkbenchError(f"{where} is {system!r:.60}: give control.ss(...) or control.tf(...)")
    if (system.ninputs, system.noutputs) != (1, 1):
        raise WorkbenchError(f"{where} has {system.ninputs} inputs and {system.noutputs} outputs")
    is_ratio = isinstance(system, control.TransferFunction)
    if is_ratio and len(system.num[0][0]) > len(system.den[0][0]):
        raise WorkbenchError(f"{where} has more zeros than poles: add a fast pole to it")
    order = len(system.den[0][0]) - 1 if is_ratio else system.nstates
    if order == 0:
        raise WorkbenchError(f"{where} has no states: multiply by its gain in place of it")
    states = control.ss(system)
    n = states.nstates
    if n > MAX_COMPENSATOR_ORDER:
        raise WorkbenchError(
            f"{where} has {n} states: reduce it to {MAX_COMPENSATOR_ORDER}, as by control.balred"
        )
    names = [f"{name}_{k + 1}" for k in range(n)]
    rows = [f"a{i + 1}{j + 1}" for i in range(n) for j in range(n)]
    ends = [f"{letter}{k + 1}" for letter in "bc" for k in range(n)]
    designed = tuple(f"{name}_{entry}" for entry in (*rows, *ends, "d"))

    def design(dt: float) -> list[float]:
        sampled = states
        if not states.isdtime(strict=True):
            sampled = control.sample_system(states, dt, method)
        elif states.dt is not True and abs(states.dt - dt) > 1e-9:
            raise WorkbenchError(
                f"{where} is sampled at {states.dt:g} s, and the law at {dt:g} s: give the "
                "continuous one, or sample it at that"
            )
        matrices = (sampled.A, sampled.B, sampled.C, sampled.D)
        return [float(x) for matrix in matrices for x in matrix.ravel()]

    return Compensator(
        memory=tuple(State(each, "1") for each in names),
        designed=designed,
        design=design,
        run=_runner(name, names),
    )


def _runner(name: str, states: Sequence[str]) -> Run:
    """Return the update of a compensator, from an input, gains and memory to output and states."""
    n = len(states)
    output = _row(f"{name}_c", f"{name}_d", name, states)
    after = make_results_tuple(
        [_row(f"{name}_a{i + 1}", f"{name}_b{i + 1}", name, states) for i in range(n)], name
    )

    @register_jitable(forceinline=True)
    def run(u: float, g: Gains, m: Memory) -> tuple[float, tuple[float, ...]]:
        return output(u, g, m), after(u, g, m)

    return give_unique_name(run, f"{name}_{n}")


def _row(
    first: str, last: str, name: str, states: Sequence[str]
) -> Callable[[float, Gains, Memory], float]:
    """Return a row of the equations: the states times gains whose names begin with `first`, and the
    input times the gain `last`.
    """
    key, n = f"{first}_{len(states)}", len(states)
    factors = make_tuple_reader([f"{first}{j + 1}" for j in range(n)], key)
    values, through = make_tuple_reader(states, f"{name}_{n}"), make_attribute_reader(last)

    @register_jitable(forceinline=True)
    def row(u: float, g: Gains, m: Memory) -> float:
        a, x = factors(g), values(m)
        total = a[0] * x[0]
        for j in range(1, n):
            total = total + a[j] * x[j]
        return total + through(g) * u

    return give_unique_name(row, key)
