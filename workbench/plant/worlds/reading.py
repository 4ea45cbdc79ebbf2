"""Read a world, whatever it is written in."""

from collections.abc import Mapping
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.plant.worlds.world import World
from workbench.plant.worlds.world_yaml import read_world_yaml

MOST_SHAPES = 1000
"""With so many a flight is slower than real time, and building it takes ten seconds."""


def read_world(path: Path | str, packages: Mapping[str, Path | str] | None = None) -> World:
    """Read a world: a YAML file of our own, or a Gazebo world (.sdf or .world).

    Args:
        path: the file.
        packages: folders of ROS packages and Gazebo models by name, besides those that are found
            above and beside the file and through the environment.

    Raises:
        WorkbenchError: in one sentence, with file and line where that is known.
    """
    path = Path(path)
    if path.is_dir():
        raise WorkbenchError(f"{path}: is a folder: give the world's file in it")
    if path.suffix in (".yaml", ".yml"):
        world = read_world_yaml(path, packages or {})
    elif path.suffix in (".sdf", ".world"):
        from workbench.plant.worlds.gazebo_world import read_gazebo_world

        world = read_gazebo_world(path, packages or {})
    else:
        raise WorkbenchError(f"{path}: a world is a .yaml file, or a .sdf or .world of Gazebo")
    shapes = sum(max(len(each.visuals), len(each.collisions)) for each in world.obstacles)
    if shapes > MOST_SHAPES:
        raise WorkbenchError(
            f"{path}: has {shapes} shapes, more than {MOST_SHAPES}: leave some out"
        )
    return world
