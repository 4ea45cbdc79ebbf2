"""Packages that only an extra of the workbench brings, see docs/install.md."""

from importlib.util import find_spec

from workbench.common.errors import WorkbenchError

EXTRA_OF_PACKAGE = {
    "PyQt6": "app",
    "embreex": "lidar",
    "numba": "sweep",
    "websockets": "web",
}
"""The extra of `pyproject.toml` that brings each package."""


def has_package(name: str) -> bool:
    """Return whether a package is installed; nothing of it is imported."""
    return find_spec(name) is not None


def install_command(name: str) -> str:
    """Return the command that installs a package and what it is used with."""
    return f"pip install 'drake-drone-workbench[{EXTRA_OF_PACKAGE[name]}]'"


def require_package(name: str, what: str) -> None:
    """Check that a package is installed.

    Args:
        name: one of `EXTRA_OF_PACKAGE`.
        what: needs it, the beginning of a sentence, in the plural.

    Raises:
        WorkbenchError: with the command that installs it.
    """
    if not has_package(name):
        raise WorkbenchError(f"{what} need the package {name}: run `{install_command(name)}`")
