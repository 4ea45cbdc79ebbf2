"""The files that flights read, sent along to workers that share no disk with this machine.

On a worker they are in a separate folder with the same folder structure as here, so that searches
beside or above a description find the same files.

A separate process that runs this file finds out which files are read. It uses an audit hook of
Python, which cannot be removed again: hence a process that ends. Files opened only by Drake, the
meshes of a world, follow from those read.
"""

import copy
import hashlib
import os
import pickle
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pydrake
from pydrake.common.yaml import yaml_dump_typed
from pydrake.geometry import Convex, Mesh

from workbench.common.cache import cache_folder
from workbench.common.errors import WorkbenchError
from workbench.common.resources import (
    find_file,
    find_model,
    find_world,
    list_models,
    list_worlds,
    models_dir,
)
from workbench.control.schedule import split_label
from workbench.ipc.limited import LimitedError, run_trusted, serve_one_request
from workbench.plant.description import expands
from workbench.plant.formats.model_folder import description_file
from workbench.plant.formats.xacro import files_of_xacro
from workbench.plant.meshes.side_files import side_files
from workbench.plant.packages import PackageFinder
from workbench.plant.worlds.world import World
from workbench.scenario.flown_controller import flown_controller
from workbench.scenario.scenario import Scenario, VehicleConfig
from workbench.scenario.scenario_file import parse_scenario
from workbench.setup import make_setup

MAX_SHIPMENT_BYTES = 200_000_000
"""Size limit of all files of a scenario [bytes]."""
_SHIPMENT_MODULE = "workbench.design.executor.shipment"
_SHIPMENT_TIMEOUT_S = 120.0
_SHIPMENT_MEMORY_MB = 16_000

_SYSTEM_FOLDERS = ("/dev", "/etc", "/proc", "/run", "/sys")
_CODE_SUFFIXES = (".py", ".pyc", ".so")
_WRITE_FLAGS = os.O_WRONLY | os.O_RDWR | os.O_CREAT
_PACKAGE_PATH_VARIABLES = (
    "AMENT_PREFIX_PATH",
    "GAZEBO_MODEL_PATH",
    "GZ_SIM_RESOURCE_PATH",
    "IGN_GAZEBO_RESOURCE_PATH",
    "ROS_PACKAGE_PATH",
    "SDF_PATH",
)
"""Environment variables with folders of packages; a worker has others."""
_PACKAGE_MARKERS = ("package.xml", "model.config", "model.sdf")
"""Files that mark a folder as a package or a model, and are not always opened."""


def shipment(scenario: Scenario) -> dict[str, bytes] | None:
    """Return the files of a scenario by their absolute paths here.

    Return None if all of them are shipped with the workbench.

    Packages found through environment variables are not included, as workers have others.

    Args:
        scenario: with absolute paths.

    Raises:
        WorkbenchError: if the scenario cannot be read like this, or its files are too large to
            send.
    """
    if not any(True for _ in _own_paths(scenario)):
        return None
    try:
        names = run_trusted(
            _SHIPMENT_MODULE,
            {"scenario": yaml_dump_typed(scenario)},
            seconds=_SHIPMENT_TIMEOUT_S,
            megabytes=_SHIPMENT_MEMORY_MB,
        )
    except LimitedError as error:
        raise WorkbenchError(
            f"{scenario.vehicle.model}: its files cannot be found: {error}"
        ) from error
    size = sum(Path(name).stat().st_size for name in names)
    if size > MAX_SHIPMENT_BYTES:
        raise WorkbenchError(
            f"{scenario.vehicle.model}: is read from {size // 1_000_000} MB of files, and at most "
            f"{MAX_SHIPMENT_BYTES // 1_000_000} MB are sent to workers: fly it with smaller meshes"
        )
    return {name: Path(name).read_bytes() for name in names}


def unpack_shipment(files: bytes, kept: Path) -> Path:
    """Return the folder in `kept` with the files of a pickled shipment, written if necessary."""
    folder = kept / hashlib.sha256(files).hexdigest()[:32]
    if not folder.is_dir():
        partial = Path(tempfile.mkdtemp(dir=kept, prefix=".partial-"))
        for path, content in pickle.loads(files).items():
            file = _below(partial, path)
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(content)
        try:
            partial.rename(folder)
        except OSError:  # another thread was faster
            shutil.rmtree(partial, ignore_errors=True)
    return folder


