"""Say which files a scenario's vehicle and world are read from; run as a process of its own.

Python tells of each file that it opens to whoever asks, but cannot be asked to be silent again:
so it is a process that ends. What only Drake opens, the meshes of a world, follows from what was
read.
"""

import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pydrake
from pydrake.common.yaml import yaml_load_typed
from pydrake.geometry import Convex, Mesh

from workbench.common.cache import cache_folder
from workbench.common.resources import find_model, models_dir
from workbench.gains.gains import flight_gains
from workbench.plant.formats.model_folder import description_file
from workbench.plant.formats.xacro import is_xacro
from workbench.plant.formats.xacro_child import expand
from workbench.plant.formats.xml import read_xml
from workbench.plant.limited import serve
from workbench.plant.loading import make_vehicle
from workbench.plant.meshes.side_files import side_files
from workbench.plant.packages import PackageFinder
from workbench.plant.worlds.world import World
from workbench.scenario.configured import read_configured, read_configured_world
from workbench.scenario.scenario import Scenario, VehicleConfig

_SYSTEM = ("/dev", "/etc", "/proc", "/run", "/sys")
_CODE = (".py", ".pyc", ".so")
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT
_LOOKED_UP = (
    "AMENT_PREFIX_PATH",
    "GAZEBO_MODEL_PATH",
    "GZ_SIM_RESOURCE_PATH",
    "IGN_GAZEBO_RESOURCE_PATH",
    "ROS_PACKAGE_PATH",
    "SDF_PATH",
)
"""Variables that name folders of packages; a worker has others."""
_MARKERS = ("package.xml", "model.config", "model.sdf")
"""Files that are looked for and not always opened: they make a folder a package or a model."""


def read_files(request: dict[str, str]) -> list[str]:
    """Return the absolute paths of all files that a scenario (YAML text) is read from.

    Raises:
        WorkbenchError: if it cannot be read.
    """
    for variable in _LOOKED_UP:
        os.environ.pop(variable, None)
    scenario = yaml_load_typed(schema=Scenario, data=request["scenario"], defaults=Scenario())
    opened: dict[str, None] = {}

    def note(event: str, arguments: tuple[Any, ...]) -> None:
        if event == "open":
            path, _, flags = arguments
            if isinstance(path, str | os.PathLike) and not (flags or 0) & _WRITING:
                opened[str(Path(path).absolute())] = None

    sys.addaudithook(note)
    vehicle = make_vehicle(read_configured(scenario.vehicle))
    flight_gains(vehicle, scenario.vehicle.gains)
    world = read_configured_world(scenario)
    _expand(scenario.vehicle)
    found = [path for path in map(Path, opened) if _is_input(path)]
    found += _meshes(world)
    found += [side for path in found for side in side_files(path, path.read_bytes())]
    folders = dict.fromkeys(folder for path in found for folder in path.parents)
    found += [folder / marker for folder in folders for marker in _MARKERS]
    return sorted({str(path) for path in found if path.is_file()})


def _expand(config: VehicleConfig) -> None:
    """Expand a xacro file in this process: else it is done in one of its own, unseen."""
    path = description_file(find_model(config.model))
    if path.suffix == ".xacro" or (path.suffix != ".sdf" and is_xacro(read_xml(path))):
        finder = PackageFinder(path, config.packages)
        folders = {name: str(folder) for name, folder in finder.packages.items()}
        expand({"path": str(path), "args": config.args, "source": str(path), "packages": folders})


def _is_input(path: Path) -> bool:
    """Return whether a file is a user's: none of Python's, ours, Drake's or the cache's."""
    ours = (Path(__file__).parents[2], models_dir(), cache_folder("xacro").parent)
    theirs = (*_SYSTEM, Path(pydrake.__file__).parent)
    return (
        path.is_file()
        and path.suffix not in _CODE
        and not any(part.endswith((".dist-info", ".egg-info")) for part in path.parts)
        and not any(path.is_relative_to(folder) for folder in (*ours, *theirs))
    )


def _meshes(world: World) -> Iterator[Path]:
    """Yield the mesh files of a world's obstacles."""
    for obstacle in world.obstacles:
        for geometry in (*obstacle.collisions, *obstacle.visuals):
            shape = geometry.shape()
            if isinstance(shape, Mesh | Convex) and shape.source().is_path():
                yield Path(str(shape.source().path()))


if __name__ == "__main__":
    serve(read_files)
