"""The locations of shipped models, gains, scenarios, worlds and specs."""

from pathlib import Path

from workbench.common.errors import WorkbenchError, unknown_name

PACKAGE_FOLDER = Path(__file__).parent.parent
SPEC_SUFFIX = ".workbench.yaml"
"""Suffix of the name of a spec."""


def models_dir() -> Path:
    """Return the folder of shipped models: in an installed package, else next to the source."""
    installed = PACKAGE_FOLDER / "models"
    return installed if installed.is_dir() else PACKAGE_FOLDER.parent / "models"


def docs_dir() -> Path:
    """Return the folder of the docs: in an installed package, else next to the source."""
    installed = PACKAGE_FOLDER / "docs"
    return installed if installed.is_dir() else PACKAGE_FOLDER.parent / "docs"


def controllers_dir() -> Path:
    """Return the folder of shipped controller files."""
    return PACKAGE_FOLDER / "controllers"


def worlds_dir() -> Path:
    """Return the folder of shipped worlds, `package://worlds` in world files."""
    return models_dir() / "worlds"


def find_model(name_or_path: str | Path) -> Path:
    """Return the description file for the name of a shipped model, or the file or folder at a path.

    Raises:
        WorkbenchError: if it is neither.
    """
    return _find(str(name_or_path), "model", list_models(), models_dir(), "{}/drone.urdf.xacro")


def find_scenario(name_or_path: str | Path) -> Path:
    """Return the YAML file for the name of a shipped scenario, or for a path.

    Raises:
        WorkbenchError: if it is neither.
    """
    folder = models_dir() / "scenarios"
    return _find(str(name_or_path), "scenario", list_scenarios(), folder, "{}.yaml")


def find_world(name_or_path: str) -> Path:
    """Return the file for the name of a shipped world, or for a path.

    Raises:
        WorkbenchError: if it is neither.
    """
    found = None if name_or_path in list_worlds() else existing_path(name_or_path)
    if found and found.is_dir():
        raise WorkbenchError(f"{name_or_path}: is a folder: give the world's file in it")
    return _find(name_or_path, "world", list_worlds(), worlds_dir(), "{}.yaml")


def specs_dir() -> Path:
    """Return the folder of shipped specs."""
    return models_dir() / "specs"


def find_spec(name_or_path: str) -> Path:
    """Return the YAML file for the name of a shipped spec, or for a path.

    Raises:
        WorkbenchError: if it is neither.
    """
    return _find(name_or_path, "spec", list_specs(), specs_dir(), f"{{}}{SPEC_SUFFIX}")


def find_file(path: str) -> Path:
    """Return the file at a path.

    Raises:
        WorkbenchError: if there is none.
    """
    file = _file(path)
    if file is None:
        raise WorkbenchError(f"{path}: no such file")
    return file


def list_models() -> list[str]:
    """Return the names of the shipped models."""
    return sorted(path.parent.name for path in models_dir().glob("*/drone.urdf.xacro"))


def list_scenarios() -> list[str]:
    """Return the names of the shipped scenarios."""
    return sorted(path.stem for path in (models_dir() / "scenarios").glob("*.yaml"))


def list_worlds() -> list[str]:
    """Return the names of the shipped worlds."""
    return sorted(path.stem for path in worlds_dir().glob("*.yaml"))


def list_specs() -> list[str]:
    """Return the names of the shipped specs."""
    return sorted(f.name.removesuffix(SPEC_SUFFIX) for f in specs_dir().glob(f"*{SPEC_SUFFIX}"))


def _find(name_or_path: str, kind: str, names: list[str], folder: Path, pattern: str) -> Path:
    """Return the file from `pattern` for a shipped name, else the path itself."""
    if name_or_path in names:
        return folder / pattern.format(name_or_path)
    file = existing_path(name_or_path) if kind == "model" else _file(name_or_path)
    if file is None:
        if "/" in name_or_path or Path(name_or_path).suffix:
            raise WorkbenchError(f"{name_or_path}: no such file, and no shipped {kind} either")
        raise WorkbenchError(f"{unknown_name(kind, name_or_path, names)}; nor is it a file")
    return file


def _file(path: str) -> Path | None:
    """Return the file at a path, or None if it does not exist or the path is invalid."""
    found = existing_path(path)
    return found if found and found.is_file() else None


def existing_path(path: str) -> Path | None:
    """Return the file or folder at a path, or None if it does not exist or the path is invalid.

    Raises:
        WorkbenchError: if it is a pipe or a device.
    """
    if not path.strip():  # which would mean the current folder
        return None
    try:
        found = Path(path).expanduser()
        if found.exists() and not found.is_file() and not found.is_dir():
            raise WorkbenchError(f"{path}: is a pipe or a device: name a plain file")
        return found.resolve() if found.exists() else None
    except (OSError, RuntimeError):  # a name too long, an unknown user
        return None
