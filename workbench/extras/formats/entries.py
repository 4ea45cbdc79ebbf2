"""What this package adds to the workbench, named by the entry points of pyproject.toml.

The readers are imported when a file is read in their format: they take a tenth of Drake's time.
"""

from collections.abc import Callable
from importlib import import_module
from typing import Any

from workbench.extras.formats.model_folder import FOLDER_MARK, file_in_model_folder
from workbench.plant.readers import DescriptionFormat, RotorDialect, WorldFormat


def _later(module: str, name: str) -> Callable[..., Any]:
    """Return a function of a module of this package, which is imported at the first call."""
    return lambda *args: getattr(import_module(f"{__package__}.{module}"), name)(*args)


_read_sdf, _is_pybullet = _later("sdf", "read_sdf"), _later("pybullet", "is_pybullet")
SDF = DescriptionFormat(
    lambda path, root, finder, remarks: _read_sdf(path, finder, remarks, root),
    roots=("sdf",),
    suffixes=(".sdf",),
    find_in_folder=file_in_model_folder,
    folder_mark=FOLDER_MARK,
)
MJCF = DescriptionFormat(_later("mjcf", "read_mjcf"), roots=("mujoco",))
PYBULLET = RotorDialect(
    lambda model: bool(model.properties) and _is_pybullet(model),
    _later("pybullet", "read_pybullet"),
    "properties",
)
MUJOCO = RotorDialect(
    lambda model: bool(model.actuators),
    _later("mjcf_actuators", "read_mjcf_actuators"),
    "actuators",
)
GAZEBO = WorldFormat(_later("gazebo_world", "read_gazebo_world"), (".sdf", ".world"), "Gazebo")
