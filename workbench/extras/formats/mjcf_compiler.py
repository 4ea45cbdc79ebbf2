"""Settings of MuJoCo's compiler in an MJCF file."""

from dataclasses import dataclass
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.mjcf_elements import (
    attribute_fault,
    elements,
    is_true_attribute,
    keyword_attribute,
)
from workbench.plant.formats.values import attribute_number, attribute_numbers, shortened_text
from workbench.plant.formats.xml import Element


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
        raise WorkbenchError(f"{path}: <compiler eulerseq='{shortened_text(eulerseq)}'>: use xyz")
    keyword_attribute(every, "coordinate", "local", "local")
    groups = attribute_numbers(every, "inertiagrouprange", "0 5")
    if len(groups) != 2:
        raise attribute_fault(every, "inertiagrouprange", "give it two groups")
    return Compiler(
        radians=keyword_attribute(every, "angle", "degree", "degree radian") == "radian",
        eulerseq=eulerseq,
        meshdir=every.get("meshdir", every.get("assetdir", "")),
        strippath=is_true_attribute(every, "strippath", "false"),
        autolimits=is_true_attribute(every, "autolimits", "true"),
        inertiafromgeom=keyword_attribute(every, "inertiafromgeom", "auto", "auto true false"),
        inertiagrouprange=(groups[0], groups[1]),
        boundmass=attribute_number(every, "boundmass", "0"),
        boundinertia=attribute_number(every, "boundinertia", "0"),
        balanceinertia=is_true_attribute(every, "balanceinertia", "false"),
        settotalmass=attribute_number(every, "settotalmass", "-1"),
        exactmeshinertia=is_true_attribute(every, "exactmeshinertia", "false"),
        fitaabb=is_true_attribute(every, "fitaabb", "false"),
    )
