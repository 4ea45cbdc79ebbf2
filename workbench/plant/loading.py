"""From a description to a `Vehicle` record."""

import dataclasses
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import PrismaticJoint, QuaternionFloatingJoint, RigidBody
from pydrake.systems.framework import Context, DiagramBuilder

from workbench.common.errors import WorkbenchError
from workbench.common.vectors import float_triple
from workbench.plant.cables import TAUT_TOLERANCE_M, cable_distance, cable_ends
from workbench.plant.description import Description, read_description
from workbench.plant.formats.values import listed_names, shortened_text
from workbench.plant.gathered import body_roots, merged_model
from workbench.plant.model import Cable, Model
from workbench.plant.multibody import add_plant
from workbench.plant.rotor_sources.sidecar import sidecar_name
from workbench.plant.rotors import allocation_matrix
from workbench.plant.servos import servo_freedoms
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, GeometryShape, Mesh, Sphere
from workbench.plant.swinging import turned_body
from workbench.plant.tree import hooked_cables, links_below, without_loads
from workbench.plant.vehicle import Vehicle, VehicleFrame, VehicleJoint, VehicleServo

_SINGULAR_SHARE = 1e-13
"""Smallest eigenvalue of the mass matrix, over its diagonal, that is not taken for rounding."""


def load_vehicle(
    path: Path | str,
    args: Mapping[str, str] | None = None,
    packages: Mapping[str, str] | None = None,
    rotors: Path | str = "",
) -> Vehicle:
    """Return the `Vehicle` record of a description, see `read_description`.

    Raises:
        WorkbenchError: if it cannot be read, or cannot fly.
    """
    return make_vehicle(read_description(path, args, packages, rotors))


def make_vehicle(description: Description) -> Vehicle:
    """Return the `Vehicle` record of a description that was read.

    Mass, centre of mass and inertia are those of all bodies in Drake as the description has them,
    with rotors at rest.

    Raises:
        WorkbenchError: if it has fewer than four rotors or they cannot control it.
    """
    _check_rotors(description)
    builder = DiagramBuilder()
    plant, _ = add_plant(builder, description, time_step=0.0)
    diagram = builder.Build()
    root_context = diagram.CreateDefaultContext()
    context = plant.GetMyMutableContextFromRoot(root_context)
    _refuse_singular(plant, context, description)
    base = plant.GetBodyByName(description.base_link)
    first = base.floating_positions_start()
    at_zero = np.zeros(plant.num_positions())
    at_zero[first : first + 7] = plant.GetPositions(context)[first : first + 7]
    for joint in map(plant.get_joint, plant.GetJointIndices(base.model_instance())):
        if (
            joint.type_name() == QuaternionFloatingJoint.kTypeName
            and joint.position_start() != first
        ):
            at_zero[joint.position_start()] = 1.0
    plant.SetPositions(context, at_zero)
    whole = plant.GetBodyIndices(base.model_instance())
    inertia = plant.CalcSpatialInertia(context, base.body_frame(), whole)
    p_BoBcm_B = inertia.get_com()
    I_BBcm_B = inertia.Shift(p_BoBcm_B).CalcRotationalInertia().CopyToFullMatrix3()
    _check_inertia(description, I_BBcm_B)
    links = [link.name for link in description.model.links]
    X_BF = {
        name: plant.GetFrameByName(name, base.model_instance()).CalcPose(context, base.body_frame())
        for name in links
    }
    try:
        allocation_matrix(description.rotors, p_BoBcm_B, description.tilts)
    except WorkbenchError as error:
        text = f"{description.source}: {error}{_joints_at_zero(description)}"
        raise WorkbenchError(text) from None
    merged = merged_model(description.model, description.base_link)
    bare = without_loads(description.model)
    vehicle = Vehicle(
        name=description.name,
        source=description.source,
        base_link=description.base_link,
        mass=float(inertia.get_mass()),
        p_BoBcm_B=float_triple(p_BoBcm_B),
        I_BBcm_B=_matrix_rows(I_BBcm_B),
        rotors=description.rotors,
        sensors=description.sensors,
        frames=tuple(
            VehicleFrame(name, float_triple(X.translation()), _matrix_rows(X.rotation().matrix()))
            for name, X in X_BF.items()
        ),
        ground_clearance=ground_clearance(bare, description.base_link),
        battery=description.battery,
        joints=tuple(_vehicle_joints(description.model)),
        cables=tuple(cable.name for cable in description.model.cables),
        contact_links=_contact_links(description),
        joint_signals=tuple(_joint_signals(plant, base)),
        turned=turned_body(plant, context, merged, _taut_cables(plant, context, description)),
        servos=tuple(_vehicle_servos(plant, context, merged)),
        tilts=description.tilts,
        unloaded=(
            make_vehicle(dataclasses.replace(description, model=bare))
            if description.model.loads
            else None
        ),
    )
    _check_lift(vehicle)
    return vehicle


