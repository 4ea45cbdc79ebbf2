import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.design.linear.linearize import linearize


def test_the_closed_loop_has_names_and_follows_what_is_asked():
    system = linearize()
    assert list(system.input_labels)[:2] == ["reference_v_x", "reference_v_y"]
    assert list(system.output_labels) == ["v_x", "v_y", "v_z", "w_z"]
    assert list(system.state_labels)[:4] == ["roll", "pitch", "yaw", "p_x"]
    low = system(np.exp(1j * 1e-3 / 128))
    assert np.abs(low) == pytest.approx(np.eye(4), abs=0.02)


def test_a_position_loop_is_opened_while_the_place_is_held():
    assert abs(complex(linearize(loop="position_x")(np.exp(1j * 0.01 / 128)))) > 50.0


@pytest.mark.parametrize("time", ["sampled", "continuous"])
def test_the_vehicle_goes_from_commands_to_motion(time):
    system = linearize(loop="vehicle", time=time, outputs=["v_z"])
    assert list(system.input_labels) == ["command_1", "command_2", "command_3", "command_4"]
    assert bool(system.dt) is (time == "sampled")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"loop": "pich"}, "unknown loop 'pich': did you mean 'pitch'"),
        ({"time": "discrete"}, "unknown kind of time 'discrete'"),
        ({"loop": "pitch", "cut": "sensor"}, "unknown place to cut a loop 'sensor'"),
        ({"cut": "error"}, "'closed' has no loop to cut"),
        ({"cut": "sensor"}, "unknown place to cut a loop 'sensor'"),
        ({"loop": "vehicle", "cut": "error"}, "'vehicle' has no loop to cut"),
        ({"loop": "position_x", "at": "vx=3"}, "the position is held in hover only"),
        ({"outputs": ["v"]}, "unknown output 'v'"),
        ({"inputs": "reference_v_x"}, "give a list of names"),
        ({"loop": "pitch", "outputs": ["v_x"]}, "an open loop has the input and output of its cut"),
        ({"gains": {"kp_rol": 5.0}}, "unknown parameter 'kp_rol'"),
    ],
)
def test_what_is_wrong_is_said(arguments, said):
    with pytest.raises(WorkbenchError, match=said):
        linearize(**arguments)
