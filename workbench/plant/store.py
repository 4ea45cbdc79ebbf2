"""A description to keep: one URDF that Drake reads, with its meshes beside it."""

import dataclasses
import re
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import TypeVar
from xml.etree import ElementTree as ET

from workbench.plant.description import Description
from workbench.plant.formats.gazebo_writer import (
    add_battery,
    add_rotors,
    add_sensors,
    turning_joints,
)
from workbench.plant.formats.urdf_writer import write_urdf
from workbench.plant.model import Collision, Link, Visual
from workbench.plant.shapes import Mesh

T = TypeVar("T", Visual, Collision)


def stored_files(description: Description) -> Iterator[tuple[PurePosixPath, bytes]]:
    """Yield the files of a description, by path within a folder of their own, URDF first.

    Rotors turn on continuous joints where they have mass, and stand as motor-model plugins;
    reading the URDF again gives the same vehicle.
    """
    meshes: dict[Path, PurePosixPath] = {}
    model = dataclasses.replace(
        description.model,
        links=tuple(_with_own_meshes(link, meshes) for link in description.model.links),
    )
    turning = turning_joints(model, description.rotors)
    robot = write_urdf(model, turning)
    robot.set("xmlns:drake", "http://drake.mit.edu")
    add_rotors(robot, model, description.base_link, description.rotors, turning)
    if description.battery:
        add_battery(robot, description.battery)
    add_sensors(robot, model.sensors)
    ET.indent(robot)
    text = f'<?xml version="1.0"?>\n{ET.tostring(robot, encoding="unicode")}\n'
    yield PurePosixPath(f"{safe_name(description.name)}.urdf"), text.encode()
    for path, stored in meshes.items():
        yield stored, path.read_bytes()


def safe_name(name: str) -> str:
    """Return a name that is one plain file name, whatever a description calls itself."""
    return re.sub(r"[^A-Za-z0-9._-]+", "_", name)[:80].strip("._") or "model"


def _with_own_meshes(link: Link, meshes: dict[Path, PurePosixPath]) -> Link:
    """Return a link whose meshes lie beside the URDF, and note which those are."""

    def moved(shape: T) -> T:
        mesh = shape.shape
        if not isinstance(mesh, Mesh) or mesh.path is None:
            return shape
        stored = meshes.setdefault(mesh.path, PurePosixPath("meshes") / safe_name(mesh.path.name))
        return dataclasses.replace(shape, shape=Mesh(str(stored), Path(stored)))

    return dataclasses.replace(
        link,
        visuals=tuple(map(moved, link.visuals)),
        collisions=tuple(map(moved, link.collisions)),
    )
