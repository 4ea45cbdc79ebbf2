"""From a description to a finalised Drake `MultibodyPlant` that stands in a world."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant, MultibodyPlantConfig
from pydrake.systems.framework import DiagramBuilder

from workbench.errors import WorkbenchError
from workbench.plant.description import Description
from workbench.plant.gravity import GRAVITY
from workbench.plant.ground import add_ground
from workbench.plant.worlds.placing import add_obstacles
from workbench.plant.worlds.world import EMPTY, World


def add_plant(
    builder: DiagramBuilder, description: Description, *, time_step: float, world: World = EMPTY
) -> tuple[MultibodyPlant, SceneGraph]:
    """Add a finalised plant with the world around it and its scene graph, rotors fixed to the body.

    The drone's bodies are all there are; obstacles that stand still are shapes of the world body,
    and those that move are added by `systems.moving_obstacles`.

    Args:
        builder: the diagram being built.
        description: what flies.
        time_step: step of the discrete plant [s]; 0 makes a continuous plant.
        world: where it flies.

    Raises:
        WorkbenchError: if Drake refuses the description or the world.
    """
    config = MultibodyPlantConfig(
        time_step=time_step,
        use_sampled_output_ports=False,
        contact_model="point",
        discrete_contact_approximation="sap",
    )
    plant, scene_graph = AddMultibodyPlant(config, builder)
    with _sentences(description.source):
        Parser(plant).AddModelsFromString(description.with_fixed_rotors(), "urdf")
        plant.mutable_gravity_field().set_gravity_vector(np.array([0.0, 0.0, -GRAVITY]))
    with _sentences(world.source):
        if world.ground:
            add_ground(plant, scene_graph)
        add_obstacles(plant, world)
    with _sentences(description.source):
        plant.Finalize()
    return plant, scene_graph


@contextmanager
def _sentences(source: Path) -> Iterator[None]:
    """Turn what Drake says of a file into a sentence."""
    try:
        yield
    except (RuntimeError, ValueError, SystemExit) as error:
        reason = " ".join(str(error).split())
        raise WorkbenchError(f"{source}: Drake refuses it: {reason}") from error
