"""The diagrams that the benchmark of the flight core flies: floors, flight core and workbench."""

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from xml.etree import ElementTree as ET

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    MultibodyPlant,
    MultibodyPlantConfig,
    Propeller,
    PropellerInfo,
)
from pydrake.multibody.tree import RigidBody
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import Context, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from workbench.common.resources import find_model
from workbench.control.flight_mode import FlightModeSettings, initial_state
from workbench.control.mode import FlightMode
from workbench.diagram.airframe import Airframe
from workbench.diagram.core import add_sampled_core
from workbench.diagram.workbench import make_workbench
from workbench.plant.description import Description, read_description
from workbench.plant.formats.urdf_writer import write_urdf
from workbench.plant.gathered import merged_model
from workbench.plant.gravity import GRAVITY
from workbench.plant.loading import make_vehicle
from workbench.plant.model import Model
from workbench.plant.multibody import add_plant
from workbench.plant.placing import body_state
from workbench.plant.vehicle import Vehicle
from workbench.plant.worlds.geometry import add_ground
from workbench.scenario.scenario import Rates, Scenario
from workbench.session.integration import AIR_INTEGRATOR
from workbench.setup import Setup, make_setup
from workbench.systems.flight_computer import FlightComputer
from workbench.systems.mode_manager import ModeManager

HEIGHT = 50.0
"""Where they hover [m]."""


@dataclass(frozen=True)
class Flyer:
    """A diagram in the air, ready to fly on.

    Attributes:
        simulator: at its start.
        height: how high the drone is now [m].
        speed: how fast it moves along x now [m/s].
    """

    simulator: Simulator
    height: Callable[[], float]
    speed: Callable[[], float]


