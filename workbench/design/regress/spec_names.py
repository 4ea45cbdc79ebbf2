"""Names and files of the parts of a spec; fast to import while pytest collects tests."""

import logging
from collections.abc import Iterable
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.common.resources import (
    SPEC_SUFFIX,
    existing_path,
    find_spec,
    list_specs,
    specs_dir,
)
from workbench.common.yaml_files import read_yaml

OLD_SPEC_SUFFIX = ".spec.yaml"
"""Suffix of the name of a spec before 1.0; read until 1.1."""
_log = logging.getLogger(__name__)
SPEC_SUFFIXES = (SPEC_SUFFIX, OLD_SPEC_SUFFIX)
MARGINS_PART = "margins"
"""The name of the part with the margins of loops."""


def find_specs(names: list[str]) -> list[Path]:
    """Return the specs for files, folders and shipped names; without any, the shipped ones.

    Raises:
        WorkbenchError: for a name that is none of these, and for a folder without a spec.
    """
    found: list[Path] = []
    for name in names or list_specs():
        folder = None if name in list_specs() else existing_path(name)
        if folder is not None and folder.is_dir():
            inside = sorted(path for suffix in SPEC_SUFFIXES for path in folder.glob(f"*{suffix}"))
            if not inside:
                raise WorkbenchError(
                    f"{name}: has no file named *{SPEC_SUFFIX}: name another folder"
                )
            found += inside
        else:
            found.append(find_spec(name))
    note_old_names(found)
    return list(dict.fromkeys(found))


def note_old_names(paths: Iterable[Path]) -> None:
    """Say once which specs have a name of the form before 1.0."""
    old = [path.name for path in paths if path.name.endswith(OLD_SPEC_SUFFIX)]
    if old:
        others = f" and {len(old) - 1} more" if len(old) > 1 else ""
        _log.warning(
            "%s%s: specs are named *%s now; *%s is read until 1.1",
            old[0],
            others,
            SPEC_SUFFIX,
            OLD_SPEC_SUFFIX,
        )


def spec_name(path: Path) -> str:
    """Return the name of a spec, as used on the command line for a shipped one."""
    for suffix in SPEC_SUFFIXES:
        if path.name.endswith(suffix):
            return path.name.removesuffix(suffix)
    return path.stem


def spec_title(path: Path) -> str:
    """Return the name of a spec for results, with its file unless it is shipped."""
    return spec_name(path) if path.parent == specs_dir() else path.name


def part_names(path: Path) -> list[str]:
    """Return the names of the cases of a spec, and `margins` if it has limits on those.

    Only these are read and checked; `load_spec` does the rest.

    Raises:
        WorkbenchError: if it cannot be read, or a case has no name.
    """
    file = read_yaml(path)
    cases = file.data.get("cases") or []
    if not isinstance(cases, list):
        raise WorkbenchError(f"{file.where('cases')}cases should be a list")
    names = []
    for index, case in enumerate(cases):
        name = case.get("name") if isinstance(case, dict) else None
        if not isinstance(name, str):
            raise WorkbenchError(f"{file.where('cases', index)}a case needs a name in text")
        names.append(name)
    return names + [MARGINS_PART] * bool(file.data.get("margins"))


def slug(name: str) -> str:
    """Return the name of a case in a form for file names."""
    return name.replace(" ", "-").lower()
