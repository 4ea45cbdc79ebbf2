"""Read and write the states of a diagram that determine the rest of a flight."""

from collections.abc import Iterator, Mapping

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context, Diagram, System

from workbench.common.errors import WorkbenchError
from workbench.diagram.workbench import Workbench
from workbench.session.checkpoint import Groups, SystemState
from workbench.systems.noise import CountedNoise
from workbench.systems.propeller_display import PropellerDisplay


def read_system_states(bench: Workbench, root: Context) -> dict[str, SystemState]:
    """Return the state of each system that determines the rest of the flight, by its path."""
    found = {}
    for path, system in _deciding(bench):
        context = system.GetMyContextFromRoot(root)
        continuous = tuple(context.get_continuous_state_vector().CopyToVector().tolist())
        # the plant's parameters follow from the payload
        parameters = () if isinstance(system, MultibodyPlant) else _parameters(context)
        memory = SystemState(_discrete(context), parameters, continuous)
        if memory.state or memory.parameters or continuous:
            found[path] = memory
    return found


def write_system_states(bench: Workbench, root: Context, states: Mapping[str, SystemState]) -> None:
    """Write the states of a checkpoint to the systems.

    Raises:
        WorkbenchError: if the states belong to a different flight.
    """
    here = read_system_states(bench, root)
    if _shapes(here) != _shapes(states):
        raise WorkbenchError(
            "the checkpoint belongs to another flight: continue with the scenario that it was "
            "taken from"
        )
    for path, system in _deciding(bench):
        if path not in states or states[path] == here[path]:
            continue
        context = system.GetMyMutableContextFromRoot(root)
        for number, values in enumerate(states[path].state):
            context.SetDiscreteState(number, values)
        for number, values in enumerate(states[path].parameters):
            context.get_mutable_numeric_parameter(number).SetFromVector(values)
        if states[path].continuous:
            context.SetContinuousState(states[path].continuous)


def _deciding(bench: Workbench) -> Iterator[tuple[str, System]]:
    """Yield the systems that determine the rest of the flight, with their paths.

    This excludes sensors that no estimator reads, with their noise, and everything that draws.
    """
    observing = [m for m in bench.sensing.mounted if not isinstance(m.noise, CountedNoise)]
    left_out = {mounted.system.GetSystemPathname() for mounted in observing}
    left_out |= {mounted.noise.GetSystemPathname() for mounted in observing if mounted.noise}
    for system in _leaves(bench.diagram):
        path = system.GetSystemPathname()
        if path not in left_out and not isinstance(system, PropellerDisplay):
            yield path, system


def _leaves(diagram: Diagram) -> Iterator[System]:
    """Yield the systems in a diagram, and in its nested diagrams."""
    for system in diagram.GetSystems():
        if isinstance(system, Diagram):
            yield from _leaves(system)
        else:
            yield system


def _discrete(context: Context) -> Groups:
    """Return the discrete state."""
    assert not context.num_abstract_states()
    groups = range(context.num_discrete_state_groups())
    return tuple(tuple(context.get_discrete_state(i).CopyToVector().tolist()) for i in groups)


def _parameters(context: Context) -> Groups:
    groups = range(context.num_numeric_parameter_groups())
    return tuple(tuple(context.get_numeric_parameter(i).CopyToVector().tolist()) for i in groups)


def _shapes(states: Mapping[str, SystemState]) -> dict[str, tuple[list[int], list[int]]]:
    """Return the number of numbers in each group."""
    return {
        path: (list(map(len, each.state)), list(map(len, each.parameters)))
        for path, each in states.items()
    }