class Hangar:
    """Makes flyers of the shipped drone."""

    def __init__(self) -> None:
        self._description: Description = read_description(find_model("dh_drone"))
        self._vehicle: Vehicle = make_vehicle(self._description)

    def _setup(self, rates: Rates) -> Setup:
        return make_setup(
            Scenario(rates=rates), description=self._description, vehicle=self._vehicle
        )

    @property
    def _hover_thrusts(self) -> np.ndarray:
        n = len(self._vehicle.rotors)
        return np.full(n, self._vehicle.mass * GRAVITY / n)

    def described(self, rates: Rates) -> Flyer:
        """Return the description as Drake reads it: a body a link, with all its shapes."""
        return self._spinning(self._description.model, rates)

    def spinning_floor(self, rates: Rates) -> Flyer:
        """Return the least plant with propellers that turn: a body and four propellers, undrawn."""
        model = self._description.undrawn().model
        turning = {rotor.link for rotor in self._vehicle.rotors}
        joints = tuple(joint for joint in model.joints if joint.child in turning)
        propellers = tuple(link for link in model.links if link.name in turning)
        rest = tuple(link for link in model.links if link.name not in turning)
        body = merged_model(dataclasses.replace(model, links=rest), self._vehicle.base_link)
        links = (*body.links, *propellers)
        return self._spinning(dataclasses.replace(model, links=links, joints=joints), rates)

    def _spinning(self, model: Model, rates: Rates) -> Flyer:
        """Return a plant whose propellers turn on their joints, 21 states, under constant thrusts.

        There is no Python in its loop; step, ground and contact are as ours.
        """
        builder = DiagramBuilder()
        config = MultibodyPlantConfig(
            time_step=rates.physics_step,
            use_sampled_output_ports=False,
            contact_model="point",
            discrete_contact_approximation="sap",
        )
        plant, scene_graph = AddMultibodyPlant(config, builder)
        rotors = self._vehicle.rotors
        robot = write_urdf(model, [rotor.joint for rotor in rotors])
        Parser(plant).AddModelsFromString(ET.tostring(robot, encoding="unicode"), "urdf")
        add_ground(plant, scene_graph)
        plant.Finalize()
        assert plant.num_multibody_states() == 13 + 2 * len(rotors)
        infos = [
            PropellerInfo(
                plant.GetBodyByName(rotor.link).index(),
                RigidTransform(),
                moment_ratio=-rotor.direction * rotor.moment_constant,
            )
            for rotor in rotors
        ]
        forces = builder.AddSystem(Propeller(infos))
        builder.Connect(plant.get_body_poses_output_port(), forces.get_body_poses_input_port())
        builder.Connect(
            forces.get_spatial_forces_output_port(), plant.get_applied_spatial_force_input_port()
        )
        thrusts = builder.AddSystem(ConstantVectorSource(self._hover_thrusts))
        builder.Connect(thrusts.get_output_port(), forces.get_command_input_port())
        return self._lifted(Simulator(builder.Build()), plant)

    def floor(self, rates: Rates) -> Flyer:
        """Return Drake's plant of the drone, under a constant force, without Python: 13 states."""
        builder = DiagramBuilder()
        plant, _ = add_plant(builder, self._description.undrawn(), time_step=rates.physics_step)
        lift = [*[0.0] * 5, self._vehicle.mass * GRAVITY]
        force = builder.AddSystem(ConstantVectorSource(lift))
        builder.Connect(force.get_output_port(), plant.get_applied_generalized_force_input_port())
        return self._lifted(Simulator(builder.Build()), plant)

    def core(self, rates: Rates) -> Flyer:
        """Return the flight core in closed loop, with rotor dynamics and flight mode."""
        builder = DiagramBuilder()
        setup = self._setup(rates)
        airframe, computer = add_sampled_core(builder, setup)
        settings = FlightModeSettings(**setup.of_system("modes"))
        clearance = self._vehicle.ground_clearance
        modes = builder.AddNamedSystem(
            "modes",
            ModeManager(period=rates.mode_period, settings=settings, standing_height=clearance),
        )
        builder.Connect(airframe.state, modes.GetInputPort("state"))
        builder.Connect(modes.GetOutputPort("guidance"), computer.GetInputPort("guidance"))
        simulator = Simulator(builder.Build())
        root = simulator.get_mutable_context()
        context = modes.GetMyMutableContextFromRoot(root)
        for name, value in (("reference", [0.0] * 8), ("request", [0.0] * 3), ("charge", [1.0])):
            modes.GetInputPort(name).FixValue(context, value)
        context = computer.GetMyMutableContextFromRoot(root)
        computer.GetInputPort("reference").FixValue(context, [0.0] * 8)
        return self._hovering(simulator, airframe, computer, modes)

    def workbench(self, rates: Rates) -> Flyer:
        """Return the whole workbench: with air, battery, pilot, frames and recorder besides."""
        bench = make_workbench(self._setup(rates))
        simulator = Simulator(bench.diagram)
        return self._hovering(simulator, bench.airframe, bench.computer, bench.modes)

    def _hovering(
        self, simulator: Simulator, airframe: Airframe, computer: FlightComputer, modes: ModeManager
    ) -> Flyer:
        """Let body, rotors and flight mode be those of hovering."""
        root, at, still = simulator.get_mutable_context(), [0.0, 0.0, HEIGHT], [0.0] * 3
        state = body_state(p_WB=at, roll_pitch_yaw=still, v_WB=still, w_WB=still)
        airframe.place(root, state, self._vehicle.hover_speeds)
        context = computer.GetMyMutableContextFromRoot(root)
        computer.begin(context, self._vehicle.hover_speeds, np.zeros(3))
        context = modes.GetMyMutableContextFromRoot(root)
        modes.set_mode(context, initial_state(FlightMode.HOVERING, at), at)
        period = computer.period
        ResetIntegratorFromFlags(simulator, AIR_INTEGRATOR, period).set_fixed_step_mode(True)
        simulator.Initialize()
        return Flyer(
            simulator,
            lambda: float(airframe.body_state(root)[6]),
            lambda: float(airframe.body_state(root)[10]),
        )

    def _lifted(self, simulator: Simulator, plant: MultibodyPlant) -> Flyer:
        """Put a plant's drone in the air."""
        base = plant.GetBodyByName(self._vehicle.base_link)
        context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
        plant.SetFreeBodyPose(context, base, RigidTransform([0.0, 0.0, HEIGHT]))
        simulator.Initialize()
        return Flyer(
            simulator,
            lambda: float(plant.EvalBodyPoseInWorld(context, base).translation()[2]),
            lambda: speed_of(plant, context, base),
        )


def speed_of(plant: MultibodyPlant, context: Context, body: RigidBody) -> float:
    """Return how fast a body of a plant moves along x [m/s]."""
    return float(plant.EvalBodySpatialVelocityInWorld(context, body).translational()[0])