def _taut_cables(plant: MultibodyPlant, context: Context, description: Description) -> list[Cable]:
    """Return the cables that hold loads, and those between other links that are not slack."""
    drone = plant.GetBodyByName(description.base_link).model_instance()
    hooked = hooked_cables(description.model)
    return [
        each
        for each in description.model.cables
        if each in hooked
        or cable_distance(plant, context, cable_ends(plant, each, drone))
        >= each.length - TAUT_TOLERANCE_M
    ]


def _check_rotors(description: Description) -> None:
    """Reject a drone without mass, or with too few rotors to fly."""
    count = len(description.rotors)
    if count < (3 if description.tilts else 4):
        found = f"{count} rotors are declared" if count else "no rotors are declared"
        raise WorkbenchError(
            f"{description.source}: {found}, a multirotor has four or more: add a motor-model "
            f"plugin for each, or a sidecar {sidecar_name(description.source)} beside it (see "
            "docs/descriptions.md)"
        )
    if not any(link.inertial for link in description.model.links):
        raise WorkbenchError(
            f"{description.source}: no link has a mass: give "
            f"'{shortened_text(description.base_link)}' an <inertial> element"
        )


def _vehicle_joints(model: Model) -> Iterator[VehicleJoint]:
    """Yield the joints that move, with what they move."""
    for joint in model.joints:
        if joint.moves:
            below = links_below(model, joint.child)
            links = [link for link in model.links if link.name in below]
            mass = sum(link.inertial.mass for link in links if link.inertial)
            names = (joint.child, *(link.name for link in links if link.name != joint.child))
            freedoms = sum(each.count for each in joint.freedoms)
            yield VehicleJoint(
                joint.name, joint.kind, joint.parent, joint.child, freedoms, names, mass
            )


def _contact_links(description: Description) -> tuple[str, ...]:
    """Return the first link of each body that can touch something, () without joints that move."""
    model = description.model
    if not any(joint.moves for joint in model.joints):
        return ()
    roots = body_roots(model, description.base_link)
    return tuple(dict.fromkeys(roots[link.name] for link in model.links if link.collisions))


def _vehicle_servos(
    plant: MultibodyPlant, context: Context, merged: Model
) -> Iterator[VehicleServo]:
    """Yield the servos, with gains for the inertia that each moves."""
    if not any(each.servo for joint in merged.joints for each in joint.freedoms):
        return
    inverse = np.linalg.inv(plant.CalcMassMatrix(context))
    for name, freedom, servo in servo_freedoms(merged.joints):
        place = plant.GetJointByName(name).velocity_start()
        inertia = 1.0 / float(inverse[place, place])
        yield VehicleServo(name, freedom.kind == "prismatic", servo.driving(inertia))


def _joint_signals(plant: MultibodyPlant, base: RigidBody) -> Iterator[tuple[str, str]]:
    """Yield Drake's names of the states of joints, with units."""
    names = plant.GetStateNames(add_model_instance_prefix=False)
    first, speed = base.floating_positions_start(), base.floating_velocities_start_in_v()
    count = plant.num_positions()
    own = {*range(first, first + 7), *range(count + speed, count + speed + 6)}
    metres, plain = set[int](), set[int]()
    for joint in map(plant.get_joint, plant.GetJointIndices()):
        q, v = joint.position_start(), count + joint.velocity_start()
        if joint.type_name() == PrismaticJoint.kTypeName:
            metres |= {q, v}
        elif joint.type_name() == QuaternionFloatingJoint.kTypeName:
            plain |= {*range(q, q + 4)}
            metres |= {*range(q + 4, q + 7), *range(v + 3, v + 6)}
    for place, name in enumerate(names):
        if place not in own:
            unit = "1" if place in plain else "m" if place in metres else "rad"
            yield name, unit if place < count else f"{unit}/s"


