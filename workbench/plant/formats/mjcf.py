"""Read MJCF, the format of MuJoCo: the free body with its mass and inertia, and its actuators."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.colours import Colour
from workbench.plant.formats.mjcf_document import (
    Compiler,
    Defaults,
    elements,
    elements_of,
    is_true,
    pose_of,
    read_compiler,
    shortest_to,
    with_includes,
    without_replicates,
)
from workbench.plant.formats.mjcf_meshes import Meshes
from workbench.plant.formats.mjcf_motors import read_actuators
from workbench.plant.formats.mjcf_words import check_words
from workbench.plant.formats.solids import (
    Solid,
    shell_moments,
    surface,
    together,
    unit_moments,
    volume,
)
from workbench.plant.formats.values import listed, number, numbers, shortened, triple
from workbench.plant.formats.xml import Element, place
from workbench.plant.model import (
    Inertial,
    Joint,
    Link,
    LinkShape,
    Model,
    inertial_of,
    refuse_too_many,
)
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, Shape, Sphere

_SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3, "ellipsoid": 3}
_OF_TWO_POINTS = ("capsule", "cylinder", "box", "ellipsoid")
_DRAWN = 3
"""First group that is not drawn, as in MuJoCo's viewer and Drake's parser."""
_KINDS = {"hinge": "continuous", "slide": "prismatic", "ball": "ball"}
_NO_MASS = 1e-14
"""Mass of a geom that does not count [kg], as in MuJoCo."""


def read_mjcf(path: Path, root: Element, finder: PackageFinder, remarks: Remarks) -> Model:
    """Return the free body in an MJCF file as a model.

    Poses, masses, inertias and actuators are those of MuJoCo's compiler. The model frame is that
    of the free body; its pose in the file is not used, as a scenario defines it.

    Args:
        path: the file, for messages and relative paths.
        root: its root element.
        finder: of meshes.
        remarks: receives remarks on unused parts.

    Raises:
        WorkbenchError: naming file and element, for invalid content, and for any that may decide
            mass, inertia or thrust and is not read.
    """
    root = with_includes(path, root, finder)
    compiler = read_compiler(path, root)
    root, copies = without_replicates(root, compiler)
    defaults = Defaults(root)
    tops = [each for world in elements(root, "worldbody") for each in _bodies(world, "")]
    drone = _free_body(path, root, tops, defaults, remarks)
    check_words(path, root, drone[0], remarks)
    bodies, geoms = (sum(1 for _ in drone[0].iter(tag)) for tag in ("body", "geom"))
    refuse_too_many(path, bodies, geoms, 0)
    meshes = Meshes(path, root, compiler, defaults, finder)
    reader = _Reader(path, root, compiler, defaults, meshes, remarks)
    reader.add(drone[0], RigidTransform(), "", drone[1])
    links = reader.links
    refuse_too_many(path, 0, 0, sum(len(link.collisions) for link in links))
    if compiler.settotalmass > 0.0:
        others = _Reader(path, root, compiler, defaults, meshes, Remarks())
        for body, childclass in tops:
            others.add(body, RigidTransform(), "", childclass)
        links = _of_total_mass(path, links, others.links, compiler.settotalmass)
    return Model(
        source=path,
        name=root.get("model") or path.name.partition(".")[0],
        links=tuple(links),
        joints=tuple(reader.joints),
        frames=(),
        sensors=(),
        plugins=(),
        actuators=tuple(
            read_actuators(path, root, compiler, defaults, reader.sites, copies, remarks)
        ),
    )


def _of_total_mass(
    path: Path, links: list[Link], every: list[Link], settotalmass: float
) -> list[Link]:
    """Return links with masses and inertias scaled for a total mass of every link of the file."""
    total = sum(link.inertial.mass for link in every if link.inertial)
    if not total > 0.0:
        raise WorkbenchError(f"{path}: <compiler settotalmass>: no body has a mass: give one")
    scale = settotalmass / total
    scaled = []
    for link in links:
        inertial = link.inertial
        if inertial:
            inertial = inertial_of(scale * inertial.mass, inertial.X_LI, scale * inertial.matrix)
        scaled.append(replace(link, inertial=inertial))
    return scaled


_Top = tuple[Element, str]
"""A body of the world, and the default class around it."""


def _free_body(
    path: Path, root: Element, tops: list[_Top], defaults: Defaults, remarks: Remarks
) -> _Top:
    """Return the free body of the world, and add a remark on other bodies and geoms."""
    free = [top for top in tops if list(_free_joints(*top, defaults))]
    if not free:
        names = listed([body.get("name", "without a name") for body, _ in tops])
        raise WorkbenchError(
            f"{path}: no body in <worldbody> has a <freejoint/>, and a drone flies freely: add it "
            f"to one of {names}"
            if tops
            else f"{path}: there is no <body> in <worldbody>: add one"
        )
    if len(free) > 1:
        raise WorkbenchError(
            f"{path}: several bodies move freely: {listed([b.get('name', '') for b, _ in free])}: "
            "give a file with the drone alone"
        )
    geoms = len(root.findall("worldbody/geom"))
    others = [shortened(body.get("name", "")) for body, _ in tops if body is not free[0][0]]
    if others or geoms:
        parts = [f"bodies {listed(others)}"] if others else []
        parts += [f"{geoms} geoms"] if geoms else []
        text = f"'{shortened(free[0][0].get('name', ''))}' flies; left out are "
        remarks.add("ignored", path, "objects of the world", text + " and ".join(parts))
    for joint in _free_joints(*free[0], defaults):
        if joint.tag == "joint" and number(joint, "armature", "0") != 0.0:
            raise WorkbenchError(
                f"{place(joint)}: <joint armature='{shortened(joint.get('armature', ''))}'>: adds "
                "to mass and inertia of all of the drone: use a <freejoint>, which has none"
            )
    return free[0]


def _bodies(parent: Element, childclass: str) -> Iterator[_Top]:
    """Yield the bodies directly in a world or in its frames."""
    for child in elements(parent, "body", "frame"):
        if child.tag == "body":
            yield child, childclass
        else:
            yield from _bodies(child, child.get("childclass", childclass))


def _free_joints(body: Element, childclass: str, defaults: Defaults) -> Iterator[Element]:
    """Yield the free joints of a body, not of those in it, which may have none."""
    childclass = body.get("childclass", childclass)
    for child in elements(body, "freejoint", "joint", "frame"):
        if child.tag == "frame":
            yield from _free_joints(child, childclass, defaults)
        elif child.tag == "freejoint":
            yield child
        else:
            joint = defaults.applied(child, childclass)
            if joint.get("type") == "free":
                yield joint


Placed = tuple[Element, RigidTransform]
"""A part of a body, with the pose X_LF of the frame in its link that its pose is given in."""


@dataclass(frozen=True)
class _Geom:
    """A geom of a link.

    Attributes:
        name: of the geom.
        element: with its defaults.
        X_LG: its pose.
        shape: None for one that is not known.
        solid: its mass, None if it has none, or if that of its body is given.
    """

    name: str
    element: Element
    X_LG: RigidTransform
    shape: Shape | None
    solid: Solid | None


class _Reader:
    """Reads links, joints and sites of a body and its descendants.

    Args:
        path: of the file.
        root: of the document.
        compiler: its settings.
        defaults: its defaults.
        meshes: its meshes.
        remarks: receives remarks on unusable parts.
    """

    def __init__(
        self,
        path: Path,
        root: Element,
        compiler: Compiler,
        defaults: Defaults,
        meshes: Meshes,
        remarks: Remarks,
    ) -> None:
        self._path = path
        self._compiler = compiler
        self._defaults = defaults
        self._meshes = meshes
        self._remarks = remarks
        self._colours: dict[str, Colour] = {}
        self.sites: dict[str, tuple[str, RigidTransform]] = {}
        self.links: list[Link] = []
        self.joints: list[Joint] = []
        for asset in elements_of(root, "asset", "material"):
            if "rgba" in asset.attrib:
                self._colours[asset.get("name", "")] = _rgba(asset)

    def add(self, body: Element, X_ML: RigidTransform, parent: str, childclass: str) -> None:
        """Add a body.

        Args:
            body: its element.
            X_ML: its pose.
            parent: its parent link, "" for a body of the world.
            childclass: default class in its parent.
        """
        name = body.get("name") or f"body_{len(self.links)}"
        if any(link.name == name for link in self.links):
            raise WorkbenchError(
                f"{place(body)}: there are two bodies named '{shortened(name)}': rename one"
            )
        contents = list(self._contents(body, RigidTransform(), body.get("childclass", childclass)))

        def parts(tag: str) -> list[Placed]:
            return [(part, X_LF) for part, X_LF, _ in contents if part.tag == tag]

        for joint, _ in parts("freejoint") if parent else ():
            raise WorkbenchError(
                f"{place(joint)}: <freejoint> in a body of the drone: MuJoCo has free joints only "
                "directly in bodies of <worldbody>: leave it out"
            )
        given = parts("inertial")
        if len(given) > 1:
            raise WorkbenchError(f"{place(given[1][0])}: a second <inertial>: leave one")
        from_geoms = not given or self._compiler.inertiafromgeom == "true"
        if self._compiler.inertiafromgeom == "false":
            from_geoms = False
        geoms = [
            self._geom(f"'{shortened(name)}'", index, *geom, from_geoms)
            for index, geom in enumerate(parts("geom"))
        ]
        inertial = self._inertial(body, given, [geom.solid for geom in geoms if geom.solid])
        self.links.append(Link(name, X_ML, inertial, *self._shapes(geoms)))
        if parent:
            self.joints.append(self._joint(name, parent, X_ML, parts("joint")))
        for site, X_LF in parts("site"):
            self._add_site(name, site, X_LF)
        for child, X_LF, inherited in contents:
            if child.tag == "body":
                pose = pose_of(child, self._compiler)
                self.add(child, X_ML @ X_LF @ pose, name, inherited)

    def _contents(
        self, parent: Element, X_LF: RigidTransform, childclass: str
    ) -> Iterator[tuple[Element, RigidTransform, str]]:
        """Yield the parts of a body, also in frames, with defaults applied, see `Placed`.

        The last value is their default class.
        """
        for child in elements(parent):
            match child.tag:
                case "frame":
                    inside = X_LF @ pose_of(child, self._compiler)
                    yield from self._contents(child, inside, child.get("childclass", childclass))
                case "geom" | "joint" | "site":
                    yield self._defaults.applied(child, childclass), X_LF, childclass
                case _:
                    yield child, X_LF, childclass

    def _inertial(self, body: Element, given: list[Placed], solids: list[Solid]) -> Inertial | None:
        """Return mass and inertia of a body (mjCBody::Compile)."""
        compiler = self._compiler
        if solids:
            found = together(solids)
        elif given:
            found = self._given_inertial(*given[0])
        elif compiler.boundmass > 0.0:  # MuJoCo takes the pose of the body as that of its inertia
            found = Inertial(0.0, pose_of(body, compiler), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        else:
            return None
        return _bounded(found, compiler)

    def _given_inertial(self, element: Element, X_LF: RigidTransform) -> Inertial:
        X_LI = X_LF @ pose_of(element, self._compiler)
        mass = number(element, "mass")
        if "fullinertia" in element.attrib:
            values = numbers(element, "fullinertia", "")
            if len(values) != 6:
                raise WorkbenchError(
                    f"{place(element)}: <inertial fullinertia>: give it six numbers"
                )
            xx, yy, zz, xy, xz, yz = values
            return Inertial(mass, X_LI, (xx, yy, zz), (xy, xz, yz))
        moments = triple(element, "diaginertia", "0 0 0")
        return Inertial(mass, X_LI, moments, (0.0, 0.0, 0.0))

    def _joint(self, link: str, parent: str, X_ML: RigidTransform, joints: list[Placed]) -> Joint:
        """Return the first joint of a body, or a fixed joint if it has none."""
        if not joints:
            return Joint(f"{link}_weld", "fixed", parent, link, X_ML, (0.0, 0.0, 1.0))
        for other, _ in joints[1:]:
            text = f"a further joint of '{shortened(link)}'; left out"
            what = f"joint '{shortened(other.get('name', ''))}'"
            self._remarks.add("ignored", self._path, what, text)
        element, X_LF = joints[0]
        axis = X_LF.rotation().multiply(np.array(triple(element, "axis", "0 0 1")))
        length = float(np.linalg.norm(axis))
        if length < 1e-9:
            raise WorkbenchError(f"{place(element)}: <joint axis> is 0 0 0: give it a direction")
        x, y, z = (float(value) for value in axis / length)
        position = np.array(triple(element, "pos", "0 0 0"))
        X_LJ = RigidTransform(RotationMatrix(), X_LF.multiply(position))
        kind = element.get("type", "hinge")
        if kind not in _KINDS:
            raise WorkbenchError(
                f"{place(element)}: <joint type='{shortened(kind)}'> of a body in the drone: use "
                f"{', '.join(_KINDS)}, or no joint"
            )
        name = element.get("name") or f"{link}_joint"
        return Joint(name, _KINDS[kind], parent, link, X_ML @ X_LJ, (x, y, z))

    def _add_site(self, link: str, site: Element, X_LF: RigidTransform) -> None:
        name = site.get("name", "")
        if name and name in self.sites:
            raise WorkbenchError(
                f"{place(site)}: there are two sites named '{shortened(name)}': rename one"
            )
        pose = pose_of(site, self._compiler)
        if "fromto" in site.attrib:
            pose, _ = _between(site, site.get("type", "sphere"))
        self.sites[name] = (link, X_LF @ pose)

    def _shapes(self, geoms: list[_Geom]) -> tuple[tuple[LinkShape, ...], tuple[LinkShape, ...]]:
        """Return the visuals and the collisions of the geoms of a link."""
        visuals, collisions = [], []
        for geom in geoms:
            if geom.shape is None:
                continue
            rgba = self._colour(geom.element)
            if number(geom.element, "group", "0") < _DRAWN and (not rgba or rgba[3] > 0.0):
                visuals.append(LinkShape(geom.name, geom.X_LG, geom.shape, rgba))
            if any(number(geom.element, word, "1") for word in ("contype", "conaffinity")):
                collisions.append(LinkShape(geom.name, geom.X_LG, geom.shape))
        return tuple(visuals), tuple(collisions)

    def _geom(
        self, link: str, index: int, element: Element, X_LF: RigidTransform, from_geoms: bool
    ) -> _Geom:
        """Return a geom as a shape and, if the mass of its link is that of its geoms, a solid."""
        name = element.get("name") or f"geom_{index}"
        what = f"geom '{shortened(name)}' of {link}"
        kind = element.get("type", "sphere")
        first, last = self._compiler.inertiagrouprange
        weighs = from_geoms and first <= number(element, "group", "0") <= last and _weighs(element)
        X_FG = pose_of(element, self._compiler)
        if kind == "mesh":
            X_GS, shape = self._meshes.shape(element)
            solid = self._mesh_solid(element, X_LF @ X_FG) if weighs else None
            return _Geom(name, element, X_LF @ X_FG @ X_GS, shape, solid)
        if kind not in _SIZES:
            if weighs and kind != "plane":
                raise _fault(element, f"the mass of a {shortened(kind)} is not known: set it to 0")
            self._remarks.add("ignored", self._path, what, f"a {shortened(kind)}; left out")
            return _Geom(name, element, X_LF @ X_FG, None, None)
        if "mesh" in element.attrib:
            if not weighs:  # reading the mesh would take long, and it may be missing
                text = f"a {kind} fitted to a mesh; left out"
                self._remarks.add("ignored", self._path, what, text)
                return _Geom(name, element, X_LF @ X_FG, None, None)
            X_GS, shape = self._meshes.fitted(element, kind)
            X_FG = X_FG @ X_GS
        else:
            X_FG, shape = self._sized(element, kind, X_FG)
        X_LG = X_LF @ X_FG
        return _Geom(name, element, X_LG, shape, _solid(element, X_LG, shape) if weighs else None)

    def _mesh_solid(self, element: Element, X_LG: RigidTransform) -> Solid | None:
        """Return a mesh as a solid."""
        if is_true(element, "shellinertia", "false"):
            raise _fault(element, "the shell of a mesh is its asset's: give <mesh> inertia='shell'")
        mesh = self._meshes.inertia(element)
        X_LS = X_LG @ RigidTransform(RotationMatrix(mesh.R), mesh.p)
        mass = _mass(element, mesh.size)
        return Solid(mass, X_LS, mesh.moments) if mass > _NO_MASS else None

    def _sized(
        self, element: Element, kind: str, pose: RigidTransform
    ) -> tuple[RigidTransform, Shape]:
        """Return pose and shape of a geom given by its sizes, or by its ends."""
        size = list(numbers(element, "size", ""))
        if "fromto" in element.attrib:
            pose, length = _between(element, kind)
            size = [*size[:1], *([size[0]] if _SIZES[kind] == 3 and size else []), length / 2.0]
        if len(size) < _SIZES[kind] or min(size[: _SIZES[kind]]) <= 0.0:
            raise _fault(element, f"a {kind} has {_SIZES[kind]} positive sizes")
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

    def _colour(self, element: Element) -> Colour | None:
        if "rgba" in element.attrib:
            return _rgba(element)
        return self._colours.get(element.get("material", ""))


def _bounded(inertial: Inertial, compiler: Compiler) -> Inertial:
    """Return mass and inertia within the bounds that the compiler sets."""
    if not (compiler.boundmass > 0.0 or compiler.boundinertia > 0.0 or compiler.balanceinertia):
        return inertial
    moments, axes = np.linalg.eigh(inertial.matrix)
    moments = np.maximum(moments, compiler.boundinertia)
    if compiler.balanceinertia and 2.0 * moments.max() > moments.sum():
        moments = np.full(3, moments.mean())
    mass = max(inertial.mass, compiler.boundmass)
    return inertial_of(mass, inertial.X_LI, axes @ np.diag(moments) @ axes.T)


def _weighs(element: Element) -> bool:
    """Return whether a geom has a mass by its own words."""
    mass = number(element, "mass") if "mass" in element.attrib else None
    density = number(element, "density", "1000")
    if (mass is not None and mass < 0.0) or density < 0.0:
        raise _fault(element, "give it a mass or density of 0 or more")
    return density > 0.0 if mass is None else mass > 0.0


def _mass(element: Element, size: float) -> float:
    """Return the mass of a geom with a volume [m³], or a surface [m²] for a shell."""
    if "mass" in element.attrib:
        return number(element, "mass")
    return number(element, "density", "1000") * size


def _solid(element: Element, X_LG: RigidTransform, shape: Shape) -> Solid | None:
    """Return a geom as a solid, or as a shell."""
    shell = is_true(element, "shellinertia", "false")
    mass = _mass(element, surface(shape) if shell else volume(shape))
    if mass <= _NO_MASS:
        return None
    return Solid(mass, X_LG, shell_moments(shape) if shell else unit_moments(shape))


def _between(element: Element, kind: str) -> tuple[RigidTransform, float]:
    """Return pose and length of what is given by two points; its z axis is from the second."""
    ends = numbers(element, "fromto", "")
    if kind not in _OF_TWO_POINTS:
        raise _fault(element, f"fromto is for a {', a '.join(_OF_TWO_POINTS)}: give it a type")
    if any(triple(element, "pos", "0 0 0")):
        raise _fault(element, "it has pos and fromto: leave one")
    if len(ends) != 6 or ends[:3] == ends[3:]:
        raise _fault(element, "fromto is two points apart: give it six numbers")
    way = np.array(ends[:3]) - np.array(ends[3:])
    length = float(np.linalg.norm(way))
    middle = (np.array(ends[:3]) + np.array(ends[3:])) / 2.0
    return RigidTransform(shortest_to(way / length), middle), length


def _rgba(element: Element) -> Colour:
    values = numbers(element, "rgba", "")
    if len(values) != 4:
        raise WorkbenchError(
            f"{place(element)}: <{element.tag} rgba='{shortened(element.get('rgba', ''))}'>: "
            "give it four numbers"
        )
    r, g, b, a = (min(1.0, max(0.0, value)) for value in values)
    return (r, g, b, a)


def _fault(element: Element, text: str) -> WorkbenchError:
    return WorkbenchError(f"{place(element)}: <{element.tag}>: {text}")
