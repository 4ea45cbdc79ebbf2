"""What the systems of a flight remember, read from one Context and written to another.

A Context of a diagram with systems in Python cannot be pickled; the numbers in it can.
"""

from collections.abc import Iterator, Mapping

from pydrake.systems.framework import Context, Diagram, System

from workbench.common.errors import WorkbenchError
from workbench.diagram.workbench import Workbench
from workbench.session.checkpoint import Groups, SystemState
from workbench.systems.noise import CountedNoise
from workbench.systems.propeller_display import PropellerDisplay


def read_states(bench: Workbench, root: Context) -> dict[str, SystemState]:
    """Return what every system remembers that decides how the flight goes on, by its path."""
    found = {}
    for path, system in _deciding(bench):
        context = system.GetMyContextFromRoot(root)
        memory = SystemState(_discrete(context), _parameters(context))
        if memory.state or memory.parameters:
            found[path] = memory
    return found


def write_states(bench: Workbench, root: Context, states: Mapping[str, SystemState]) -> None:
    """Let every system remember what it did then.

    Raises:
        WorkbenchError: if the states are those of a flight of something else.
    """
    here = read_states(bench, root)
    if _shapes(here) != _shapes(states):
        raise WorkbenchError(
            "the checkpoint is one of another flight: go on with the scenario that it was taken "
            "from"
        )
    for path, system in _deciding(bench):
        if path not in states or states[path] == here[path]:
            continue
        context = system.GetMyMutableContextFromRoot(root)
        for number, values in enumerate(states[path].state):
            context.SetDiscreteState(number, values)
        for number, values in enumerate(states[path].parameters):
            context.get_mutable_numeric_parameter(number).SetFromVector(values)


def _deciding(bench: Workbench) -> Iterator[tuple[str, System]]:
    """Yield the systems that decide how the flight goes on, with their paths.

    Left out are sensors that no estimator listens to, with their noise, and what draws.
    """
    unheard = [m for m in bench.sensing.mounted if not isinstance(m.noise, CountedNoise)]
    looking = {mounted.system.GetSystemPathname() for mounted in unheard}
    looking |= {mounted.noise.GetSystemPathname() for mounted in unheard if mounted.noise}
    for system in _leaves(bench.diagram):
        path = system.GetSystemPathname()
        if path not in looking and not isinstance(system, PropellerDisplay):
            yield path, system


def _leaves(diagram: Diagram) -> Iterator[System]:
    """Yield the systems in a diagram, and in diagrams within it."""
    for system in diagram.GetSystems():
        if isinstance(system, Diagram):
            yield from _leaves(system)
        else:
            yield system


def _discrete(context: Context) -> Groups:
    """Return the discrete state; none of these systems has another kind."""
    assert not context.num_abstract_states() and not context.num_continuous_states()
    groups = range(context.num_discrete_state_groups())
    return tuple(tuple(context.get_discrete_state(i).CopyToVector().tolist()) for i in groups)


def _parameters(context: Context) -> Groups:
    groups = range(context.num_numeric_parameter_groups())
    return tuple(tuple(context.get_numeric_parameter(i).CopyToVector().tolist()) for i in groups)


def _shapes(states: Mapping[str, SystemState]) -> dict[str, tuple[list[int], list[int]]]:
    """Return how many numbers there are in each group."""
    return {
        path: (list(map(len, each.state)), list(map(len, each.parameters)))
        for path, each in states.items()
    }
