"""What acts on the bodies of a vehicle, and in its joints."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import ExternallyAppliedSpatialForceMultiplexer, MultibodyPlant
from pydrake.multibody.tree import BodyIndex, RigidBody
from pydrake.systems.framework import DiagramBuilder, InputPort, OutputPort
from pydrake.systems.primitives import MatrixGain

from workbench.common.vectors import float_triple
from workbench.plant.description import Description
from workbench.plant.gathered import merged_model
from workbench.plant.payload import payload_of, vehicle_with_payload
from workbench.plant.rotors import Rotor
from workbench.plant.vehicle import Vehicle
from workbench.systems.ball_forces import BallRow, ball_rows
from workbench.systems.body_forces import BodyForces, BodyForces_
from workbench.systems.body_motion import BodyMotion_
from workbench.systems.cables import Cables, Cables_, cable_rows
from workbench.systems.contact_forces import ContactForces
from workbench.systems.joint_forces import JointForces_, JointRow, joint_rows
from workbench.systems.rotors import Rotors, Rotors_

CABLES_SYSTEM = "cables"
"""Name of the system of the cables, and of its parameters."""
JOINT_FORCES_SYSTEM = "joint_forces"
"""Name of the system of limits, friction, mimics and servos."""


def add_forces(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    description: Description,
    turning: Sequence[Rotor],
    vehicle: Vehicle,
    values: Mapping[str, float],
) -> tuple[Rotors, BodyForces]:
    """Add what acts on the bodies of a vehicle; `connect_forces` connects it.

    Args:
        builder: the diagram being built.
        plant: with the vehicle.
        description: of the vehicle.
        turning: its rotors.
        vehicle: as it flies, without its payload.
        values: of parameters by name; those of air and payload are used.
    """
    base = plant.GetBodyByName(description.base_link)
    carried = [carried_pose(plant, description, rotor.link) for rotor in turning]
    bodies = list(dict.fromkeys([base.index(), *(body.index() for body, _ in carried)]))
    on_bodies = [
        rotor if body.index() == base.index() else _on_body(rotor, X_BL)
        for rotor, (body, X_BL) in zip(turning, carried, strict=True)
    ]
    rotors = builder.AddNamedSystem(
        "rotors",
        Rotors_[float](
            rotors=on_bodies,
            bodies=bodies,
            carriers=[bodies.index(body.index()) for body, _ in carried],
        ),
    )
    body_forces = builder.AddNamedSystem(
        "body_forces",
        BodyForces_[float](
            body=base.index(),
            drag_area=values["drag_area"],
            air_density=values["air_density"],
            p_BoBcm_B=vehicle_with_payload(vehicle, payload_of(values)).p_BoBcm_B,
        ),
    )
    return rotors, body_forces


def carried_pose(
    plant: MultibodyPlant, description: Description, link: str
) -> tuple[RigidBody, RigidTransform]:
    """Return the body L of the plant that a link is part of, and X_BL with all joints at zero.

    A name that no link has stands for the base link.
    """
    base = plant.GetBodyByName(description.base_link)
    if description.model.link(link) is None or link == description.base_link:
        return base, RigidTransform()
    body = plant.GetFrameByName(link, base.model_instance()).body()
    model = merged_model(description.model, description.base_link)
    bodies = {each.name: each for each in model.links}
    X_MB, X_ML = bodies[base.name()].X_ML, bodies[body.name()].X_ML
    return body, X_MB.InvertAndCompose(X_ML)


def _on_body(rotor: Rotor, X_BL: RigidTransform) -> Rotor:
    """Return a rotor with place and axis in the frame of the body L that carries it."""
    place = X_BL.inverse().multiply(np.array(rotor.p_BR))
    axis = X_BL.rotation().inverse().multiply(np.array(rotor.axis_B))
    return replace(rotor, p_BR=float_triple(place), axis_B=float_triple(axis))


def add_cables(
    builder: DiagramBuilder, plant: MultibodyPlant, description: Description
) -> Cables | None:
    """Add the cables of a vehicle, which see the state of their bodies; None without any."""
    drone = plant.GetBodyByName(description.base_link).model_instance()
    rows = cable_rows(plant, description.model, drone)
    if not rows:
        return None
    cables = builder.AddNamedSystem(CABLES_SYSTEM, Cables_[float](rows=rows))
    states = add_body_motion(builder, plant, "cable_bodies", cables.bodies)
    builder.Connect(states, cables.GetInputPort("state"))
    return cables


def add_contact_forces(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    links: Sequence[str],
    base: RigidBody,
    name: str,
) -> OutputPort | None:
    """Return the port of the contact forces on the bodies of some links (3 each), None without."""
    if not links:
        return None
    drone = base.model_instance()
    frames = [plant.GetFrameByName(link, drone) for link in links]
    bodies = [*dict.fromkeys(frame.body().index() for frame in frames)]
    forces = builder.AddNamedSystem(name, ContactForces(bodies=bodies))
    builder.Connect(plant.get_contact_results_output_port(), forces.get_input_port())
    port: OutputPort = forces.get_output_port()
    return port


def connect_forces(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    state: OutputPort,
    rotors: Rotors,
    body_forces: BodyForces,
    cables: Cables | None = None,
) -> None:
    """Let rotors and drag see the state of their bodies (13 each), and act on them with cables."""
    acting = [rotors, body_forces, *([cables] if cables else [])]
    forces = builder.AddNamedSystem("forces", ExternallyAppliedSpatialForceMultiplexer(len(acting)))
    seen = state
    if len(rotors.bodies) > 1:
        seen = add_body_motion(builder, plant, "rotor_bodies", rotors.bodies)
    builder.Connect(seen, rotors.GetInputPort("state"))
    builder.Connect(state, body_forces.GetInputPort("state"))
    for number, system in enumerate(acting):
        builder.Connect(system.GetOutputPort("spatial_forces"), forces.get_input_port(number))
    builder.Connect(forces.get_output_port(), plant.get_applied_spatial_force_input_port())


def add_body_motion(
    builder: DiagramBuilder, plant: MultibodyPlant, name: str, bodies: Sequence[BodyIndex]
) -> OutputPort:
    """Return a port of the states of bodies (13 each), see `BodyMotion_`."""
    motion = builder.AddNamedSystem(name, BodyMotion_[float](bodies=bodies))
    poses, velocities = motion.GetInputPort("body_poses"), motion.GetInputPort("spatial_velocities")
    builder.Connect(plant.get_body_poses_output_port(), poses)
    builder.Connect(plant.get_body_spatial_velocities_output_port(), velocities)
    port: OutputPort = motion.GetOutputPort("state")
    return port


def add_joint_forces(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    description: Description,
    commanded: Sequence[str] = (),
) -> tuple[tuple[JointRow, ...], tuple[BallRow, ...], InputPort | None]:
    """Let limits, friction, springs of balls, mimics and servos act in the joints of a plant.

    Args:
        builder: the diagram being built.
        plant: with the vehicle.
        description: of the vehicle.
        commanded: freedoms whose servos get setpoints.

    Returns:
        Its freedoms, its ball joints, and the port of those setpoints if there are any.
    """
    setpoints = None
    merged = merged_model(description.model, description.base_link)
    rows, balls = joint_rows(plant, merged), ball_rows(plant, merged)
    if balls or any(row.acts for row in rows):
        forces = builder.AddNamedSystem(
            JOINT_FORCES_SYSTEM,
            JointForces_[float](
                rows=rows,
                balls=balls,
                positions=plant.num_positions(),
                velocities=plant.num_velocities(),
                commanded=commanded,
            ),
        )
        builder.Connect(plant.get_state_output_port(), forces.GetInputPort("state"))
        port = forces.GetOutputPort("generalized_forces")
        builder.Connect(port, plant.get_applied_generalized_force_input_port())
        if commanded:
            setpoints = forces.GetInputPort("setpoints")
    return rows, balls, setpoints


def body_places(plant: MultibodyPlant, body: RigidBody) -> np.ndarray:
    """Return the places of a free body's state (13) in that of the plant."""
    positions = body.floating_positions_start() + np.arange(7)
    velocities = body.floating_velocities_start_in_v() + np.arange(6)
    return np.concatenate([positions, plant.num_positions() + velocities])


def joint_places(plant: MultibodyPlant, names: Sequence[str]) -> np.ndarray:
    """Return the places of positions, then velocities, of joints with one freedom (2 n)."""
    joints = [plant.GetJointByName(name) for name in names]
    positions = [joint.position_start() for joint in joints]
    velocities = [plant.num_positions() + joint.velocity_start() for joint in joints]
    return np.array([*positions, *velocities], dtype=int)


def chosen_values(
    builder: DiagramBuilder, name: str, port: OutputPort, places: np.ndarray
) -> OutputPort:
    """Return the values of a port at some places."""
    if len(places) == port.size():
        return port
    gain = builder.AddNamedSystem(name, MatrixGain(np.eye(port.size())[places]))
    builder.Connect(port, gain.get_input_port())
    return gain.get_output_port()
