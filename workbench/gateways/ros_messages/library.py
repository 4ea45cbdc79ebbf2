"""The definitions that are shipped: the files below msg/, one a type."""

from functools import cache
from pathlib import Path

from workbench.common.errors import unknown_name
from workbench.gateways.ros_messages.definitions import SEPARATOR, Definition, read_definition

FOLDER = Path(__file__).parent / "msg"


@cache
def type_names() -> tuple[str, ...]:
    """Return the names of all types, as std_msgs/msg/Header."""
    files = sorted(FOLDER.glob("*/*.msg"))
    return tuple(f"{file.parent.name}/msg/{file.stem}" for file in files)


@cache
def definition(name: str) -> Definition:
    """Return the definition of a type by its name, as std_msgs/msg/Header.

    Raises:
        WorkbenchError: if there is none.
    """
    if name not in type_names():
        raise unknown_name("type of message", name, type_names())
    package, _, plain = name.split("/")
    text = (FOLDER / package / f"{plain}.msg").read_text(encoding="utf-8")
    return read_definition(name, text)


@cache
def included(name: str) -> tuple[Definition, ...]:
    """Return the definitions of a type and of all that it includes, each once, itself first."""
    found: dict[str, Definition] = {}
    todo = [name]
    while todo:
        now = definition(todo.pop(0))
        if now.name not in found:
            found[now.name] = now
            todo += [field.type for field in now.fields if field.nested]
    return tuple(found.values())


@cache
def schema_text(name: str) -> str:
    """Return a type's definition followed by all that it includes, as files and viewers want it."""
    first, *others = included(name)
    parts = [
        f"{SEPARATOR}\nMSG: {other.name.replace('/msg/', '/')}\n{other.text}" for other in others
    ]
    return first.text + "".join(parts)
