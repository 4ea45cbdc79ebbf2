"""A model whose meshes Drake draws and touches: converted, or replaced by something simple."""

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path

from workbench.common.errors import WorkbenchError
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
    links = tuple(
        _with_stand_ins(link, rotors)
        for link in with_converted_meshes(model, remarks, "something simple is drawn")
    )
    if not any(link.collisions for link in links):
        text = "no link has a collision shape; a box as wide as the rotors are apart stands in"
        remarks.add("assumed", model.source, f"collision of link '{shortened(base_link)}'", text)
        links = tuple(
            with_bumper(link, rotors) if link.name == base_link else link for link in links
        )
    return dataclasses.replace(model, links=links)


def with_converted_meshes(model: Model, remarks: Remarks, fate: str) -> tuple[Link, ...]:
    """Return a model's links with meshes as Drake takes them, hulls for those that touch.

    What touches and has no mesh to be had is left out; a visual without one keeps a mesh without
    a path.

    Args:
        model: as read.
        remarks: where to note meshes that were not found or could not be read.
        fate: a clause on what becomes of such visuals.
    """
    files = convert(use for link in model.links for use in _uses(link))
    return tuple(_drawable(model, link, files, remarks, fate) for link in model.links)


def _with_stand_ins(link: Link, rotors: Sequence[Rotor]) -> Link:
    """Return a link with something simple in the place of meshes that it is drawn by and lacks."""
    if not any(isinstance(each.shape, Mesh) and each.shape.path is None for each in link.visuals):
        return link
    visuals = without_missing_meshes(link.visuals, stand_ins(link, rotors))
    return dataclasses.replace(link, visuals=visuals)


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


def _drawable(model: Model, link: Link, files: Files, remarks: Remarks, fate: str) -> Link:
    """Return a link with its meshes converted, and hulls for those that touch."""
    visuals = [_converted(model, link, visual, files, remarks, fate) for visual in link.visuals]
    collisions = [_hull(model, link, collision, files, remarks) for collision in link.collisions]
    return dataclasses.replace(
        link,
        visuals=tuple(visuals),
        collisions=tuple(collision for collision in collisions if collision),
    )


def _converted(
    model: Model, link: Link, visual: Visual, files: Files, remarks: Remarks, fate: str
) -> Visual:
    """Return a visual with its mesh as Drake draws it, or with none where that cannot be."""
    mesh = visual.shape
    if not isinstance(mesh, Mesh):
        return visual
    element = f"visual '{shortened(visual.name)}' of link '{shortened(link.name)}'"
    if mesh.path is None:
        uri = shortened(mesh.uri) or "without a name"
        text = f"the mesh {uri} is not found; {fate}"
        remarks.add("missing", model.source, element, text)
        return visual
    file = files[MeshUse(mesh, "visual", visual.rgba)]
    if isinstance(file, WorkbenchError):
        remarks.add("ignored", model.source, element, f"{file}; {fate}")
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
