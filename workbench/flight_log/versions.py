"""What a flight depends on besides its scenario: versions and the machine."""

import platform
from importlib import metadata

PACKAGES = {
    "workbench": "drake-drone-workbench",
    "drake": "drake",
    "numpy": "numpy",
    "numba": "numba",
}
UNKNOWN = "unknown"


def versions() -> dict[str, str]:
    """Return the versions of what computes here, by name, and the platform."""
    found = {name: _version(package) for name, package in PACKAGES.items()}
    return found | {"python": platform.python_version(), "platform": platform.platform()}


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return UNKNOWN
