"""A model whose meshes Drake draws and touches: converted, or replaced by something simple."""

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path

from workbench.errors import WorkbenchError
from workbench.plant.formats.values import shortened
from workbench.plant.meshes.convert import MeshUse, convert
from workbench.plant.model import Collision, Link, Model, Visual
from workbench.plant.remarks import Remarks
from workbench.plant.rotors import Rotor
from workbench.plant.shapes import Mesh
from workbench.plant.stand_ins import stand_ins, with_bumper, without_missing_meshes

Files = Mapping[MeshUse, Path | WorkbenchError]
"""The converted file of each use, or why there is none."""


def with_drawable_meshes(
    model: Model, base_link: str, rotors: Sequence[Rotor], remarks: Remarks
) -> Model:
    """Return a model with meshes as Drake takes them, and something to touch the ground with.

    Args:
        model: as read.
        base_link: gets a box to stand on where no link touches anything.
        rotors: for the size of stand-ins.
        remarks: where to note meshes that were not found or could not be read.
    """
    files = convert(use for link in model.links for use in _uses(link))
    links = tuple(_drawable(model, link, files, rotors, remarks) for link in model.links)
    if not any(link.collisions for link in links):
        text = "no link has a collision shape; a box as wide as the rotors are apart stands in"
        remarks.add("assumed", model.source, f"collision of link '{shortened(base_link)}'", text)
        links = tuple(
            with_bumper(link, rotors) if link.name == base_link else link for link in links
        )
    return dataclasses.replace(model, links=links)


def _uses(link: Link) -> list[MeshUse]:
    """Return every use that a link makes of a mesh that was found."""
    visuals = [
        MeshUse(visual.shape, "visual", visual.rgba)
        for visual in link.visuals
        if isinstance(visual.shape, Mesh) and visual.shape.path
    ]
    collisions = [
        MeshUse(collision.shape, "collision")
        for collision in link.collisions
        if isinstance(collision.shape, Mesh) and collision.shape.path
    ]
    return visuals + collisions


def _drawable(
    model: Model, link: Link, files: Files, rotors: Sequence[Rotor], remarks: Remarks
) -> Link:
    """Return a link with its meshes converted, hulls for those that touch, and stand-ins."""
    visuals = [_converted(model, link, visual, files, remarks) for visual in link.visuals]
    if any(isinstance(visual.shape, Mesh) and visual.shape.path is None for visual in visuals):
        visuals = [*without_missing_meshes(visuals, stand_ins(link, rotors))]
    collisions = [_hull(model, link, collision, files, remarks) for collision in link.collisions]
    return dataclasses.replace(
        link,
        visuals=tuple(visuals),
        collisions=tuple(collision for collision in collisions if collision),
    )


def _converted(model: Model, link: Link, visual: Visual, files: Files, remarks: Remarks) -> Visual:
    """Return a visual with its mesh as Drake draws it, or with none where that cannot be."""
    mesh = visual.shape
    if not isinstance(mesh, Mesh):
        return visual
    element = f"visual '{shortened(visual.name)}' of link '{shortened(link.name)}'"
    if mesh.path is None:
        uri = shortened(mesh.uri) or "without a name"
        text = f"the mesh {uri} is not found; something simple is drawn"
        remarks.add("missing", model.source, element, text)
        return visual
    file = files[MeshUse(mesh, "visual", visual.rgba)]
    if isinstance(file, WorkbenchError):
        remarks.add("ignored", model.source, element, f"{file}; something simple is drawn")
        return dataclasses.replace(visual, shape=dataclasses.replace(mesh, path=None))
    return dataclasses.replace(visual, shape=Mesh(mesh.uri, file), rgba=None)


def _hull(
    model: Model, link: Link, collision: Collision, files: Files, remarks: Remarks
) -> Collision | None:
    """Return a collision with its mesh's convex hull, None where there is no mesh to be had."""
    mesh = collision.shape
    if not isinstance(mesh, Mesh):
        return collision
    element = f"collision '{shortened(collision.name)}' of link '{shortened(link.name)}'"
    if mesh.path is None:
        text = f"the mesh {shortened(mesh.uri) or 'without a name'} is not found; left out"
        remarks.add("missing", model.source, element, text)
        return None
    file = files[MeshUse(mesh, "collision")]
    if isinstance(file, WorkbenchError):
        remarks.add("ignored", model.source, element, f"{file}; left out")
        return None
    return dataclasses.replace(collision, shape=Mesh(mesh.uri, file))
