"""From a description to a finalised Drake `MultibodyPlant` that stands on the ground."""

from pathlib import Path

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant, MultibodyPlantConfig
from pydrake.systems.framework import DiagramBuilder

from workbench.errors import WorkbenchError
from workbench.plant.description import Description
from workbench.plant.ground import add_ground
from workbench.plant.vehicle import GRAVITY


def add_plant(
    builder: DiagramBuilder, description: Description, *, time_step: float
) -> tuple[MultibodyPlant, SceneGraph]:
    """Add a finalised plant with ground and its scene graph, rotors fixed to the body.

    Args:
        builder: the diagram being built.
        description: what flies.
        time_step: step of the discrete plant [s]; 0 makes a continuous plant.

    Raises:
        WorkbenchError: if Drake refuses the description.
    """
    config = MultibodyPlantConfig(
        time_step=time_step,
        use_sampled_output_ports=False,
        contact_model="point",
        discrete_contact_approximation="sap",
    )
    plant, scene_graph = AddMultibodyPlant(config, builder)
    try:
        parser = Parser(plant)
        _add_package(parser, description.source)
        parser.AddModelsFromString(description.with_fixed_rotors(), "urdf")
        plant.mutable_gravity_field().set_gravity_vector(np.array([0.0, 0.0, -GRAVITY]))
        add_ground(plant)
        plant.Finalize()
    except (RuntimeError, ValueError, SystemExit) as error:
        reason = " ".join(str(error).split())
        raise WorkbenchError(f"{description.source}: Drake refuses it: {reason}") from error
    moving = plant.num_positions()
    if moving < 7:
        raise WorkbenchError(
            f"{description.source}: the base link '{description.base_link}' is fixed to the world, "
            "and a drone flies freely: leave out a link named 'world' and its joint"
        )
    if moving > 7:
        raise WorkbenchError(
            f"{description.source}: a drone is one free body with rotors, but {moving - 7} more "
            "joint positions move: fix those joints or declare them as rotors"
        )
    return plant, scene_graph


def _add_package(parser: Parser, source: Path) -> None:
    """Let `package://` find the package that a description belongs to, if it belongs to one."""
    for folder in source.parents:
        package = folder / "package.xml"
        if package.is_file():
            parser.package_map().AddPackageXml(str(package))
            return
