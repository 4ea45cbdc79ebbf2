"""The continuous core: its ports, its states, and its rest at hover."""

import numpy as np
import pytest

from workbench.control.controller_file import load_controller
from workbench.control.guidance import Guidance

HEIGHT = 10.0


def sizes(ports) -> dict[str, int]:
    return {port.get_name(): port.size() for port in ports}


def test_the_core_has_the_ports_it_names(core):
    inputs = [core.get_input_port(i) for i in range(core.num_input_ports())]
    outputs = [core.get_output_port(i) for i in range(core.num_output_ports())]
    assert sizes(inputs) == {"reference": 8, "guidance": len(Guidance._fields), "wind": 3}
    assert sizes(outputs) == {"state": 13, "thrusts": 4, "speeds": 4}


def test_the_core_has_one_kind_of_time(core):
    """States of body, rotors, estimate and law are continuous; so `Linearize` is exact."""
    context = core.CreateDefaultContext()
    assert context.num_continuous_states() == 13 + 4 + 3 + 1
    assert context.num_total_states() == context.num_continuous_states()


def test_hover_is_an_equilibrium_of_the_core(core, vehicle):
    context = core.CreateDefaultContext()
    core.GetInputPort("reference").FixValue(context, np.zeros(8))
    guide = Guidance(1, 1, 1, 0, 1, 1, 0, 0, HEIGHT)
    core.GetInputPort("guidance").FixValue(context, np.array(guide, dtype=float))
    state = [1, 0, 0, 0, 0, 0, HEIGHT, *[0.0] * 6, *vehicle.hover_speeds, 0, 0, 0, 0]
    context.SetContinuousState(state)
    derivatives = core.EvalTimeDerivatives(context).CopyToVector()
    assert derivatives == pytest.approx(np.zeros(21), abs=1e-9)


def test_parameter_values_are_those_of_one_system(setup):
    names = ("battery_duration", "sag_compensation")
    assert setup.of_system("battery") == {name: setup.values[name] for name in names}
    assert tuple(setup.of_system("controller")) == tuple(
        row.name for row in load_controller().parameters
    )
