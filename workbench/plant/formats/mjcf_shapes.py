"""Geoms of MJCF: what is drawn, what touches, and what has mass."""

from collections.abc import Iterable, Iterator
from pathlib import Path, PurePosixPath

import numpy as np
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.colours import Colour
from workbench.plant.formats.mjcf_words import Compiler, Defaults, pose_of, shortest_to
from workbench.plant.formats.solids import Solid, volume
from workbench.plant.formats.values import number, numbers, shortened, triple
from workbench.plant.formats.xml import Element, place
from workbench.plant.model import Collision, Visual
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, Mesh, Shape, Sphere

_SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3, "ellipsoid": 3}
_DRAWN = 3
"""Groups from this on are not drawn, as in MuJoCo's viewer and in Drake's parser."""


Placed = Iterable[tuple[Element, RigidTransform]]
"""Geoms, each with the frame in its link that its pose is given in."""


class GeomReader:
    """Reads geoms with the assets of their file.

    Args:
        path: of the file.
        root: of the document.
        compiler: how it is meant.
        defaults: of its classes.
        finder: of meshes.
        remarks: where to note what cannot be used.
    """

    def __init__(
        self,
        path: Path,
        root: Element,
        compiler: Compiler,
        defaults: Defaults,
        finder: PackageFinder,
        remarks: Remarks,
    ) -> None:
        self._path = path
        self._compiler = compiler
        self._remarks = remarks
        self._meshes: dict[str, Mesh] = {}
        self._colours: dict[str, Colour] = {}
        for asset in root.iterfind("asset/mesh"):
            assert isinstance(asset, Element)
            element = defaults.applied(asset, "")
            file = element.get("file", "")
            name = element.get("name") or PurePosixPath(file).stem
            found = finder.resolve(str(PurePosixPath(compiler.meshdir) / file), path)
            scale = triple(path, element, "scale", "1 1 1")
            self._meshes[name] = Mesh(file, found if file else None, scale)
        for asset in root.iterfind("asset/material"):
            assert isinstance(asset, Element)
            if "rgba" in asset.attrib:
                self._colours[asset.get("name", "")] = _rgba(path, asset)

    def shapes(self, link: str, placed: Placed) -> tuple[tuple[Visual, ...], tuple[Collision, ...]]:
        """Return what is drawn of a link's geoms, and what touches.

        Raises:
            WorkbenchError: for sizes and colours that cannot be.
        """
        visuals, collisions = [], []
        for name, element, X_LG, shape in self._geoms(link, placed):
            rgba = self._colour(element)
            if number(self._path, element, "group", "0") < _DRAWN and (not rgba or rgba[3] > 0.0):
                visuals.append(Visual(name, X_LG, shape, rgba))
            if any(number(self._path, element, word, "1") for word in ("contype", "conaffinity")):
                collisions.append(Collision(name, X_LG, shape))
        return tuple(visuals), tuple(collisions)

    def solids(self, link: str, placed: Placed) -> list[Solid]:
        """Return a link's geoms as solids with mass.

        Raises:
            WorkbenchError: for sizes and masses that cannot be.
        """
        return [
            solid
            for name, element, X_LG, shape in self._geoms(link, placed)
            for solid in self._solid(element, X_LG, shape, f"geom '{shortened(name)}'")
        ]

    def _geoms(
        self, link: str, placed: Placed
    ) -> Iterator[tuple[str, Element, RigidTransform, Shape]]:
        """Yield name, element, pose and shape of the geoms that have a shape."""
        for index, (element, X_LF) in enumerate(placed):
            name = element.get("name") or f"geom_{index}"
            X_FG, shape = self._shape(element, f"geom '{shortened(name)}' of '{shortened(link)}'")
            if shape is not None:
                yield name, element, X_LF @ X_FG, shape

    def _shape(self, element: Element, what: str) -> tuple[RigidTransform, Shape | None]:
        """Return a geom's pose and shape, None for one that is no shape of a drone."""
        kind = element.get("type", "sphere")
        pose = pose_of(self._path, element, self._compiler)
        if "mesh" in element.attrib:
            name = element.get("mesh", "")
            if name not in self._meshes:
                raise self._fault(element, f"there is no mesh '{shortened(name)}' among its assets")
            if kind == "mesh" or element.get("type") is None:
                return pose, self._meshes[name]
        if kind not in _SIZES:
            self._remarks.add("ignored", self._path, what, f"a {shortened(kind)}; left out")
            return pose, None
        if "mesh" in element.attrib:
            text = f"a {kind} fitted to a mesh; left out"
            self._remarks.add("ignored", self._path, what, text)
            return pose, None
        return self._sized(element, kind, pose)

    def _sized(
        self, element: Element, kind: str, pose: RigidTransform
    ) -> tuple[RigidTransform, Shape]:
        """Return pose and shape of a geom that is given by sizes, or from one end to another."""
        size = list(numbers(self._path, element, "size", ""))
        if "fromto" in element.attrib and kind != "sphere":
            ends = numbers(self._path, element, "fromto", "")
            if len(ends) != 6 or ends[:3] == ends[3:]:
                raise self._fault(element, "fromto is two points apart: give it six numbers")
            way = np.array(ends[3:]) - np.array(ends[:3])
            length = float(np.linalg.norm(way))
            middle = (np.array(ends[:3]) + np.array(ends[3:])) / 2.0
            pose = RigidTransform(shortest_to(way / length), middle)
            size = [*size[:1], *([size[0]] if _SIZES[kind] == 3 and size else []), length / 2.0]
        if len(size) < _SIZES[kind] or min(size[: _SIZES[kind]]) <= 0.0:
            raise self._fault(element, f"a {kind} has {_SIZES[kind]} positive sizes")
        match kind:
            case "sphere":
                return pose, Sphere(size[0])
            case "capsule":
                return pose, Capsule(size[0], 2.0 * size[1])
            case "cylinder":
                return pose, Cylinder(size[0], 2.0 * size[1])
            case "box":
                return pose, Box((2.0 * size[0], 2.0 * size[1], 2.0 * size[2]))
        return pose, Ellipsoid((size[0], size[1], size[2]))

    def _solid(
        self, element: Element, X_LG: RigidTransform, shape: Shape, what: str
    ) -> list[Solid]:
        """Return a geom as a solid with mass, none for one without."""
        given = number(self._path, element, "mass") if "mass" in element.attrib else None
        density = number(self._path, element, "density", "1000")
        if given is not None and given < 0.0 or density < 0.0:
            raise self._fault(element, "give it a mass or density of 0 or more")
        if given == 0.0 or (given is None and density == 0.0):
            return []
        if isinstance(shape, Mesh):
            text = "its mass is not made from its mesh; left out: give its body an <inertial>"
            if given is not None:
                text = "the mass of its mesh is taken as a point at the geom's origin"
            self._remarks.add("assumed", self._path, what, text)
            return [] if given is None else [Solid(given, X_LG, None)]
        return [Solid(density * volume(shape) if given is None else given, X_LG, shape)]

    def _colour(self, element: Element) -> Colour | None:
        if "rgba" in element.attrib:
            return _rgba(self._path, element)
        return self._colours.get(element.get("material", ""))

    def _fault(self, element: Element, text: str) -> WorkbenchError:
        return WorkbenchError(f"{place(self._path, element)}: <geom>: {text}")


def _rgba(path: Path, element: Element) -> Colour:
    values = numbers(path, element, "rgba", "")
    if len(values) != 4:
        raise WorkbenchError(
            f"{place(path, element)}: <{element.tag} rgba='{shortened(element.get('rgba', ''))}'>: "
            "give it four numbers"
        )
    r, g, b, a = (min(1.0, max(0.0, value)) for value in values)
    return (r, g, b, a)
