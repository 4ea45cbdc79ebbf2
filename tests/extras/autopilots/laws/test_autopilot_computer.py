"""What the flight computer designs for a law."""

import pytest

from workbench.control.controller_file import load_controller
from workbench.control.law_constants import known_vehicle, law_constants
from workbench.plant.payload import Payload
from workbench.systems.flight_computer import FlightComputer


def test_a_payload_that_becomes_known_is_designed_for(vehicle):
    """The shares of px4's rotors in each moment follow from where the centre of mass is."""
    law = load_controller("px4")
    own = {row.name: row.default for row in law.parameters}
    computer = FlightComputer(controller=law, vehicle=vehicle, gains=own, period=law.period)
    context = computer.CreateDefaultContext()
    payload = Payload(0.4, 0.05, 0.02, -0.1, known_payload_mass=0.4)
    known = known_vehicle(law_constants(vehicle, payload))
    wanted = law.gains(own, known, law.period)
    gains = context.get_numeric_parameter(0)
    assert gains.CopyToVector().tolist() != pytest.approx(wanted, rel=1e-3)
    computer.set_parameters(context, [(computer.payload_index, *row) for row in enumerate(payload)])
    assert gains.CopyToVector().tolist() == pytest.approx(wanted, rel=1e-12)
