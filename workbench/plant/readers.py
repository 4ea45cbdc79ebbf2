"""What an installed package adds to read further descriptions, rotors and worlds.

Each of the three records is the object of an entry point, see `ExtensionGroup` and
docs/extending.md. Its module imports the reader itself only when it is called, as the records of
all packages are loaded to find the one that reads a file.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.common.errors import WorkbenchError
from workbench.common.extensions import ExtensionGroup, load_extensions

if TYPE_CHECKING:
    from workbench.plant.formats.xml import Element
    from workbench.plant.model import Model
    from workbench.plant.packages import PackageFinder
    from workbench.plant.remarks import Remarks
    from workbench.plant.rotors import Rotor
    from workbench.plant.worlds.world import World

URDF_SUFFIXES = (".xacro", ".urdf")
"""Suffixes of the descriptions that the core itself reads; no package reads these."""
_FORMATS_PACKAGE = "workbench.extras.formats"
"""The shipped package that reads what the core does not."""


def _no_file(folder: Path) -> Path | None:
    """Return None: no folder stands for a description."""
    return None


def _no_plugin(plugin: "Element") -> bool:
    """Return False: rotors are not in plugins."""
    return False


@dataclass(frozen=True)
class DescriptionFormat:
    """A format of descriptions besides URDF and xacro.

    Attributes:
        read: `read(path, root, finder, remarks)` returns the model in a file. `root` is its root
            element, which may be the result of xacro; None for a file that is known by its suffix.
            A fault of the file is a `WorkbenchError`.
        roots: root elements of XML in this format.
        suffixes: suffixes of files that are in this format whatever is in them.
        find_in_folder: returns the description in a folder that stands for one, else None.
        folder_mark: name of the file that such a folder has, for messages.
    """

    read: "Callable[[Path, Element | None, PackageFinder, Remarks], Model]"
    roots: tuple[str, ...] = ()
    suffixes: tuple[str, ...] = ()
    find_in_folder: Callable[[Path], Path | None] = _no_file
    folder_mark: str = ""


@dataclass(frozen=True)
class RotorDialect:
    """A way to write rotors in a description, asked after those of the core.

    Attributes:
        declares: returns whether a model has rotors of this dialect.
        read: `read(model, base_link, remarks)` returns them, in axes of the base link's frame. A
            fault of the file is a `WorkbenchError`.
        element: what they are written in, for remarks, such as "properties".
        reads_plugin: returns whether a `<plugin>` element is one of this dialect.
    """

    declares: "Callable[[Model], bool]"
    read: "Callable[[Model, str, Remarks], tuple[Rotor, ...]]"
    element: str
    reads_plugin: "Callable[[Element], bool]" = _no_plugin


@dataclass(frozen=True)
class WorldFormat:
    """A format of worlds besides our own YAML.

    Attributes:
        read: `read(path, packages)` returns the world in a file, with further folders of packages
            by name. A fault of the file is a `WorkbenchError`.
        suffixes: suffixes of files in this format.
        owner: whose format it is, for messages, such as "Gazebo".
    """

    read: "Callable[[Path, Mapping[str, Path | str]], World]"
    suffixes: tuple[str, ...]
    owner: str


def description_formats() -> tuple[DescriptionFormat, ...]:
    """Return the formats that installed packages add, by name."""
    return tuple(load_extensions(ExtensionGroup.FORMATS, DescriptionFormat).values())


def format_of_suffix(suffix: str) -> DescriptionFormat | None:
    """Return the format that a file has by its suffix, None if its content decides."""
    if suffix in URDF_SUFFIXES:
        return None
    return next((each for each in description_formats() if suffix in each.suffixes), None)


def format_of_root(tag: str) -> DescriptionFormat | None:
    """Return the format of XML with a root element, or None."""
    return next((each for each in description_formats() if tag in each.roots), None)


def rotor_dialects() -> tuple[RotorDialect, ...]:
    """Return the dialects that installed packages add, by name."""
    return tuple(load_extensions(ExtensionGroup.ROTOR_DIALECTS, RotorDialect).values())


def world_formats() -> tuple[WorldFormat, ...]:
    """Return the formats that installed packages add, by name."""
    return tuple(load_extensions(ExtensionGroup.WORLDS, WorldFormat).values())


def missing_reader(path: Path, what: str) -> WorkbenchError:
    """Return the error for a file that a shipped package reads which is not installed."""
    return WorkbenchError(
        f"{path}: it looks like {what}, which the package {_FORMATS_PACKAGE} reads: install a "
        "workbench that has it"
    )
