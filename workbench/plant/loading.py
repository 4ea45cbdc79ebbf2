"""From a description to a `Vehicle` record."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.framework import DiagramBuilder

from workbench.common.errors import WorkbenchError
from workbench.plant.description import Description, read_description
from workbench.plant.formats.values import shortened
from workbench.plant.model import Model
from workbench.plant.multibody import add_plant
from workbench.plant.rotor_sources.sidecar import sidecar_name
from workbench.plant.rotors import allocation_matrix
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, Mesh, Shape, Sphere
from workbench.plant.vehicle import Frame, Vehicle


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
    context = plant.GetMyContextFromRoot(root_context)
    base = plant.GetBodyByName(description.base_link)
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
        allocation_matrix(description.rotors, p_BoBcm_B)
    except WorkbenchError as error:
        raise WorkbenchError(f"{description.source}: {error}") from None
    vehicle = Vehicle(
        name=description.name,
        source=description.source,
        base_link=description.base_link,
        mass=float(inertia.get_mass()),
        p_BoBcm_B=_triple(p_BoBcm_B),
        I_BBcm_B=_rows(I_BBcm_B),
        rotors=description.rotors,
        sensors=description.sensors,
        frames=tuple(
            Frame(name, _triple(X.translation()), _rows(X.rotation().matrix()))
            for name, X in X_BF.items()
        ),
        ground_clearance=ground_clearance(description.model, description.base_link),
        battery=description.battery,
    )
    _check_lift(vehicle)
    return vehicle


def _check_rotors(description: Description) -> None:
    """Reject a drone without mass, or with too few rotors to fly."""
    count = len(description.rotors)
    if count < 4:
        found = f"{count} rotors are declared" if count else "no rotors are declared"
        raise WorkbenchError(
            f"{description.source}: {found}, a multirotor has four or more: add a motor-model "
            f"plugin for each, or a sidecar {sidecar_name(description.source)} beside it (see "
            "docs/descriptions.md)"
        )
    if not any(link.inertial for link in description.model.links):
        raise WorkbenchError(
            f"{description.source}: no link has a mass: give "
            f"'{shortened(description.base_link)}' an <inertial> element"
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
                f"'{shortened(rotor.name)}' would turn at {speed:.0f} rad/s, and its largest "
                f"speed is {rotor.max_rot_velocity:g}: check the mass (kg), the motor constant "
                "(N s², not per RPM²) and that speed (rad/s)"
            )


def _triple(values: np.ndarray) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return (x, y, z)


def _rows(matrix: np.ndarray) -> tuple[tuple[float, float, float], ...]:
    return tuple(_triple(row) for row in matrix)


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


def _depth(X_BC: RigidTransform, shape: Shape) -> float:
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
