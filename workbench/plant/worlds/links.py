"""Links of models as obstacles."""

from collections.abc import Sequence
from pathlib import Path

from pydrake.geometry import GeometryInstance

from workbench.plant.drawable import with_converted_meshes
from workbench.plant.model import Collision, Link, Model, Visual
from workbench.plant.remarks import Remarks
from workbench.plant.shapes import Mesh
from workbench.plant.worlds.geometry import collision, drawn_if_none, visual
from workbench.plant.worlds.world import Obstacle


def obstacles_of(source: Path, links: Sequence[Link], remarks: Remarks) -> tuple[Obstacle, ...]:
    """Return an obstacle for each link that has a shape, with its meshes as Drake takes them.

    Args:
        source: the world's file.
        links: with poses in the world in the place of the model's.
        remarks: where to note meshes that were not found, could not be read, or touch as hulls.
    """
    model = Model(source, source.stem, tuple(links), (), (), (), ())
    converted = with_converted_meshes(model, remarks, "left out")
    hulls = sum(isinstance(each.shape, Mesh) for link in converted for each in link.collisions)
    if hulls:
        text = f"{hulls} of them touch as their convex hulls"
        remarks.add("assumed", source, "meshes of collisions", text)
    obstacles = [_obstacle(link) for link in converted]
    return tuple(obstacle for obstacle in obstacles if obstacle.visuals)


def _obstacle(link: Link) -> Obstacle:
    collisions = [
        collision(name, each.X_LC, each.shape)
        for name, each in zip(_names(link, link.collisions), link.collisions, strict=True)
    ]
    visuals: list[GeometryInstance] = [
        visual(name, each.X_LV, each.shape, each.rgba)
        for name, each in zip(_names(link, link.visuals), link.visuals, strict=True)
        if not (isinstance(each.shape, Mesh) and each.shape.path is None)
    ]
    return Obstacle(link.name, link.X_ML, tuple(collisions), drawn_if_none(visuals, collisions))


def _names(link: Link, shapes: Sequence[Visual | Collision]) -> list[str]:
    """Return names of a link's shapes, with numbers behind if one came twice."""
    names = [shape.name.replace("::", "_") for shape in shapes]
    if len(set(names)) < len(names):
        names = [f"{name}_{index}" for index, name in enumerate(names)]
    return [f"{link.name}::{name}" for name in names]
