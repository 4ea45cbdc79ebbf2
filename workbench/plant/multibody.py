"""From a description to a finalised Drake `MultibodyPlant` that stands on the ground."""

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant, MultibodyPlantConfig
from pydrake.systems.framework import DiagramBuilder

from workbench.errors import WorkbenchError
from workbench.plant.description import Description
from workbench.plant.gravity import GRAVITY
from workbench.plant.ground import add_ground


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
        Parser(plant).AddModelsFromString(description.with_fixed_rotors(), "urdf")
        plant.mutable_gravity_field().set_gravity_vector(np.array([0.0, 0.0, -GRAVITY]))
        add_ground(plant)
        plant.Finalize()
    except (RuntimeError, ValueError, SystemExit) as error:
        reason = " ".join(str(error).split())
        raise WorkbenchError(f"{description.source}: Drake refuses it: {reason}") from error
    return plant, scene_graph
