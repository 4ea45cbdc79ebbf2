"""Read MJCF, the format of MuJoCo: the free body, and the actuators at its sites."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import count
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

import numpy as np
from pydrake.common.eigen_geometry import AngleAxis, Quaternion
from pydrake.math import RigidTransform, RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.colours import Colour
from workbench.plant.formats.solids import Solid, together, volume
from workbench.plant.formats.values import listed, number, numbers, shortened, triple
from workbench.plant.formats.xml import MOST_ELEMENTS, Element, place, read_xml
from workbench.plant.model import DeclaredActuator, Inertial, Joint, Link, LinkShape, Model
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, Mesh, Shape, Sphere

DEEPEST = 20
"""Largest depth of nested includes."""
_ORIENTATIONS = ("quat", "axisangle", "xyaxes", "zaxis", "euler")
_MAIN = "main"
"""The default class of elements that name no other."""
_SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3, "ellipsoid": 3}
_DRAWN = 3
"""First group that is not drawn, as in MuJoCo's viewer and Drake's parser."""
_FRAME = "name class pos quat axisangle xyaxes zaxis euler"
_USED = {
    "mujoco": "compiler default asset worldbody actuator",
    "worldbody": "body geom frame",
    "body": "body frame inertial joint freejoint geom site",
    "frame": "body frame inertial joint freejoint geom site",
    "asset": "mesh material",
}
"""Children that are read, by parent."""
_WORDS = {
    "compiler": "angle eulerseq meshdir assetdir texturedir autolimits inertiafromgeom",
    "body": f"{_FRAME} childclass",
    "frame": f"{_FRAME} childclass",
    "inertial": f"{_FRAME} mass diaginertia fullinertia",
    "joint": "name class type pos axis group range limited",
    "freejoint": "name group align",
    "geom": f"{_FRAME} type size fromto mass density mesh rgba material group contype conaffinity",
    "site": f"{_FRAME} type size rgba material group fromto",
    "mesh": "name class file scale",
    "material": "name class rgba",
    "motor": "name class site gear ctrlrange ctrllimited forcerange forcelimited group dyntype "
    "dynprm gainprm gaintype biastype joint body tendon",
}
"""Attributes that are read or irrelevant for flight, by element."""
_WORDS["general"] = _WORDS["motor"]
_WHY = {
    "option": "gravity, air and integrator are those of the workbench",
    "sensor": "sensors are added as docs/sensors.md says",
    "keyframe": "a scenario says how a flight begins",
    "contact": "friction and stiffness of the ground are those of the workbench",
    "camera": "cameras are not drawn",
    "light": "lights are not drawn",
    "visual": "pictures are those of the workbench",
    "statistic": "pictures are those of the workbench",
    "texture": "only colours are drawn",
}
_MOST = 50
"""Largest number of remarks on unused parts."""
_KINDS = {"hinge": "continuous", "slide": "prismatic", "ball": "ball"}
_ACTUATORS = ("motor", "general")
"""Actuators with a force that is independent of the motion of the body."""


@dataclass(frozen=True)
class Compiler:
    """The settings in `<compiler>`.

    Attributes:
        radians: whether angles are in radians, and not in degrees.
        eulerseq: sequence of the axes of Euler angles, capitals for axes fixed in space.
        meshdir: folder of meshes.
        autolimits: whether a range is a limit without `limited`.
        inertiafromgeom: `auto`, `true` or `false`.
    """

    radians: bool = False
    eulerseq: str = "xyz"
    meshdir: str = ""
    autolimits: bool = True
    inertiafromgeom: str = "auto"


def read_compiler(path: Path, root: Element) -> Compiler:
    """Return the settings in all `<compiler>` elements; the last value of an attribute counts.

    Raises:
        WorkbenchError: if the sequence of Euler angles is invalid.
    """
    words: dict[str, str] = {}
    for element in root.iterfind("compiler"):
        words |= element.attrib
    eulerseq = words.get("eulerseq", "xyz")
    if len(eulerseq) != 3 or set(eulerseq.lower()) - set("xyz"):
        raise WorkbenchError(f"{path}: <compiler eulerseq='{shortened(eulerseq)}'>: use xyz")
    return Compiler(
        radians=words.get("angle", "degree") == "radian",
        eulerseq=eulerseq,
        meshdir=words.get("meshdir", words.get("assetdir", "")),
        autolimits=words.get("autolimits", "true") == "true",
        inertiafromgeom=words.get("inertiafromgeom", "auto"),
    )


def with_includes(path: Path, root: Element, finder: PackageFinder) -> Element:
    """Return a document with its `<include>` elements replaced by the included content.

    Paths are relative to the main file, as in MuJoCo.

    Raises:
        WorkbenchError: naming an include of a missing file or one that the description may not
            read, in a circle, or nested too deeply.
    """
    return _resolved(root, (path,), count(1), finder)


def _resolved(
    element: Element, files: tuple[Path, ...], numbered: Iterator[int], finder: PackageFinder
) -> Element:
    """Return a copy of an element without includes.

    Args:
        element: in the last of the files.
        files: that lead to it, the main one first.
        numbered: counts the elements of all files.
        finder: knows which files the description may read.
    """
    main = files[0]
    if next(numbered) > MOST_ELEMENTS:
        raise WorkbenchError(f"{main}: with includes there are too many elements")
    copy = element.like(element.attrib)
    copy.text = element.text
    if len(files) > 1:  # messages name the main file
        copy.file, copy.line = main, 0
        copy.owner = f"{files[-1].name}:{element.line}"
    for child in elements(element):
        if child.tag == "include":
            file = _included(child, files, finder)
            copy.extend(_resolved(_included_root(file), (*files, file), numbered, finder))
        else:
            copy.append(_resolved(child, files, numbered, finder))
    return copy


def _included(include: Element, files: tuple[Path, ...], finder: PackageFinder) -> Path:
    """Return the file of an include."""
    name = include.get("file", "")
    what = f"{place(include)}: <include file='{shortened(name)}'>"
    file = files[0].parent / name
    if not name or not file.is_file():
        raise WorkbenchError(f"{what}: no such file")
    if file.resolve() in [each.resolve() for each in files] or len(files) > DEEPEST:
        raise WorkbenchError(f"{what} includes itself")
    finder.allowed(file, what)
    return file


def _included_root(file: Path) -> Element:
    root = read_xml(file)
    if root.tag not in ("mujoco", "mujocoinclude"):
        raise WorkbenchError(
            f"{file}: the root element is <{shortened(root.tag)}>, an included MJCF has "
            "<mujoco> or <mujocoinclude>"
        )
    return root


class Defaults:
    """The default attributes of elements, by class.

    Args:
        root: of the document.
    """

    def __init__(self, root: Element) -> None:
        self._classes: dict[str, dict[str, dict[str, str]]] = {_MAIN: {}}
        for element in elements(root, "default"):
            self._collect(element, element.get("class", _MAIN), {})

    def _collect(self, element: Element, name: str, above: Mapping[str, Mapping[str, str]]) -> None:
        known = {tag: dict(words) for tag, words in above.items()}
        for child in element:
            if child.tag != "default":
                known[child.tag] = known.get(child.tag, {}) | child.attrib
        self._classes[name] = self._classes.get(name, {}) | known
        for child in elements(element, "default"):
            self._collect(child, child.get("class", ""), known)

    def applied(self, element: Element, childclass: str) -> Element:
        """Return a copy of an element with the default attributes of its class.

        Args:
            element: its own attributes take precedence.
            childclass: default class in its body, "" for none.

        Raises:
            WorkbenchError: if its class does not exist.
        """
        name = element.get("class") or childclass or _MAIN
        if name not in self._classes:
            raise WorkbenchError(
                f"{place(element)}: <{element.tag}> has the class "
                f"'{shortened(name)}', which no <default> defines: add it"
            )
        known = self._classes[name]
        words = known.get(element.tag, {})
        if element.tag == "motor":  # one of the shortcuts of MuJoCo for <general>
            words = known.get("general", {}) | words
        return element.like(words | element.attrib)


def pose_of(element: Element, compiler: Compiler) -> RigidTransform:
    """Return the pose of an element in the frame of its parent.

    Raises:
        WorkbenchError: for an invalid position or orientation.
    """
    position = triple(element, "pos", "0 0 0")
    return RigidTransform(_orientation(element, compiler), np.array(position))


def _orientation(element: Element, compiler: Compiler) -> RotationMatrix:
    given = [name for name in _ORIENTATIONS if name in element.attrib]
    if not given:
        return RotationMatrix()
    if len(given) > 1:
        raise WorkbenchError(
            f"{place(element)}: <{element.tag}> has {' and '.join(given)}: leave one"
        )
    (name,) = given
    sizes = {"quat": 4, "axisangle": 4, "xyaxes": 6, "zaxis": 3, "euler": 3}
    values = np.array(numbers(element, name, ""))
    if len(values) != sizes[name]:
        raise _fault(element, name, f"give it {sizes[name]} numbers")
    turn = 1.0 if compiler.radians else math.pi / 180.0
    match name:
        case "quat":
            return RotationMatrix(Quaternion(_unit(element, name, values)))
        case "axisangle":
            axis = _unit(element, name, values[:3])
            return RotationMatrix(AngleAxis(turn * values[3], axis))
        case "xyaxes":
            x = _unit(element, name, values[:3])
            y = _unit(element, name, values[3:] - x * (x @ values[3:]))
            return RotationMatrix(np.column_stack([x, y, np.cross(x, y)]))
        case "zaxis":
            z = _unit(element, name, values)
            return shortest_to(z)
    return _euler(turn * values, compiler.eulerseq)


def _euler(angles: np.ndarray, sequence: str) -> RotationMatrix:
    """Return the orientation for Euler angles, about moved axes or, in capitals, fixed ones."""
    turned = RotationMatrix()
    for angle, axis in zip(angles, sequence, strict=True):
        unit = np.eye(3)["xyz".index(axis.lower())]
        one = RotationMatrix(AngleAxis(float(angle), unit))
        turned = one @ turned if axis.isupper() else turned @ one
    return turned


def shortest_to(z: np.ndarray) -> RotationMatrix:
    """Return the shortest rotation from z to a unit vector."""
    across = np.cross([0.0, 0.0, 1.0], z)
    length = float(np.linalg.norm(across))
    axis = across / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
    return RotationMatrix(AngleAxis(math.atan2(length, float(z[2])), axis))


def _unit(element: Element, name: str, values: np.ndarray) -> np.ndarray:
    length = float(np.linalg.norm(values))
    if length < 1e-9:
        raise _fault(element, name, "give it a direction")
    return np.asarray(values / length)


def _fault(element: Element, name: str, advice: str) -> WorkbenchError:
    text = shortened(element.get(name, ""))
    return WorkbenchError(f"{place(element)}: <{element.tag} {name}='{text}'>: {advice}")


def elements(parent: ElementTree.Element, *tags: str) -> Iterator[Element]:
    """Yield the children with one of these tags; all children without tags."""
    for child in parent:
        if isinstance(child, Element) and (child.tag in tags or not tags):
            yield child


def elements_of(root: Element, group: str, *tags: str) -> Iterator[Element]:
    """Yield the children of all elements of a group, such as `asset`, see `elements`."""
    for block in elements(root, group):
        yield from elements(block, *tags)


def _rgba(element: Element) -> Colour:
    values = numbers(element, "rgba", "")
    if len(values) != 4:
        raise WorkbenchError(
            f"{place(element)}: <{element.tag} rgba='{shortened(element.get('rgba', ''))}'>: "
            "give it four numbers"
        )
    r, g, b, a = (min(1.0, max(0.0, value)) for value in values)
    return (r, g, b, a)


def note_unused(path: Path, root: Element, remarks: Remarks) -> None:
    """Add remarks on elements and attributes that are not read, one for each name.

    Children of an element that is not read are skipped. Attributes in defaults are treated like
    those of the elements.
    """
    found: Counter[tuple[str, str]] = Counter()
    _count(root, found)
    for (what, why), times in list(found.items())[:_MOST]:
        often = "" if times == 1 else f" ({times} times)"
        remarks.add("ignored", path, what, f"{why}; not used{often}")


def _count(element: Element, found: Counter[tuple[str, str]]) -> None:
    """Count the unread parts of an element and of its descendants."""
    for child in elements(element):
        tag = child.tag
        known = _USED.get(element.tag)
        if known is not None and tag not in known.split():
            if len(child) or child.attrib:
                why = _WHY.get(tag, "not known here")
                words = " ".join(sorted(child.attrib)) if tag == "option" else ""
                found[f"element <{shortened(tag)}>{words and f' ({words})'}", why] += 1
            continue
        for name in child.attrib:
            if tag in _WORDS and name not in _WORDS[tag].split():
                found[f"attribute {shortened(name)} of <{tag}>", "not read"] += 1
        _count(child, found)


def read_mjcf(path: Path, root: Element, finder: PackageFinder, remarks: Remarks) -> Model:
    """Return the free body in an MJCF file as a model.

    Poses, inertias and defaults are interpreted as by Drake's parser. The model frame is that of
    the free body; its pose in the file is not used, as a scenario defines it.

    Args:
        path: the file, for messages and relative paths.
        root: its root element.
        finder: of meshes.
        remarks: receives remarks on unused parts.

    Raises:
        WorkbenchError: naming file and element, for invalid content.
    """
    root = with_includes(path, root, finder)
    note_unused(path, root, remarks)
    reader = _Reader(path, root, finder, remarks)
    reader.add(_free_body(path, root, remarks), RigidTransform(), "", "")
    return Model(
        source=path,
        name=root.get("model") or path.name.partition(".")[0],
        links=tuple(reader.links),
        joints=tuple(reader.joints),
        frames=(),
        sensors=(),
        plugins=(),
        actuators=tuple(reader.actuators(root)),
    )


def _free_body(path: Path, root: Element, remarks: Remarks) -> Element:
    """Return the free body of the world, and add a remark on other bodies and geoms."""
    tops = [body for world in elements(root, "worldbody") for body in _bodies(world)]
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
            "give a file with the drone alone"
        )
    geoms = len(root.findall("worldbody/geom"))
    others = [shortened(body.get("name", "")) for body in tops if body is not free[0]]
    if others or geoms:
        parts = [f"bodies {listed(others)}"] if others else []
        parts += [f"{geoms} geoms"] if geoms else []
        text = f"'{shortened(free[0].get('name', ''))}' flies; left out are "
        remarks.add("ignored", path, "objects of the world", text + " and ".join(parts))
    return free[0]


def _bodies(parent: Element) -> Iterator[Element]:
    """Yield the bodies directly in a world or in its frames."""
    for child in elements(parent, "body", "frame"):
        if child.tag == "body":
            yield child
        else:
            yield from _bodies(child)


def _is_free(element: ElementTree.Element) -> bool:
    return element.tag == "freejoint" or (element.tag == "joint" and element.get("type") == "free")


Placed = tuple[Element, RigidTransform]
"""A part of a body, with the pose X_LF of the frame in its link that its pose is given in."""


class _Reader:
    """Reads links, joints, sites and actuators of a body and its descendants.

    Args:
        path: of the file.
        root: of the document.
        finder: of meshes.
        remarks: receives remarks on unusable parts.
    """

    def __init__(self, path: Path, root: Element, finder: PackageFinder, remarks: Remarks) -> None:
        self._path = path
        self._remarks = remarks
        self._compiler = read_compiler(path, root)
        self._defaults = Defaults(root)
        self._meshes: dict[str, Mesh] = {}
        self._colours: dict[str, Colour] = {}
        self._sites: dict[str, tuple[str, RigidTransform]] = {}
        self.links: list[Link] = []
        self.joints: list[Joint] = []
        for asset in elements_of(root, "asset", "mesh"):
            element = self._defaults.applied(asset, "")
            file = element.get("file", "")
            name = element.get("name") or PurePosixPath(file).stem
            found = finder.resolve(str(PurePosixPath(self._compiler.meshdir) / file), path)
            scale = triple(element, "scale", "1 1 1")
            self._meshes[name] = Mesh(file, found if file else None, scale)
        for asset in elements_of(root, "asset", "material"):
            if "rgba" in asset.attrib:
                self._colours[asset.get("name", "")] = _rgba(asset)

    def add(self, body: Element, X_ML: RigidTransform, parent: str, childclass: str) -> None:
        """Add a body.

        Args:
            body: its element.
            X_ML: its pose.
            parent: its parent link, "" for the free body.
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

        geoms = parts("geom")
        inertial = self._inertial(name, parts("inertial")[-1:], geoms)
        self.links.append(Link(name, X_ML, inertial, *self._shapes(name, geoms)))
        if parent:
            self.joints.append(self._joint(name, parent, X_ML, parts("joint")))
        for site, X_LF in parts("site"):
            X_LS = X_LF @ pose_of(site, self._compiler)
            self._sites[site.get("name", "")] = (name, X_LS)
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

    def _inertial(self, link: str, given: list[Placed], geoms: list[Placed]) -> Inertial | None:
        """Return mass and inertia of a body, computed from its geoms if it states none."""
        word = self._compiler.inertiafromgeom
        if given and word != "true":
            return self._given_inertial(*given[0])
        solids = [] if word == "false" else self._solids(link, geoms)
        return together(solids) if solids else None

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
        name = element.get("name") or f"{link}_joint"
        return Joint(name, _KINDS.get(kind, kind), parent, link, X_ML @ X_LJ, (x, y, z))

    def actuators(self, root: Element) -> Iterator[DeclaredActuator]:
        """Yield the actuators that apply a force or moment at a site."""
        for index, child in enumerate(elements_of(root, "actuator")):
            element = self._defaults.applied(child, "")
            name = element.get("name") or f"actuator_{index}"
            what = f"actuator '{shortened(name)}'"
            site = element.get("site", "")
            if child.tag not in _ACTUATORS or not site or "refsite" in element.attrib:
                text = (
                    f"a <{shortened(child.tag)}> that does not push a site of the drone; not used"
                )
                self._remarks.add("ignored", self._path, what, text)
                continue
            if site not in self._sites:
                raise WorkbenchError(
                    f"{place(element)}: {what} is at the site '{shortened(site)}', which the drone "
                    f"does not have: sites are {listed(list(self._sites))}"
                )
            gear = [*numbers(element, "gear", "1 0 0 0 0 0"), *[0.0] * 6][:6]
            gain = numbers(element, "gainprm", "1")[0] if element.tag == "general" else 1.0
            link, X_LS = self._sites[site]
            yield DeclaredActuator(
                name=name,
                link=link,
                X_LS=X_LS,
                force_S=(gain * gear[0], gain * gear[1], gain * gear[2]),
                moment_S=(gain * gear[3], gain * gear[4], gain * gear[5]),
                most=_most(element, gain, self._compiler.autolimits),
                time_constant=_lag(element),
            )

    def _shapes(
        self, link: str, geoms: list[Placed]
    ) -> tuple[tuple[LinkShape, ...], tuple[LinkShape, ...]]:
        """Return the visuals and the collisions of the geoms of a link."""
        visuals, collisions = [], []
        for name, element, X_LG, shape in self._geoms(link, geoms):
            rgba = self._colour(element)
            if number(element, "group", "0") < _DRAWN and (not rgba or rgba[3] > 0.0):
                visuals.append(LinkShape(name, X_LG, shape, rgba))
            if any(number(element, word, "1") for word in ("contype", "conaffinity")):
                collisions.append(LinkShape(name, X_LG, shape))
        return tuple(visuals), tuple(collisions)

    def _solids(self, link: str, geoms: list[Placed]) -> list[Solid]:
        """Return the geoms of a link with mass as solids."""
        return [
            solid
            for name, element, X_LG, shape in self._geoms(link, geoms)
            for solid in self._solid(element, X_LG, shape, f"geom '{shortened(name)}'")
        ]

    def _geoms(
        self, link: str, geoms: list[Placed]
    ) -> Iterator[tuple[str, Element, RigidTransform, Shape]]:
        """Yield name, element, pose and shape of the geoms with a supported shape."""
        for index, (element, X_LF) in enumerate(geoms):
            name = element.get("name") or f"geom_{index}"
            X_FG, shape = self._shape(element, f"geom '{shortened(name)}' of '{shortened(link)}'")
            if shape is not None:
                yield name, element, X_LF @ X_FG, shape

    def _shape(self, element: Element, what: str) -> tuple[RigidTransform, Shape | None]:
        """Return the pose of a geom and its shape, None for an unsupported one."""
        kind = element.get("type", "sphere")
        pose = pose_of(element, self._compiler)
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
        """Return pose and shape of a geom given by its sizes, or by its ends."""
        size = list(numbers(element, "size", ""))
        if "fromto" in element.attrib and kind != "sphere":
            ends = numbers(element, "fromto", "")
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
        """Return a geom as a solid, or nothing if it has no mass."""
        given = number(element, "mass") if "mass" in element.attrib else None
        density = number(element, "density", "1000")
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
            return _rgba(element)
        return self._colours.get(element.get("material", ""))

    def _fault(self, element: Element, text: str) -> WorkbenchError:
        return WorkbenchError(f"{place(element)}: <geom>: {text}")


def _most(element: Element, gain: float, autolimits: bool) -> float | None:
    """Return the largest control of an actuator, None without a limit."""
    found = []
    for word, scale in (("ctrl", 1.0), ("force", abs(gain) or 1.0)):
        limited = element.get(f"{word}limited", "auto")
        given = f"{word}range" in element.attrib
        if limited == "true" or (limited == "auto" and autolimits and given):
            values = numbers(element, f"{word}range", "0 0")
            if len(values) != 2 or values[1] <= values[0]:
                raise WorkbenchError(
                    f"{place(element)}: <{element.tag} {word}range="
                    f"'{shortened(element.get(f'{word}range', ''))}'>: give it two numbers, the "
                    "smaller first"
                )
            found.append(max(values[1], 0.0) / scale)
    return min(found) if found else None


def _lag(element: Element) -> float | None:
    """Return the time constant of an actuator with a first-order filter [s], None without."""
    if element.get("dyntype") not in ("filter", "filterexact"):
        return None
    value = numbers(element, "dynprm", "1")[0]
    return value if value > 0.0 else None
