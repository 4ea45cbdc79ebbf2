"""The document of an MJCF file as MuJoCo sees it: includes, copies, settings and defaults."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from pydrake.common.eigen_geometry import AngleAxis, Quaternion
from pydrake.math import RigidTransform, RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import number, numbers, shortened, triple
from workbench.plant.formats.xml import MOST_ELEMENTS, Element, place, read_xml
from workbench.plant.packages import PackageFinder

DEEPEST = 20
"""Largest depth of nested includes."""
MOST_COPIES = 20_000
"""Largest number of elements that `<replicate>` makes, more than any drone has."""
ORIENTATIONS = {"quat": 4, "axisangle": 4, "xyaxes": 6, "zaxis": 3, "euler": 3}
"""Attributes of an orientation, and how many numbers each has."""
ACTUATORS = (
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "orientation",
    "pid",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "dcmotor",
    "plugin",
)
"""Elements of actuators."""
_ACTUATOR = "actuator"
"""Defaults of all kinds of actuators are of one object, as in MuJoCo."""
_MAIN = "main"
"""The default class of elements that name no other."""
_PARTIAL = ("size", "gear", "gainprm", "biasprm", "dynprm")
"""Attributes whose first numbers alone may be given; a default keeps the others."""


@dataclass(frozen=True)
class Compiler:
    """The settings in `<compiler>` that decide poses, masses and inertias.

    Attributes:
        radians: whether angles are in radians, and not in degrees.
        eulerseq: sequence of the axes of Euler angles, capitals for axes fixed in space.
        meshdir: folder of meshes.
        strippath: whether the path of a mesh's file is removed.
        autolimits: whether a range is a limit without `limited`.
        inertiafromgeom: `auto`, `true` or `false`.
        inertiagrouprange: first and last group of geoms with mass.
        boundmass: smallest mass of a body [kg].
        boundinertia: smallest principal moment of inertia of a body [kg·m²].
        balanceinertia: whether moments that no body can have become their mean.
        settotalmass: mass of all bodies in the file [kg], as they are if not positive.
        exactmeshinertia: whether signed volumes count for a mesh without `inertia`; a setting of
            MuJoCo 2 and 3.
        fitaabb: whether a shape is fitted to the bounding box of a mesh, not to its inertia.
    """

    radians: bool = False
    eulerseq: str = "xyz"
    meshdir: str = ""
    strippath: bool = False
    autolimits: bool = True
    inertiafromgeom: str = "auto"
    inertiagrouprange: tuple[float, float] = (0.0, 5.0)
    boundmass: float = 0.0
    boundinertia: float = 0.0
    balanceinertia: bool = False
    settotalmass: float = -1.0
    exactmeshinertia: bool = False
    fitaabb: bool = False


def read_compiler(path: Path, root: Element) -> Compiler:
    """Return the settings in all `<compiler>` elements; the last value of an attribute counts.

    Raises:
        WorkbenchError: naming a setting with an invalid value.
    """
    every = Element("compiler")
    every.file = path
    for element in elements(root, "compiler"):
        every.attrib |= element.attrib
        every.line = element.line
    eulerseq = every.get("eulerseq", "xyz")
    if len(eulerseq) != 3 or set(eulerseq.lower()) - set("xyz"):
        raise WorkbenchError(f"{path}: <compiler eulerseq='{shortened(eulerseq)}'>: use xyz")
    chosen(every, "coordinate", "local", "local")
    groups = numbers(every, "inertiagrouprange", "0 5")
    if len(groups) != 2:
        raise fault(every, "inertiagrouprange", "give it two groups")
    return Compiler(
        radians=chosen(every, "angle", "degree", "degree radian") == "radian",
        eulerseq=eulerseq,
        meshdir=every.get("meshdir", every.get("assetdir", "")),
        strippath=is_true(every, "strippath", "false"),
        autolimits=is_true(every, "autolimits", "true"),
        inertiafromgeom=chosen(every, "inertiafromgeom", "auto", "auto true false"),
        inertiagrouprange=(groups[0], groups[1]),
        boundmass=number(every, "boundmass", "0"),
        boundinertia=number(every, "boundinertia", "0"),
        balanceinertia=is_true(every, "balanceinertia", "false"),
        settotalmass=number(every, "settotalmass", "-1"),
        exactmeshinertia=is_true(every, "exactmeshinertia", "false"),
        fitaabb=is_true(every, "fitaabb", "false"),
    )


def chosen(element: Element, name: str, default: str, known: str) -> str:
    """Return an attribute with one of some values, which are given as words.

    Raises:
        WorkbenchError: if it has another.
    """
    value = element.get(name, default)
    if value not in known.split():
        raise fault(element, name, f"use {' or '.join(known.split())}")
    return value


def is_true(element: Element, name: str, default: str) -> bool:
    """Return whether an attribute is `true`.

    Raises:
        WorkbenchError: if it is neither `true` nor `false`.
    """
    return chosen(element, name, default, "true false") == "true"


def fault(element: Element, name: str, advice: str) -> WorkbenchError:
    """Return an error about an attribute of an element."""
    text = shortened(element.get(name, ""))
    return WorkbenchError(f"{place(element)}: <{element.tag} {name}='{text}'>: {advice}")


def with_includes(path: Path, root: Element, finder: PackageFinder) -> Element:
    """Return a document with its `<include>` elements replaced by the included content.

    Paths are relative to the main file, or else to the including one, as in MuJoCo.

    Raises:
        WorkbenchError: naming an include of a missing file, of one that the description may not
            read, of one twice, or nested too deeply.
    """
    return _Includes(path, finder).resolved(root, (path,))


class _Includes:
    """Copies elements, with the content of included files.

    Args:
        main: the main file.
        finder: knows which files the description may read.
    """

    def __init__(self, main: Path, finder: PackageFinder) -> None:
        self._main = main
        self._finder = finder
        self._numbered = count(1)
        self._seen: set[Path] = set()

    def resolved(self, element: Element, files: tuple[Path, ...]) -> Element:
        """Return a copy of an element of the last of the files that lead to it, main file first."""
        if next(self._numbered) > MOST_ELEMENTS:
            raise WorkbenchError(f"{self._main}: with includes there are too many elements")
        copy = element.like(element.attrib)
        copy.text = element.text
        if len(files) > 1:  # messages name the main file
            copy.file, copy.line = self._main, 0
            copy.owner = f"{files[-1].name}:{element.line}"
        for child in elements(element):
            if child.tag == "include":
                file = self._included(child, files)
                copy.extend(self.resolved(_included_root(file), (*files, file)))
            else:
                copy.append(self.resolved(child, files))
        return copy

    def _included(self, include: Element, files: tuple[Path, ...]) -> Path:
        """Return the file of an include."""
        name = include.get("file", "")
        what = f"{place(include)}: <include file='{shortened(name)}'>"
        file = next(
            (
                each.parent / name
                for each in (files[0], files[-1])
                if (each.parent / name).is_file()
            ),
            None,
        )
        if not name or file is None:
            raise WorkbenchError(f"{what}: no such file")
        if file.resolve() in [each.resolve() for each in files] or len(files) > DEEPEST:
            raise WorkbenchError(f"{what} includes itself")
        if file.resolve() in self._seen:
            raise WorkbenchError(f"{what}: it is included already, which MuJoCo refuses")
        self._finder.allowed(file, what)
        self._seen.add(file.resolve())
        return file


def _included_root(file: Path) -> Element:
    root = read_xml(file)
    if root.tag not in ("mujoco", "mujocoinclude"):
        raise WorkbenchError(
            f"{file}: the root element is <{shortened(root.tag)}>, an included MJCF has "
            "<mujoco> or <mujocoinclude>"
        )
    return root


@dataclass
class Copies:
    """The names that `<replicate>` gave.

    Attributes:
        earlier: for the name of each copy, those that it had before, the one in the file first.
    """

    earlier: dict[str, list[str]] = field(default_factory=dict)

    def suffixes(self, name: str) -> list[str]:
        """Return what was added to a name for each of its copies, "" if there are none."""
        found = [copy.removeprefix(name) for copy, names in self.earlier.items() if name in names]
        return found or [""]


def without_replicates(root: Element, compiler: Compiler) -> tuple[Element, Copies]:
    """Return a document with each `<replicate>` replaced by a `<frame>` for each copy.

    The i-th copy is turned by i times `euler`, and shifted from the one before by `offset`, turned
    like that one. Names get the number of the copy, with as many digits as `count` has (MuJoCo's
    user guide, replicate; mjXReader::Body).

    Args:
        root: without includes.
        compiler: its settings.

    Raises:
        WorkbenchError: for an invalid count, or too many copies.
    """
    copies = Copies()
    numbered = count(1)

    def copied(element: Element) -> Element:
        copy = element.like(element.attrib)
        copy.text = element.text
        copy.extend(list(content(element)))  # a list: 3.11 hides errors of generators
        return copy

    def content(element: Element) -> Iterator[Element]:
        for child in elements(element):
            if child.tag == "replicate":
                yield from replicated(child)
            else:
                yield copied(child)

    def replicated(element: Element) -> Iterator[Element]:
        for name in element.attrib.keys() - {"count", "euler", "offset", "sep", "childclass"}:
            raise fault(element, name, "MuJoCo has no such attribute: leave it out")
        times = number(element, "count")
        if times != int(times) or not 0 <= times <= MOST_COPIES:
            raise fault(element, "count", f"give it the number of copies, up to {MOST_COPIES}")
        if any(child.tag == "inertial" for child in elements(element)):
            raise WorkbenchError(
                f"{place(element)}: <replicate> has an <inertial>, which a body has once: move it "
                "out, or into a <body>"
            )
        angles = np.array(triple(element, "euler", "0 0 0"))
        offset = np.array(triple(element, "offset", "0 0 0"))
        scale = 1.0 if compiler.radians else math.pi / 180.0
        childclass = {
            name: element.attrib[name] for name in ["childclass"] if name in element.attrib
        }
        p = np.zeros(3)
        originals = list(content(element))
        for index in range(int(times)):
            limit(element)
            R = _euler(scale * index * angles, compiler.eulerseq)
            words = {"pos": _text(p), "quat": _text(R.ToQuaternion().wxyz())}
            frame = element.like(words | childclass)
            frame.tag = "frame"
            suffix = f"{element.get('sep', '')}{index:0{len(str(int(times)))}}"
            frame.extend([renamed(child, suffix) for child in originals])
            yield frame
            p = p + R.multiply(offset)
        for site in (site for child in originals for site in child.iter("site")):
            copies.earlier.pop(site.get("name", ""), None)

    def limit(element: Element) -> None:
        if next(numbered) > MOST_COPIES:
            raise WorkbenchError(
                f"{place(element)}: <replicate> would make more than {MOST_COPIES} elements"
            )

    def renamed(element: Element, suffix: str) -> Element:
        limit(element)
        copy = element.like(element.attrib)
        name = element.get("name")
        if name:
            copy.set("name", name + suffix)
            if element.tag == "site":
                copies.earlier[name + suffix] = [*copies.earlier.get(name, []), name]
        copy.extend([renamed(child, suffix) for child in elements(element)])
        return copy

    return copied(root), copies


def _text(values: np.ndarray) -> str:
    return " ".join(map(repr, values.tolist()))


class Defaults:
    """The default attributes of elements, by class.

    Args:
        root: of the document.

    Raises:
        WorkbenchError: for a class that is defined twice, or a top-level one with a name of its
            own.
    """

    def __init__(self, root: Element) -> None:
        self._classes: dict[str, dict[str, dict[str, str]]] = {_MAIN: {}}
        for element in elements(root, "default"):
            if element.get("class", _MAIN) != _MAIN:
                raise fault(element, "class", "the class of a top-level <default> is main")
            self._collect(element, _MAIN, self._classes[_MAIN])

    def _collect(self, element: Element, name: str, above: Mapping[str, Mapping[str, str]]) -> None:
        known = {tag: dict(words) for tag, words in above.items()}
        for child in elements(element):
            if child.tag == "default":
                continue
            tag = _ACTUATOR if child.tag in ACTUATORS else child.tag
            words = _merged(known.get(tag, {}), child.attrib)
            if child.tag in ACTUATORS:
                words = _as_kind(child.tag, words)
            known[tag] = words
        self._classes[name] = known
        for child in elements(element, "default"):
            inner = child.get("class", "")
            if inner in self._classes or not inner:
                raise fault(child, "class", "give it a name that no other <default> has")
            self._collect(child, inner, known)

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
        is_actuator = element.tag in ACTUATORS
        known = self._classes[name].get(_ACTUATOR if is_actuator else element.tag, {})
        words = _merged(known, element.attrib)
        return element.like(_as_kind(element.tag, words) if is_actuator else words)


def _merged(known: Mapping[str, str], own: Mapping[str, str]) -> dict[str, str]:
    """Return default attributes with those of an element in their place."""
    words = dict(known)
    if any(name in own for name in ORIENTATIONS):
        for name in ORIENTATIONS:
            words.pop(name, None)
    for name, text in own.items():
        if name in _PARTIAL and name in words:
            given = text.split()
            text = " ".join([*given, *words[name].split()[len(given) :]])
        words[name] = text
    return words


def _as_kind(tag: str, words: dict[str, str]) -> dict[str, str]:
    """Return the attributes of an actuator with what its kind implies (mjs_setToMotor)."""
    if tag == "motor":
        gains = " ".join(["1", *words.get("gainprm", "").split()[1:]])
        implied = {"gainprm": gains, "gaintype": "fixed", "biastype": "none", "dyntype": "none"}
        return {name: text for name, text in words.items() if name != _SERVO} | implied
    return words if tag == "general" else words | {_SERVO: tag}


_SERVO = "-kind"
"""Mark of defaults that a kind other than a motor set; not a name that XML allows."""


def servo_of(element: Element) -> str:
    """Return the kind of actuator, other than motor and general, that set an actuator's gains."""
    return element.get(_SERVO, "")


