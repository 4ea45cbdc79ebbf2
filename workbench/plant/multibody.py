"""From a description to a finalised Drake `MultibodyPlant` that stands in a world."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import FixedOffsetFrame
from pydrake.systems.framework import DiagramBuilder

from workbench.errors import WorkbenchError
from workbench.plant.description import Description
from workbench.plant.formats.urdf_writer import write_urdf
from workbench.plant.gathered import gathered
from workbench.plant.gravity import GRAVITY
from workbench.plant.ground import add_ground
from workbench.plant.worlds.placing import add_obstacles
from workbench.plant.worlds.world import EMPTY, World


def add_plant(
    builder: DiagramBuilder, description: Description, *, time_step: float, world: World = EMPTY
) -> tuple[MultibodyPlant, SceneGraph]:
    """Add a finalised plant with the world around it and its scene graph.

    The drone is one body, that of its base link; its other links are frames on it. Rotors at any
    speed are part of it: their spin lives in the rotor lag, their gyroscopic moment is neglected,
    and only the picture turns them. Obstacles that stand still are shapes of the world body, and
    those that move are added by `systems.moving_obstacles`.

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
        _add_drone(plant, description)
        plant.mutable_gravity_field().set_gravity_vector(np.array([0.0, 0.0, -GRAVITY]))
    with _sentences(world.source):
        if world.ground:
            add_ground(plant, scene_graph)
        add_obstacles(plant, world)
    with _sentences(description.source):
        plant.Finalize()
    return plant, scene_graph


def _add_drone(plant: MultibodyPlant, description: Description) -> None:
    """Add the drone's body, with frames named as its links."""
    model = gathered(description.model, description.base_link)
    Parser(plant).AddModelsFromString(ET.tostring(write_urdf(model), encoding="unicode"), "urdf")
    base = plant.GetBodyByName(description.base_link)
    for frame in model.frames:
        plant.AddFrame(FixedOffsetFrame(frame.name, base.body_frame(), frame.X_LF))


@contextmanager
def _sentences(source: Path) -> Iterator[None]:
    """Turn what Drake says of a file into a sentence."""
    try:
        yield
    except (RuntimeError, ValueError, SystemExit) as error:
        reason = " ".join(str(error).split())
        raise WorkbenchError(f"{source}: Drake refuses it: {reason}") from error
