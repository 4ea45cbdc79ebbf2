"""Delays by hand, at 1/1024 and 1/128 s; the links of a drone with joints."""

import numpy as np
import pytest

from tests.jointed import drone, joint, link
from workbench.common.errors import WorkbenchError
from workbench.plant.description import read_description
from workbench.plant.loading import make_vehicle
from workbench.plant.variation import Variation, varied_description


@pytest.mark.parametrize(
    ("variation", "seen", "acting"),
    [
        (Variation(), (0, 0), (0, 0)),
        (Variation(control_delay=2), (2, 0), (0, 0)),
        (Variation(sensing_delay=0.003), (1, 5), (0, 0)),  # 3 steps: the state before step 5
        (Variation(control_delay=1, sensing_delay=8 / 1024), (2, 0), (0, 0)),
        (Variation(command_delay=0.004), (0, 0), (0, 4)),
        (Variation(command_delay=7 / 1024), (0, 0), (0, 7)),
        (Variation(command_delay=0.011), (0, 0), (1, 3)),
    ],
    ids=str,
)
def test_delays_are_whole_steps_of_physics(variation, seen, acting):
    delays = variation.delays(1 / 1024, 1 / 128)
    assert (delays.sensing_delay, delays.command_delay) == (seen, acting)


@pytest.mark.parametrize("name", ["sensing_delay", "command_delay"])
@pytest.mark.parametrize("value", [-0.001, 0.2, float("nan")])
def test_what_is_no_delay_is_refused(name, value):
    with pytest.raises(WorkbenchError, match=f"the {name} is .* s: give 0 .. 0.1 s"):
        Variation(**{name: value}).check()


def test_each_link_of_a_drone_with_joints_is_varied(tmp_path):
    """Its mass by the factor on mass, its moments by that on inertia; its joints stay."""
    parts = link("load", 0.2, (0.0, 0.0, -0.5)) + joint("swing", "continuous", "base", "load")
    description = read_description(drone(tmp_path, parts))
    vehicle = make_vehicle(description)
    flown = varied_description(description, vehicle, Variation(mass=1.5, inertia=2.0))
    load, own = flown.model.link("load").inertial, description.model.link("load").inertial
    assert load.mass == pytest.approx(1.5 * own.mass)
    assert np.abs(load.matrix - 2.0 * own.matrix).max() < 1e-15
    assert make_vehicle(flown).mass == pytest.approx(1.5 * vehicle.mass)
    assert flown.model.joint("swing").moves