def _joints_at_zero(flown: Description | Vehicle) -> str:
    """Return a clause on joints, which stood at zero for a refusal; "" if there are none."""
    joints = flown.joints if isinstance(flown, Vehicle) else _vehicle_joints(flown.model)
    names = [joint.name for joint in joints]
    return f"; with {listed_names(names)} at zero" if names else ""


def _refuse_singular(plant: MultibodyPlant, context: Context, description: Description) -> None:
    """Reject joints that move nothing of its own: without inertia there is no acceleration."""
    mass = plant.CalcMassMatrix(context)
    scale = np.sqrt(np.maximum(np.diag(mass), 1e-300))
    values, vectors = np.linalg.eigh(mass / np.outer(scale, scale))
    if values[0] > _SINGULAR_SHARE:
        return
    worst = int(np.argmax(np.abs(vectors[:, 0])))
    names = plant.GetVelocityNames(add_model_instance_prefix=False)
    raise WorkbenchError(
        f"{description.source}: nothing has the inertia that a motion of joints needs, most of all "
        f"'{shortened_text(names[worst])}': give the links below it mass and moments of inertia"
    )


def _check_inertia(description: Description, I_BBcm_B: np.ndarray) -> None:
    """Reject a drone without rotational inertia."""
    moments = np.linalg.eigvalsh(I_BBcm_B)
    if not moments[0] > 1e-12:
        raise WorkbenchError(
            f"{description.source}: the whole drone has the principal moments of inertia "
            f"{', '.join(f'{moment:.3g}' for moment in moments)} kg m^2: give its links inertia"
        )


def _check_lift(vehicle: Vehicle) -> None:
    """Reject a drone that is too heavy for its rotors."""
    for rotor, speed in zip(vehicle.rotors, vehicle.hover_speeds, strict=True):
        if speed >= rotor.max_rot_velocity:
            raise WorkbenchError(
                f"{vehicle.source}: {vehicle.mass:.4g} kg is too heavy: to hover, "
                f"'{shortened_text(rotor.name)}' would turn at {speed:.0f} rad/s, and its largest "
                f"speed is {rotor.max_rot_velocity:g}: check the mass (kg), the motor constant "
                "(N s², not per RPM²) and that speed (rad/s)"
                f"{_joints_at_zero(vehicle)}"
            )


def _matrix_rows(matrix: np.ndarray) -> tuple[tuple[float, float, float], ...]:
    return tuple(float_triple(row) for row in matrix)


def ground_clearance(model: Model, base_link: str) -> float:
    """Return the depth of the lowest collision point below the origin of the base link [m].

    Args:
        model: its collision meshes are convex hulls in .obj files.
        base_link: its frame is upright.
    """
    base = model.link(base_link)
    assert base
    X_BM = base.X_ML.inverse()
    depths = [
        _depth(X_BM @ link.X_ML @ collision.X_LS, collision.shape)
        for link in model.links
        for collision in link.collisions
    ]
    return max(depths, default=0.0)


def _depth(X_BC: RigidTransform, shape: GeometryShape) -> float:
    """Return the depth of a shape C below the origin of B, by its support function."""
    down_C = -X_BC.rotation().matrix()[2]  # the direction down, in the shape's own frame
    across, along = float(np.hypot(*down_C[:2])), float(abs(down_C[2]))
    match shape:
        case Box(size):
            reach = 0.5 * float(np.abs(down_C) @ size)
        case Sphere(radius):
            reach = radius
        case Cylinder(radius, length):
            reach = radius * across + 0.5 * length * along
        case Capsule(radius, length):
            reach = radius + 0.5 * length * along
        case Ellipsoid(radii):
            reach = float(np.linalg.norm(down_C * radii))
        case Mesh():
            reach = float(np.max(_vertices(shape) @ down_C))
    return reach - float(X_BC.translation()[2])


def _vertices(mesh: Mesh) -> np.ndarray:
    """Return the corners of a converted hull (n, 3) [m]."""
    assert mesh.path
    lines = mesh.path.read_text(encoding="utf-8").splitlines()
    return np.array([line.split()[1:4] for line in lines if line.startswith("v ")], dtype=float)
