"""The packages that pip installs with the project, as their own metadata say."""

import re
import tomllib
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement

PROJECT = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]


def required_with(extra: str) -> set[str]:
    """Return the names of all packages that pip installs with an extra, or without one: ""."""
    todo = [(PROJECT["name"], frozenset({extra} - {""}))]
    seen = set(todo)
    while todo:
        name, extras = todo.pop()
        for it in requirements_of(name, extras):
            more = (canonical(it.name), frozenset(it.extras))
            if more not in seen:
                seen.add(more)
                todo.append(more)
    return {name for name, _ in seen}


def requirements_of(name: str, extras: frozenset[str]) -> list[Requirement]:
    """Return what a package requires here with some of its extras."""
    if name == PROJECT["name"]:
        chosen = [PROJECT["optional-dependencies"][extra] for extra in extras]
        lines = sum(chosen, PROJECT["dependencies"])
    else:
        lines = metadata.requires(name) or []
    every = [Requirement(line) for line in lines]
    return [
        it
        for it in every
        if it.marker is None or any(it.marker.evaluate({"extra": each}) for each in {"", *extras})
    ]


def canonical(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()