def pose_of(element: Element, compiler: Compiler) -> RigidTransform:
    """Return the pose of an element in the frame of its parent.

    Raises:
        WorkbenchError: for an invalid position or orientation.
    """
    position = triple(element, "pos", "0 0 0")
    return RigidTransform(_orientation(element, compiler), np.array(position))


def _orientation(element: Element, compiler: Compiler) -> RotationMatrix:
    given = [name for name in ORIENTATIONS if name in element.attrib]
    if not given:
        return RotationMatrix()
    if len(given) > 1:
        raise WorkbenchError(
            f"{place(element)}: <{element.tag}> has {' and '.join(given)}: leave one"
        )
    (name,) = given
    values = np.array(numbers(element, name, ""))
    if len(values) != ORIENTATIONS[name]:
        raise fault(element, name, f"give it {ORIENTATIONS[name]} numbers")
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
        raise fault(element, name, "give it a direction")
    return np.asarray(values / length)


def elements(parent: ElementTree.Element, *tags: str) -> Iterator[Element]:
    """Yield the children with one of these tags; all children without tags."""
    for child in parent:
        if isinstance(child, Element) and (child.tag in tags or not tags):
            yield child


def elements_of(root: Element, group: str, *tags: str) -> Iterator[Element]:
    """Yield the children of all elements of a group, such as `asset`, see `elements`."""
    for block in elements(root, group):
        yield from elements(block, *tags)