def with_absolute_paths(scenario: Scenario) -> Scenario:
    """Return a scenario with absolute paths of files; shipped names stay the same.

    Raises:
        WorkbenchError: if one of them does not exist.
    """
    found = copy.deepcopy(scenario)
    vehicle = found.vehicle
    if vehicle.model not in list_models():
        vehicle.model = str(find_model(vehicle.model))
    vehicle.rotors = str(find_file(vehicle.rotors)) if vehicle.rotors else ""
    vehicle.gains = str(find_file(vehicle.gains)) if vehicle.gains else ""
    for name, folder in vehicle.packages.items():
        vehicle.packages[name] = str(Path(folder).expanduser().resolve())
    if found.world not in list_worlds():
        found.world = str(find_world(found.world))
    law = flown_controller(found)
    if split_label(found.controller)[0].endswith(".py"):
        found.controller = law.reference
    if law.estimator:
        found.estimator = str(law.estimator.file)
    return found


def moved_below(root: Path, scenario: Scenario) -> Scenario:
    """Return a scenario with absolute paths of files moved below a folder."""

    def moved(path: str) -> str:
        return str(_below(root, path)) if path.startswith("/") else path

    found = copy.deepcopy(scenario)
    vehicle = found.vehicle
    vehicle.model, vehicle.rotors = moved(vehicle.model), moved(vehicle.rotors)
    vehicle.gains, found.world = moved(vehicle.gains), moved(found.world)
    found.controller, found.estimator = moved(found.controller), moved(found.estimator)
    for name, folder in vehicle.packages.items():
        vehicle.packages[name] = moved(folder)
        # a folder without files that are read exists as well
        Path(vehicle.packages[name]).mkdir(parents=True, exist_ok=True)
    return found


def _below(root: Path, path: str) -> Path:
    """Return the location of an absolute path below a folder."""
    return root / path.lstrip("/")


def _own_paths(scenario: Scenario) -> Iterator[str]:
    """Yield the files named in a scenario that are not shipped with the workbench."""
    vehicle = scenario.vehicle
    yield from (name for name in (vehicle.rotors, vehicle.gains) if name)
    yield from vehicle.packages.values()
    if vehicle.model not in list_models():
        yield vehicle.model
    if scenario.world not in list_worlds():
        yield scenario.world
    yield from _own_code(scenario)


def _own_code(scenario: Scenario) -> list[str]:
    """Return the files of the user's own controller and estimator."""
    return [name for name in (scenario.controller, scenario.estimator) if name.endswith(".py")]


def read_files(request: dict[str, str]) -> list[str]:
    """Return the absolute paths of all files read for a scenario (YAML text).

    Raises:
        WorkbenchError: if it cannot be read.
    """
    for variable in _PACKAGE_PATH_VARIABLES:
        os.environ.pop(variable, None)
    scenario = parse_scenario(Path("the scenario"), request["scenario"])
    opened: dict[str, None] = {}

    def note(event: str, arguments: tuple[Any, ...]) -> None:
        if event == "open":
            path, _, flags = arguments
            if isinstance(path, str | os.PathLike) and not (flags or 0) & _WRITE_FLAGS:
                opened[str(Path(path).absolute())] = None

    sys.addaudithook(note)
    world = make_setup(scenario).world
    parts = _xacro_files(scenario.vehicle)
    found = [path for path in (*map(Path, opened), *parts) if _is_input(path)]
    found += _meshes(world)
    found += map(Path, _own_code(scenario))
    found += [side for path in found for side in side_files(path, path.read_bytes())]
    folders = dict.fromkeys(folder for path in found for folder in path.parents)
    found += [folder / marker for folder in folders for marker in _PACKAGE_MARKERS]
    return sorted({str(path) for path in found if path.is_file()})


def _xacro_files(config: VehicleConfig) -> list[Path]:
    """Return the files of a xacro description, which another process reads, unobserved."""
    path = description_file(find_model(config.model))
    if expands(path):
        return files_of_xacro(path, config.args, PackageFinder(path, config.packages))
    return []


def _is_input(path: Path) -> bool:
    """Return whether a file belongs to the user, not to Python, us, Drake or the cache."""
    ours = (Path(__file__).parents[2], models_dir(), cache_folder("xacro").parent)
    theirs = (*_SYSTEM_FOLDERS, Path(pydrake.__file__).parent)
    return (
        path.is_file()
        and path.suffix not in _CODE_SUFFIXES
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
    serve_one_request(read_files)
