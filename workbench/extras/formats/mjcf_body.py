"""A body of MJCF with its descendants, as links, joints and sites."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.common.vectors import float_triple
from workbench.extras.formats.mjcf_compiler import Compiler
from workbench.extras.formats.mjcf_document import MjcfDocument
from workbench.extras.formats.mjcf_elements import (
    elements,
    elements_of,
    is_true_attribute,
)
from workbench.extras.formats.mjcf_geom import (
    MIN_GEOM_MASS_KG,
    geom_mass,
    geom_solid,
    has_own_mass,
    mjcf_error,
    mjcf_rgba,
    pose_from_two_points,
)
from workbench.extras.formats.mjcf_limits import joint_range, stated_limits
from workbench.extras.formats.mjcf_meshes import Meshes
from workbench.extras.formats.mjcf_pose import pose_of
from workbench.extras.formats.solids import solid_inertial
from workbench.plant.formats.colours import Colour
from workbench.plant.formats.joint_limits import has_range
from workbench.plant.formats.values import (
    attribute_number,
    attribute_numbers,
    attribute_triple,
    shortened_text,
)
from workbench.plant.formats.xml import Element, element_location
from workbench.plant.gathered import whole_inertial
from workbench.plant.model import Freedom, Inertial, Joint, Link, LinkShape, inertial_of
from workbench.plant.sensors import free_name
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, GeometryShape, Sphere

_GEOM_SIZE_COUNTS = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3, "ellipsoid": 3}
_FIRST_HIDDEN_GROUP = 3
"""First group that is not drawn, as in MuJoCo's viewer and Drake's parser."""
_KIND_BY_MJCF_JOINT = {"hinge": "continuous", "slide": "prismatic", "ball": "ball"}
PlacedElement = tuple[Element, RigidTransform]
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
    shape: GeometryShape | None
    solid: Inertial | None


class MjcfBodyReader:
    """Reads links, joints and sites of a body and its descendants.

    Args:
        document: with the body.
        meshes: its meshes.
    """

    def __init__(self, document: MjcfDocument, meshes: Meshes) -> None:
        self._path, self._remarks = document.path, document.remarks
        self._compiler, self._defaults = document.compiler, document.defaults
        self._meshes, root = meshes, document.root
        self._colours: dict[str, Colour] = {}
        self.sites: dict[str, tuple[str, RigidTransform]] = {}
        self.links: list[Link] = []
        self.joints: list[Joint] = []
        self.references: dict[str, float] = {}  # positions of joints in the file, where ours is 0
        self._joint_names = {each.get("name", "") for each in root.iter("joint")}
        for asset in elements_of(root, "asset", "material"):
            if "rgba" in asset.attrib:
                self._colours[asset.get("name", "")] = mjcf_rgba(asset)

    def new_joint_name(self, usual: str) -> str:
        """Return a name that no other joint has, and keep it: the usual one if possible."""
        name = free_name(self._joint_names, usual)
        self._joint_names.add(name)
        return name

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
                f"{element_location(body)}: there are two bodies named '{shortened_text(name)}': "
                "rename one"
            )
        contents = list(self._contents(body, RigidTransform(), body.get("childclass", childclass)))

        def parts(tag: str) -> list[PlacedElement]:
            return [(part, X_LF) for part, X_LF, _ in contents if part.tag == tag]

        for joint, _ in parts("freejoint") if parent else ():
            raise WorkbenchError(
                f"{element_location(joint)}: <freejoint> in a body of the drone: MuJoCo has free "
                "joints only directly in bodies of <worldbody>: leave it out"
            )
        given = parts("inertial")
        if len(given) > 1:
            raise WorkbenchError(f"{element_location(given[1][0])}: a second <inertial>: leave one")
        from_geoms = not given or self._compiler.inertiafromgeom == "true"
        if self._compiler.inertiafromgeom == "false":
            from_geoms = False
        geoms = [
            self._geom(f"'{shortened_text(name)}'", index, *geom, from_geoms)
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
        """Yield the parts of a body, also in frames, with defaults applied, see `PlacedElement`.

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

    def _inertial(
        self, body: Element, given: list[PlacedElement], solids: list[Inertial]
    ) -> Inertial | None:
        """Return mass and inertia of a body (mjCBody::Compile)."""
        compiler = self._compiler
        whole = whole_inertial([(RigidTransform(), solid) for solid in solids])
        if whole:
            found = whole
        elif given:
            found = self._given_inertial(*given[0])
        elif compiler.boundmass > 0.0:  # MuJoCo takes the pose of the body as that of its inertia
            found = Inertial(0.0, pose_of(body, compiler), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        else:
            return None
        return _bounded(found, compiler)

    def _given_inertial(self, element: Element, X_LF: RigidTransform) -> Inertial:
        X_LI = X_LF @ pose_of(element, self._compiler)
        mass = attribute_number(element, "mass")
        if "fullinertia" in element.attrib:
            values = attribute_numbers(element, "fullinertia", "")
            if len(values) != 6:
                raise WorkbenchError(
                    f"{element_location(element)}: <inertial fullinertia>: give it six numbers"
                )
            xx, yy, zz, xy, xz, yz = values
            return Inertial(mass, X_LI, (xx, yy, zz), (xy, xz, yz))
        moments = attribute_triple(element, "diaginertia", "0 0 0")
        return Inertial(mass, X_LI, moments, (0.0, 0.0, 0.0))

    def _joint(
        self, link: str, parent: str, X_ML: RigidTransform, joints: list[PlacedElement]
    ) -> Joint:
        """Return the joints of a body as one, or a fixed joint if it has none."""
        if not joints:
            name = self.new_joint_name(f"{link}_weld")
            return Joint(name, "fixed", parent, link, X_ML, (0.0, 0.0, 1.0))
        first = X_ML @ self._anchor(*joints[0])
        freedoms = [self._freedom(link, first, X_ML, *each) for each in joints]
        kinds = [element.get("type", "hinge") for element, _ in joints]
        kind = _KIND_BY_MJCF_JOINT[kinds[0]] if len(joints) == 1 else " + ".join(kinds)
        if kind == "continuous" and math.isfinite(freedoms[0].lower):
            kind = "revolute"
        return Joint(
            freedoms[0].name,
            kind,
            parent,
            link,
            first,
            freedoms[0].axis_J,
            tuple(filter(has_range, freedoms)),
        )

    def _anchor(self, element: Element, X_LF: RigidTransform) -> RigidTransform:
        """Return the pose of a joint in its body: that of the body, at its position."""
        position = np.array(attribute_triple(element, "pos", "0 0 0"))
        return RigidTransform(RotationMatrix(), X_LF.multiply(position))

    def _freedom(
        self,
        link: str,
        X_MJ: RigidTransform,
        X_ML: RigidTransform,
        element: Element,
        X_LF: RigidTransform,
    ) -> Freedom:
        """Return the freedom of one of the joints of a body, the first of which is at J."""
        kind = element.get("type", "hinge")
        if kind not in _KIND_BY_MJCF_JOINT:
            raise WorkbenchError(
                f"{element_location(element)}: <joint type='{shortened_text(kind)}'> of a body in "
                f"the drone: use {', '.join(_KIND_BY_MJCF_JOINT)}, or no joint"
            )
        axis = X_LF.rotation().multiply(np.array(attribute_triple(element, "axis", "0 0 1")))
        length = float(np.linalg.norm(axis))
        if length < 1e-9:
            where = element_location(element)
            raise WorkbenchError(f"{where}: <joint axis> is 0 0 0: give it a direction")
        x, y, z = (float(value) for value in axis / length)
        p_J = float_triple(X_MJ.InvertAndCompose(X_ML @ self._anchor(element, X_LF)).translation())
        scale = 1.0 if kind == "slide" or self._compiler.radians else math.pi / 180.0
        reference = attribute_number(element, "ref", "0")  # the position as the file has it
        name = element.get("name") or self.new_joint_name(f"{link}_joint")
        self.references[name] = scale * reference
        lower, upper = joint_range(element, self._compiler)
        damping, friction, stiffness, armature = (
            self._first_number(element, name, word)
            for word in ("damping", "frictionloss", "stiffness", "armature")
        )
        if kind == "ball" and armature:
            text = "armature of a ball joint: taken as 0"
            self._remarks.add("assumed", self._path, f"joint '{shortened_text(name)}'", text)
            armature = 0.0
        return Freedom(
            {"hinge": "revolute", "slide": "prismatic"}.get(kind, kind),
            (x, y, z),
            p_J,
            scale * (lower - reference),
            scale * (upper - reference),
            damping,
            friction,
            stiffness,
            scale * (attribute_number(element, "springref", "0") - reference),
            armature,
            name=name,
            effort=max(map(abs, stated_limits(element, "actuatorfrc", self._compiler))),
        )

    def _first_number(self, element: Element, joint: str, word: str) -> float:
        """Return a number of a joint; further ones, of a polynomial, get a remark."""
        first, *powers = attribute_numbers(element, word, "0") or (0.0,)
        if any(powers):
            text = f"'{shortened_text(element.get(word, ''))}': the first number acts alone"
            what = f"{word} of joint '{shortened_text(joint)}'"
            self._remarks.add("ignored", self._path, what, text)
        return first

    def _add_site(self, link: str, site: Element, X_LF: RigidTransform) -> None:
        name = site.get("name", "")
        if name and name in self.sites:
            raise WorkbenchError(
                f"{element_location(site)}: there are two sites named '{shortened_text(name)}': "
                "rename one"
            )
        pose = pose_of(site, self._compiler)
        if "fromto" in site.attrib:
            pose, _ = pose_from_two_points(site, site.get("type", "sphere"))
        self.sites[name] = (link, X_LF @ pose)

    def _shapes(self, geoms: list[_Geom]) -> tuple[tuple[LinkShape, ...], tuple[LinkShape, ...]]:
        """Return the visuals and the collisions of the geoms of a link."""
        visuals, collisions = [], []
        for geom in geoms:
            if geom.shape is None:
                continue
            rgba = self._colour(geom.element)
            if attribute_number(geom.element, "group", "0") < _FIRST_HIDDEN_GROUP and (
                not rgba or rgba[3] > 0.0
            ):
                visuals.append(LinkShape(geom.name, geom.X_LG, geom.shape, rgba))
            if any(
                attribute_number(geom.element, word, "1") for word in ("contype", "conaffinity")
            ):
                collisions.append(LinkShape(geom.name, geom.X_LG, geom.shape))
        return tuple(visuals), tuple(collisions)

    def _geom(
        self, link: str, index: int, element: Element, X_LF: RigidTransform, from_geoms: bool
    ) -> _Geom:
        """Return a geom as a shape and, if the mass of its link is that of its geoms, a solid."""
        name = element.get("name") or f"geom_{index}"
        what = f"geom '{shortened_text(name)}' of {link}"
        kind = element.get("type", "sphere")
        first, last = self._compiler.inertiagrouprange
        weighs = (
            from_geoms
            and first <= attribute_number(element, "group", "0") <= last
            and has_own_mass(element)
        )
        X_FG = pose_of(element, self._compiler)
        if kind == "mesh":
            X_GS, shape = self._meshes.shape(element)
            solid = self._mesh_solid(element, X_LF @ X_FG) if weighs else None
            return _Geom(name, element, X_LF @ X_FG @ X_GS, shape, solid)
        if kind not in _GEOM_SIZE_COUNTS:
            if weighs and kind != "plane":
                raise mjcf_error(
                    element, f"the mass of a {shortened_text(kind)} is not known: set it to 0"
                )
            self._remarks.add("ignored", self._path, what, f"a {shortened_text(kind)}; left out")
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
        return _Geom(
            name, element, X_LG, shape, geom_solid(element, X_LG, shape) if weighs else None
        )

    def _mesh_solid(self, element: Element, X_LG: RigidTransform) -> Inertial | None:
        """Return a mesh as a solid."""
        if is_true_attribute(element, "shellinertia", "false"):
            raise mjcf_error(
                element, "the shell of a mesh is its asset's: give <mesh> inertia='shell'"
            )
        mesh = self._meshes.inertia(element)
        X_LS = X_LG @ RigidTransform(RotationMatrix(mesh.R), mesh.p)
        mass = geom_mass(element, mesh.size)
        return solid_inertial(mass, X_LS, mesh.moments) if mass > MIN_GEOM_MASS_KG else None

    def _sized(
        self, element: Element, kind: str, pose: RigidTransform
    ) -> tuple[RigidTransform, GeometryShape]:
        """Return pose and shape of a geom given by its sizes, or by its ends."""
        size = list(attribute_numbers(element, "size", ""))
        if "fromto" in element.attrib:
            pose, length = pose_from_two_points(element, kind)
            size = [
                *size[:1],
                *([size[0]] if _GEOM_SIZE_COUNTS[kind] == 3 and size else []),
                length / 2.0,
            ]
        if len(size) < _GEOM_SIZE_COUNTS[kind] or min(size[: _GEOM_SIZE_COUNTS[kind]]) <= 0.0:
            raise mjcf_error(element, f"a {kind} has {_GEOM_SIZE_COUNTS[kind]} positive sizes")
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
            return mjcf_rgba(element)
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
