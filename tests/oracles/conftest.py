"""The shipped drone with its rotors, ready to be set anywhere and integrated."""

import dataclasses
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram

from workbench.diagram.core import make_vehicle_core
from workbench.plant.description import Description
from workbench.plant.vehicle import Vehicle
from workbench.setup import make_setup

sys.path.append(str(Path(__file__).parent))  # for tests that import `reference_flight`


@dataclass
class Rig:
    """A continuous plant with rotors in no air; their commands are the diagram's input."""

    description: Description
    vehicle: Vehicle
    diagram: Diagram
    root: Context

    @property
    def plant(self) -> MultibodyPlant:
        return self.diagram.GetSubsystemByName("plant")

    @property
    def context(self) -> Context:
        """The plant's own Context."""
        return self.plant.GetMyMutableContextFromRoot(self.root)

    @property
    def state(self) -> np.ndarray:
        """q_WB, p_WB, w_WB_W, v_WB_W."""
        return self.plant.GetPositionsAndVelocities(self.context)

    def set_state(self, state) -> None:
        self.plant.SetPositionsAndVelocities(self.context, np.asarray(state, dtype=float))

    def set_speeds(self, speeds) -> None:
        """Turn the rotors at these speeds [rad/s] and command them to stay."""
        rotors = self.diagram.GetSubsystemByName("rotors")
        rotors.GetMyMutableContextFromRoot(self.root).SetContinuousState(speeds)
        self.diagram.GetInputPort("commands").FixValue(self.root, speeds)

    def accelerations(self) -> np.ndarray:
        """Angular and linear acceleration of the base link, in W."""
        return self.plant.get_generalized_acceleration_output_port().Eval(self.context)

    def fly(self, time, accuracy=1e-10) -> None:
        """Integrate up to a time, with the error controlled tightly."""
        simulator = Simulator(self.diagram, self.root)
        simulator.get_mutable_integrator().set_target_accuracy(accuracy)
        simulator.get_mutable_integrator().set_maximum_step_size(0.01)
        simulator.AdvanceTo(time)
        self.root = simulator.get_mutable_context()


def make_rig(description: Description) -> Rig:
    airless = dataclasses.replace(
        description,
        rotors=tuple(
            dataclasses.replace(
                rotor, rotor_drag_coefficient=0.0, rolling_moment_coefficient=0.0, inertia=0.0
            )
            for rotor in description.rotors
        ),
    )
    setup = make_setup(settings={"drag_area": 0.0, "air_density": 1.225}, description=airless)
    diagram = make_vehicle_core(setup)
    return Rig(airless, setup.vehicle, diagram, diagram.CreateDefaultContext())


@pytest.fixture
def rig(description):
    """The shipped drone, its rotors at a standstill."""
    rig = make_rig(description)
    rig.set_speeds(np.zeros(4))
    return rig


@pytest.fixture(scope="session")
def rig_of():
    """Return a rig for any description."""
    return make_rig
