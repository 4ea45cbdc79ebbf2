"""Read MJCF, MuJoCo's own format: the body that flies, and the actuators at its sites."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.mjcf_schema import note_unused
from workbench.plant.formats.mjcf_shapes import GeomReader
from workbench.plant.formats.mjcf_words import (
    Compiler,
    Defaults,
    elements,
    pose_of,
    read_compiler,
    with_includes,
)
from workbench.plant.formats.solids import together
from workbench.plant.formats.values import listed, number, numbers, shortened, triple
from workbench.plant.formats.xml import Element, place
from workbench.plant.model import DeclaredActuator, Inertial, Joint, Link, Model
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks

_KINDS = {"hinge": "continuous", "slide": "prismatic", "ball": "ball"}
_ACTUATORS = ("motor", "general")
"""Whose force does not depend on how the body moves."""


def read_mjcf(path: Path, root: Element, finder: PackageFinder, remarks: Remarks) -> Model:
    """Return what an MJCF file says of the one body in it that is free.

    Poses, inertias and defaults mean what they mean to Drake's parser. The model frame is that of
    the free body: where it stands in its world, a scenario says.

    Args:
        path: the file, for messages and relative paths.
        root: its root element.
        finder: of meshes.
        remarks: where to note what is left out.

    Raises:
        WorkbenchError: naming file and element of what cannot be read.
    """
    root = with_includes(path, root)
    note_unused(path, root, remarks)
    defaults, compiler = Defaults(path, root), read_compiler(path, root)
    shapes = GeomReader(path, root, compiler, defaults, finder, remarks)
    reader = _Bodies(path, compiler, defaults, shapes, remarks)
    reader.add(_free_body(path, root, remarks), RigidTransform(), "", "")
    return Model(
        source=path,
        name=root.get("model") or path.name.partition(".")[0],
        links=tuple(reader.links),
        joints=tuple(reader.joints),
        frames=(),
        sensors=(),
        plugins=(),
        actuators=tuple(_actuators(path, root, compiler, defaults, reader.sites, remarks)),
    )


def _free_body(path: Path, root: Element, remarks: Remarks) -> Element:
    """Return the body of the world that moves freely, and note what stands around it."""
    tops = [body for world in root.findall("worldbody") for body in _bodies(world)]
    free = [body for body in tops if any(map(_is_free, body.iter()))]
    if not free:
        names = listed([body.get("name", "without a name") for body in tops])
        raise WorkbenchError(
            f"{path}: no body in <worldbody> has a <freejoint/>, and a drone flies freely: add it "
            f"to one of {names}"
            if tops
            else f"{path}: there is no <body> in <worldbody>: add one"
        )
    if len(free) > 1:
        raise WorkbenchError(
            f"{path}: several bodies move freely: {listed([b.get('name', '') for b in free])}: "
            "give the drone's own file"
        )
    geoms = len(root.findall("worldbody/geom"))
    others = [shortened(body.get("name", "")) for body in tops if body is not free[0]]
    if others or geoms:
        parts = [f"bodies {listed(others)}"] if others else []
        parts += [f"{geoms} geoms"] if geoms else []
        text = f"'{shortened(free[0].get('name', ''))}' is the one that flies; left out are "
        remarks.add("ignored", path, "what stands in the world", text + " and ".join(parts))
    return free[0]


def _bodies(parent: object) -> Iterator[Element]:
    """Yield the bodies directly in a world or in its frames."""
    assert isinstance(parent, Element)
    for child in elements(parent, "body", "frame"):
        if child.tag == "body":
            yield child
        else:
            yield from _bodies(child)


def _is_free(element: object) -> bool:
    assert isinstance(element, Element)
    return element.tag == "freejoint" or (element.tag == "joint" and element.get("type") == "free")


@dataclass
class _Parts:
    """What a body has directly in it, or in frames: each with the frame its pose is given in."""

    bodies: list[tuple[Element, RigidTransform, str]] = field(default_factory=list)
    geoms: list[tuple[Element, RigidTransform]] = field(default_factory=list)
    joints: list[tuple[Element, RigidTransform]] = field(default_factory=list)
    sites: list[tuple[Element, RigidTransform]] = field(default_factory=list)
    inertial: tuple[Element, RigidTransform] | None = None


@dataclass
class _Bodies:
    """Collects links, joints and sites of a body and of those in it."""

    path: Path
    compiler: Compiler
    defaults: Defaults
    geoms: GeomReader
    remarks: Remarks
    links: list[Link] = field(default_factory=list)
    joints: list[Joint] = field(default_factory=list)
    sites: dict[str, tuple[str, RigidTransform]] = field(default_factory=dict)

    def add(self, body: Element, X_ML: RigidTransform, parent: str, childclass: str) -> None:
        """Add a body.

        Args:
            body: its element.
            X_ML: its pose.
            parent: the link that it hangs on, "" for the one that flies.
            childclass: of the bodies around it.
        """
        name = body.get("name") or f"body_{len(self.links)}"
        if any(link.name == name for link in self.links):
            raise WorkbenchError(
                f"{place(self.path, body)}: there are two bodies named '{shortened(name)}': "
                "rename one"
            )
        parts = _Parts()
        self._collect(body, RigidTransform(), body.get("childclass", childclass), parts)
        inertial = self._inertial(name, parts)
        self.links.append(Link(name, X_ML, inertial, *self.geoms.shapes(name, parts.geoms)))
        if parent:
            self.joints.append(self._joint(name, parent, X_ML, parts.joints))
        for site, X_LF in parts.sites:
            X_LS = X_LF @ pose_of(self.path, site, self.compiler)
            self.sites[site.get("name", "")] = (name, X_LS)
        for child, X_LF, inherited in parts.bodies:
            pose = pose_of(self.path, child, self.compiler)
            self.add(child, X_ML @ X_LF @ pose, name, inherited)

    def _collect(
        self, parent: Element, X_LF: RigidTransform, childclass: str, parts: _Parts
    ) -> None:
        """Collect what a body or frame has in it, with defaults applied."""
        for child in elements(parent):
            match child.tag:
                case "body":
                    parts.bodies.append((child, X_LF, childclass))
                case "frame":
                    inside = X_LF @ pose_of(self.path, child, self.compiler)
                    self._collect(child, inside, child.get("childclass", childclass), parts)
                case "inertial":
                    parts.inertial = (child, X_LF)
                case "geom":
                    parts.geoms.append((self.defaults.applied(child, childclass), X_LF))
                case "joint":
                    parts.joints.append((self.defaults.applied(child, childclass), X_LF))
                case "site":
                    parts.sites.append((self.defaults.applied(child, childclass), X_LF))

    def _inertial(self, link: str, parts: _Parts) -> Inertial | None:
        """Return mass and inertia of a body, of its geoms where it gives none."""
        word = self.compiler.inertiafromgeom
        if parts.inertial and word != "true":
            return self._given_inertial(*parts.inertial)
        solids = [] if word == "false" else self.geoms.solids(link, parts.geoms)
        return together(solids) if solids else None

    def _given_inertial(self, element: Element, X_LF: RigidTransform) -> Inertial:
        X_LI = X_LF @ pose_of(self.path, element, self.compiler)
        mass = number(self.path, element, "mass")
        if "fullinertia" in element.attrib:
            values = numbers(self.path, element, "fullinertia", "")
            if len(values) != 6:
                raise WorkbenchError(
                    f"{place(self.path, element)}: <inertial fullinertia>: give it six numbers"
                )
            xx, yy, zz, xy, xz, yz = values
            return Inertial(mass, X_LI, (xx, yy, zz), (xy, xz, yz))
        moments = triple(self.path, element, "diaginertia", "0 0 0")
        return Inertial(mass, X_LI, moments, (0.0, 0.0, 0.0))

    def _joint(
        self,
        link: str,
        parent: str,
        X_ML: RigidTransform,
        joints: list[tuple[Element, RigidTransform]],
    ) -> Joint:
        """Return how a body hangs on another: by its first joint, fixed where it has none."""
        if not joints:
            return Joint(f"{link}_weld", "fixed", parent, link, X_ML, (0.0, 0.0, 1.0))
        for other, _ in joints[1:]:
            text = f"a further joint of '{shortened(link)}'; left out"
            what = f"joint '{shortened(other.get('name', ''))}'"
            self.remarks.add("ignored", self.path, what, text)
        element, X_LF = joints[0]
        axis = X_LF.rotation().multiply(np.array(triple(self.path, element, "axis", "0 0 1")))
        length = float(np.linalg.norm(axis))
        if length < 1e-9:
            raise WorkbenchError(
                f"{place(self.path, element)}: <joint axis> is 0 0 0: give it a direction"
            )
        x, y, z = (float(value) for value in axis / length)
        position = np.array(triple(self.path, element, "pos", "0 0 0"))
        X_LJ = RigidTransform(RotationMatrix(), X_LF.multiply(position))
        kind = element.get("type", "hinge")
        name = element.get("name") or f"{link}_joint"
        return Joint(name, _KINDS.get(kind, kind), parent, link, X_ML @ X_LJ, (x, y, z))


def _actuators(
    path: Path,
    root: Element,
    compiler: Compiler,
    defaults: Defaults,
    sites: dict[str, tuple[str, RigidTransform]],
    remarks: Remarks,
) -> Iterator[DeclaredActuator]:
    """Yield the actuators that push or turn a site, whatever the body does."""
    for index, child in enumerate(
        element for block in root.iterfind("actuator") for element in _elements(block)
    ):
        element = defaults.applied(child, "")
        name = element.get("name") or f"actuator_{index}"
        what = f"actuator '{shortened(name)}'"
        site = element.get("site", "")
        if child.tag not in _ACTUATORS or not site or "refsite" in element.attrib:
            text = f"a <{shortened(child.tag)}> that pushes no site of the drone; not used"
            remarks.add("ignored", path, what, text)
            continue
        if site not in sites:
            raise WorkbenchError(
                f"{place(path, element)}: {what} is at the site '{shortened(site)}', which the "
                f"drone has not: sites are {listed(list(sites))}"
            )
        gear = [*numbers(path, element, "gear", "1 0 0 0 0 0"), *[0.0] * 6][:6]
        gain = numbers(path, element, "gainprm", "1")[0] if element.tag == "general" else 1.0
        link, X_LS = sites[site]
        yield DeclaredActuator(
            name=name,
            link=link,
            X_LS=X_LS,
            force_S=(gain * gear[0], gain * gear[1], gain * gear[2]),
            moment_S=(gain * gear[3], gain * gear[4], gain * gear[5]),
            most=_most(path, element, gain, compiler),
            time_constant=_lag(path, element),
        )


def _elements(block: object) -> Iterator[Element]:
    assert isinstance(block, Element)
    yield from elements(block)


def _most(path: Path, element: Element, gain: float, compiler: Compiler) -> float | None:
    """Return the largest control of an actuator, None where it has no limit."""
    found = []
    for word, scale in (("ctrl", 1.0), ("force", abs(gain) or 1.0)):
        limited = element.get(f"{word}limited", "auto")
        given = f"{word}range" in element.attrib
        if limited == "true" or (limited == "auto" and compiler.autolimits and given):
            values = numbers(path, element, f"{word}range", "0 0")
            if len(values) != 2 or values[1] <= values[0]:
                raise WorkbenchError(
                    f"{place(path, element)}: <{element.tag} {word}range="
                    f"'{shortened(element.get(f'{word}range', ''))}'>: give it two numbers, the "
                    "smaller first"
                )
            found.append(max(values[1], 0.0) / scale)
    return min(found) if found else None


def _lag(path: Path, element: Element) -> float | None:
    """Return the time constant of an actuator with a first-order filter [s], None without."""
    if element.get("dyntype") not in ("filter", "filterexact"):
        return None
    value = numbers(path, element, "dynprm", "1")[0]
    return value if value > 0.0 else None
