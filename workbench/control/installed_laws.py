"""The laws that are installed, with the workbench or another package: their names and files."""

from functools import cache
from importlib.util import find_spec
from pathlib import Path

from workbench.common.extensions import (
    ExtensionGroup,
    complete_extensions,
    find_extensions,
    is_complete,
)
from workbench.common.resources import controllers_dir
from workbench.control.schedule import split_label

DEFAULT_CONTROLLER = "pd"
SHIPPED_CONTROLLERS = ("pd", "pid", "lqi", "geometric", "indi")
"""The core's own laws; installed packages add others, see `installed_laws`."""
LAW_GROUPS = (ExtensionGroup.LAWS, ExtensionGroup.LAW_PROGRAMS)


@cache
def installed_laws() -> tuple[str, ...]:
    """Return the names of all laws with repeatable flights: the core's, then other packages'."""
    return (*SHIPPED_CONTROLLERS, *_names_in(ExtensionGroup.LAWS))


@cache
def installed_programs() -> tuple[str, ...]:
    """Return the names of laws that are separate programs: their flights are not repeatable."""
    return _names_in(ExtensionGroup.LAW_PROGRAMS)


def known_laws() -> tuple[str, ...]:
    """Return the names of all laws, those that are separate programs last."""
    return (*installed_laws(), *installed_programs())


def _names_in(group: ExtensionGroup) -> tuple[str, ...]:
    return tuple(name for name in complete_extensions(group) if name not in SHIPPED_CONTROLLERS)


def is_shipped(name: str) -> bool:
    """Return whether a name is that of a law of the core or of another package, scheduled or not.

    A package whose module is missing counts, too: `load_controller` names it.
    """
    law = split_label(name)[0]
    if law in SHIPPED_CONTROLLERS:
        return True
    return not law.endswith(".py") and law_group_of(law) is not None


def law_group_of(name: str) -> ExtensionGroup | None:
    """Return the group that an installed package states a law in, None for any other name."""
    return next((each for each in LAW_GROUPS if name in find_extensions(each)), None)


@cache
def shipped_file(name: str) -> Path | None:
    """Return the file of a law of the core or of another package; None if it is not there."""
    if name in SHIPPED_CONTROLLERS:
        return controllers_dir() / f"{name}.py"
    group = law_group_of(name)
    entry = find_extensions(group)[name] if group else None
    spec = find_spec(entry.module) if entry and is_complete(entry) else None
    return Path(spec.origin) if spec and spec.origin else None
