"""Find links and joints by names in plugins, which may lack scopes or have additional ones."""

from collections.abc import Sequence

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import listed_names, shortened_text
from workbench.plant.model import Joint, Link, Model

_SCOPE_SEPARATORS = ("::", "/")


def find_joint(model: Model, name: str, where: str) -> Joint:
    """Return the joint for a name in a plugin.

    Args:
        model: with the joint.
        name: as in the plugin.
        where: the beginning of a message.

    Raises:
        WorkbenchError: if it is unknown or ambiguous.
    """
    return model.joints[
        _index_of_name("joint", [joint.name for joint in model.joints], name, where)
    ]


def find_link(model: Model, name: str, where: str) -> Link:
    """Return the link for a name in a plugin; arguments and errors as for `find_joint`."""
    return model.links[_index_of_name("link", [link.name for link in model.links], name, where)]


def same_name(one: str, other: str) -> bool:
    """Return whether two names are equal, except for scopes missing in one of them."""
    return one == other or _has_scope(one, other) or _has_scope(other, one)


def _has_scope(short: str, long: str) -> bool:
    """Return whether a longer name is a shorter one with a scope."""
    return bool(short) and any(long.endswith(f"{scope}{short}") for scope in _SCOPE_SEPARATORS)


def _index_of_name(kind: str, known: Sequence[str], name: str, where: str) -> int:
    """Return the index of the equal name, or of the only name with more or fewer scopes."""
    if name in known:
        return known.index(name)
    found = [index for index, other in enumerate(known) if _has_scope(name, other)]
    if len(found) == 1:
        return found[0]
    if found:
        raise WorkbenchError(
            f"{where}: the {kind} '{shortened_text(name)}' could be any of "
            f"{listed_names([known[index] for index in found])}: give the whole name"
        )
    inner = [index for index, other in enumerate(known) if _has_scope(other, name)]
    if inner:
        return max(inner, key=lambda index: len(known[index]))
    raise WorkbenchError(
        f"{where}: the {kind} '{shortened_text(name)}' does not exist: "
        + (f"{kind}s are {listed_names(known)}" if known else f"there are no {kind}s")
    )
