"""An MJCF file with its includes and defaults resolved, and poses as its attributes say them."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydrake.common.eigen_geometry import AngleAxis, Quaternion
from pydrake.math import RigidTransform, RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import numbers, shortened, triple
from workbench.plant.formats.xml import MOST_ELEMENTS, Element, place, read_xml

DEEPEST = 20
"""Files that include each other."""
_ORIENTATIONS = ("quat", "axisangle", "xyaxes", "zaxis", "euler")
_MAIN = "main"
"""The class of defaults that holds where no other is named."""


@dataclass(frozen=True)
class Compiler:
    """What `<compiler>` says of how the rest is meant.

    Attributes:
        radians: whether angles are in radians; else in degrees.
        eulerseq: axes of Euler angles in their order, capitals for those fixed in space.
        meshdir: folder of meshes.
        autolimits: whether a range without a word on limits is one.
        inertiafromgeom: `auto`, `true` or `false`.
    """

    radians: bool = False
    eulerseq: str = "xyz"
    meshdir: str = ""
    autolimits: bool = True
    inertiafromgeom: str = "auto"


def read_compiler(path: Path, root: Element) -> Compiler:
    """Return what all `<compiler>` elements say, the last of each word.

    Raises:
        WorkbenchError: for Euler angles about no axes.
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


def with_includes(path: Path, root: Element) -> Element:
    """Return a document with what it includes in the place of its `<include>` elements.

    Files are looked for beside the one that was asked for, as MuJoCo does.

    Raises:
        WorkbenchError: naming the include that leads nowhere, in a circle, or too deep.
    """
    return _Includer(path).resolved(root, (path,))


class _Includer:
    """Counts what is included, so that it stays within bounds."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._count = 0

    def resolved(self, element: Element, files: tuple[Path, ...]) -> Element:
        """Return a copy of an element of the last of some files."""
        self._count += 1
        if self._count > MOST_ELEMENTS:
            raise WorkbenchError(f"{self._path}: with includes there are too many elements")
        copy = Element(element.tag, element.attrib)
        copy.text = element.text
        copy.line = element.line
        if len(files) > 1:  # lines are those of the file that was asked for
            copy.line, copy.owner = 0, f"{files[-1].name}:{element.line}"
        for child in element:
            if isinstance(child, Element) and child.tag == "include":
                copy.extend(self._included(child, files))
            elif isinstance(child, Element):
                copy.append(self.resolved(child, files))
        return copy

    def _included(self, include: Element, files: tuple[Path, ...]) -> Element:
        where = place(files[-1], include)
        name = include.get("file", "")
        file = self._path.parent / name
        if not name or not file.is_file():
            raise WorkbenchError(f"{where}: <include file='{shortened(name)}'>: no such file")
        if file.resolve() in [each.resolve() for each in files] or len(files) > DEEPEST:
            raise WorkbenchError(f"{where}: <include file='{shortened(name)}'> goes in a circle")
        root = read_xml(file)
        if root.tag not in ("mujoco", "mujocoinclude"):
            raise WorkbenchError(
                f"{file}: the root element is <{shortened(root.tag)}>, an included MJCF has "
                "<mujoco> or <mujocoinclude>"
            )
        return self.resolved(root, (*files, file))


class Defaults:
    """Attributes that elements have where they do not say otherwise.

    Args:
        path: for messages.
        root: of the document.
    """

    def __init__(self, path: Path, root: Element) -> None:
        self._path = path
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
        """Return an element with the attributes that its class gives it.

        Args:
            element: whose own attributes count more.
            childclass: the class of the bodies around it, "" for none.

        Raises:
            WorkbenchError: if its class is not there.
        """
        name = element.get("class") or childclass or _MAIN
        if name not in self._classes:
            raise WorkbenchError(
                f"{place(self._path, element)}: <{element.tag}> has the class "
                f"'{shortened(name)}', which no <default> is of: add it"
            )
        known = self._classes[name]
        words = known.get(element.tag, {})
        if element.tag == "motor":  # one of the shortcuts of MuJoCo for <general>
            words = known.get("general", {}) | words
        copy = Element(element.tag, words | element.attrib)
        copy.line, copy.owner = element.line, element.owner
        return copy


def pose_of(path: Path, element: Element, compiler: Compiler) -> RigidTransform:
    """Return the pose that an element's attributes give, in the frame of what is around it.

    Raises:
        WorkbenchError: for what is no position or orientation.
    """
    position = triple(path, element, "pos", "0 0 0")
    return RigidTransform(_orientation(path, element, compiler), np.array(position))


def _orientation(path: Path, element: Element, compiler: Compiler) -> RotationMatrix:
    given = [name for name in _ORIENTATIONS if name in element.attrib]
    if not given:
        return RotationMatrix()
    if len(given) > 1:
        raise WorkbenchError(
            f"{place(path, element)}: <{element.tag}> has {' and '.join(given)}: leave one"
        )
    (name,) = given
    sizes = {"quat": 4, "axisangle": 4, "xyaxes": 6, "zaxis": 3, "euler": 3}
    values = np.array(numbers(path, element, name, ""))
    if len(values) != sizes[name]:
        raise _fault(path, element, name, f"give it {sizes[name]} numbers")
    turn = 1.0 if compiler.radians else math.pi / 180.0
    match name:
        case "quat":
            return RotationMatrix(Quaternion(_unit(path, element, name, values)))
        case "axisangle":
            axis = _unit(path, element, name, values[:3])
            return RotationMatrix(AngleAxis(turn * values[3], axis))
        case "xyaxes":
            x = _unit(path, element, name, values[:3])
            y = _unit(path, element, name, values[3:] - x * (x @ values[3:]))
            return RotationMatrix(np.column_stack([x, y, np.cross(x, y)]))
        case "zaxis":
            z = _unit(path, element, name, values)
            return shortest_to(z)
    return _euler(turn * values, compiler.eulerseq)


def _euler(angles: np.ndarray, sequence: str) -> RotationMatrix:
    """Return the orientation of Euler angles, about moved axes or, in capitals, fixed ones."""
    turned = RotationMatrix()
    for angle, axis in zip(angles, sequence, strict=True):
        unit = np.eye(3)["xyz".index(axis.lower())]
        one = RotationMatrix(AngleAxis(float(angle), unit))
        turned = one @ turned if axis.isupper() else turned @ one
    return turned


def shortest_to(z: np.ndarray) -> RotationMatrix:
    """Return the orientation of the shortest turn from z to a unit vector."""
    across = np.cross([0.0, 0.0, 1.0], z)
    length = float(np.linalg.norm(across))
    axis = across / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
    return RotationMatrix(AngleAxis(math.atan2(length, float(z[2])), axis))


def _unit(path: Path, element: Element, name: str, values: np.ndarray) -> np.ndarray:
    length = float(np.linalg.norm(values))
    if length < 1e-9:
        raise _fault(path, element, name, "give it a direction")
    return np.asarray(values / length)


def _fault(path: Path, element: Element, name: str, advice: str) -> WorkbenchError:
    text = shortened(element.get(name, ""))
    return WorkbenchError(f"{place(path, element)}: <{element.tag} {name}='{text}'>: {advice}")


def elements(parent: Element, *tags: str) -> Iterator[Element]:
    """Yield the children of these tags, of all tags where none is given."""
    for child in parent:
        if isinstance(child, Element) and (child.tag in tags or not tags):
            yield child
