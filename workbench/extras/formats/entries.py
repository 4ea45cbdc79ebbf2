"""What this package adds to the workbench, named by the entry points of pyproject.toml.

The readers are imported when a file is read in their format: they take a tenth of Drake's time.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.extras.formats.model_folder import FOLDER_MARK, file_in_model_folder
from workbench.plant.readers import DescriptionFormat, RotorDialect, WorldFormat

if TYPE_CHECKING:
    from workbench.plant.formats.xml import Element
    from workbench.plant.model import Model
    from workbench.plant.packages import PackageFinder
    from workbench.plant.remarks import Remarks
    from workbench.plant.rotors import Rotor
    from workbench.plant.worlds.world import World


def _read_sdf(
    path: Path, root: "Element | None", finder: "PackageFinder", remarks: "Remarks"
) -> "Model":
    from workbench.extras.formats.sdf import read_sdf

    return read_sdf(path, finder, remarks, root)


def _read_mjcf(
    path: Path, root: "Element | None", finder: "PackageFinder", remarks: "Remarks"
) -> "Model":
    from workbench.extras.formats.mjcf import read_mjcf

    assert root is not None  # no suffix says that a file is MJCF
    return read_mjcf(path, root, finder, remarks)


def _declares_actuators(model: "Model") -> bool:
    return bool(model.actuators)


def _read_actuators(model: "Model", base_link: str, remarks: "Remarks") -> "tuple[Rotor, ...]":
    from workbench.extras.formats.mjcf_actuators import read_mjcf_actuators

    return read_mjcf_actuators(model, base_link, remarks)


def _declares_properties(model: "Model") -> bool:
    if not model.properties:
        return False
    from workbench.extras.formats.pybullet import is_pybullet

    return is_pybullet(model)


def _read_properties(model: "Model", base_link: str, remarks: "Remarks") -> "tuple[Rotor, ...]":
    from workbench.extras.formats.pybullet import read_pybullet

    return read_pybullet(model, base_link, remarks)


def _read_gazebo_world(path: Path, packages: Mapping[str, Path | str]) -> "World":
    from workbench.extras.formats.gazebo_world import read_gazebo_world

    return read_gazebo_world(path, packages)


SDF = DescriptionFormat(
    _read_sdf,
    roots=("sdf",),
    suffixes=(".sdf",),
    find_in_folder=file_in_model_folder,
    folder_mark=FOLDER_MARK,
)
MJCF = DescriptionFormat(_read_mjcf, roots=("mujoco",))
PYBULLET = RotorDialect(_declares_properties, _read_properties, "properties")
MUJOCO = RotorDialect(_declares_actuators, _read_actuators, "actuators")
GAZEBO = WorldFormat(_read_gazebo_world, (".sdf", ".world"), "Gazebo")
