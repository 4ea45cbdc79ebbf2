"""Names and files of the parts of a spec; fast to import while pytest collects tests."""

from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.common.resources import existing, find_spec, list_specs, specs_dir
from workbench.common.yaml_files import read_yaml

SUFFIX = ".spec.yaml"
"""Suffix of the name of a spec."""
MARGINS = "margins"
"""The name of the part with the margins of loops."""


def find_specs(names: list[str]) -> list[Path]:
    """Return the specs for files, folders and shipped names; without any, the shipped ones.

    Raises:
        WorkbenchError: for a name that is none of these, and for a folder without a spec.
    """
    found: list[Path] = []
    for name in names or list_specs():
        folder = None if name in list_specs() else existing(name)
        if folder is not None and folder.is_dir():
            inside = sorted(folder.glob(f"*{SUFFIX}"))
            if not inside:
                raise WorkbenchError(f"{name}: has no file named *{SUFFIX}: name another folder")
            found += inside
        else:
            found.append(find_spec(name))
    return list(dict.fromkeys(found))


def spec_name(path: Path) -> str:
    """Return the name of a spec, as used on the command line for a shipped one."""
    return path.name.removesuffix(SUFFIX) if path.name.endswith(SUFFIX) else path.stem


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
    return names + [MARGINS] * bool(file.data.get("margins"))


def slug(name: str) -> str:
    """Return the name of a case in a form for file names."""
    return name.replace(" ", "-").lower()
